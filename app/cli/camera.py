"""`keypose camera`: how the film's camera turned, zoomed and moved."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from keypose.app.cli.change import Change, run_change
from keypose.app.cli.json_output import print_written
from keypose.app.cli.long_work import share_reporter
from keypose.app.editor.moving_camera import forgotten
from keypose.app.jobs.find_camera import find_saved, found_words, with_found
from keypose.app.render.studio import png
from keypose.tracker.errors import CameraError
from keypose.tracker.operations.find_camera import FoundCamera, background_picture, with_known_way
from keypose.tracker.session import Session
from keypose.tracker.storage.atomic import require_absent, write_file
from keypose.tracker.storage.files import load_session, open_video_of


def run(arguments: argparse.Namespace) -> int:
    if arguments.background is not None:
        return _draw_background(arguments)
    return run_change(arguments, _found)


def _found(session: Session, arguments: argparse.Namespace) -> Change:
    if arguments.forget:
        return _change(None, forgotten(session), arguments)
    if arguments.went is not None and session.camera_path is not None:
        return _change(None, _with_way(session, arguments.went), arguments)
    with share_reporter(arguments.json) as report:
        found_camera = find_saved(session, arguments.session, arguments.kind, report)
    if arguments.went is not None:
        after = _with_way(with_found(session, found_camera), arguments.went)
        found_camera = replace(found_camera, motion=after.view.camera_motion)
    return _change(found_camera, with_found(session, found_camera), arguments)


def _with_way(session: Session, metres: float) -> Session:
    """The session whose camera went so far from where it began."""
    motion = session.view.camera_motion
    if motion is not None and len(motion.pieces) > 1:
        raise CameraError(
            "The camera's path is in several pieces: set how far it went in each in the page."
        )
    return with_known_way(session, 0, metres)


def _draw_background(arguments: argparse.Namespace) -> int:
    """Write the picture of the empty scene all around; the session stays as it is."""
    if not arguments.overwrite:
        require_absent([arguments.background])
    session = load_session(arguments.session)
    with open_video_of(session, arguments.session) as video:
        content = png(background_picture(session, video))
    write_file(arguments.background, content, overwrite=arguments.overwrite)
    print_written([arguments.background], arguments.json)
    return 0


def _change(
    found_camera: FoundCamera | None, after: Session, arguments: argparse.Namespace
) -> Change:
    lines = tuple(_lines(found_camera, after, arguments.went))
    return Change(lambda: after, lines, {} if found_camera is None else _facts(found_camera))


def _lines(found_camera: FoundCamera | None, after: Session, went: float | None) -> Iterator[str]:
    if went is not None:
        yield f"The camera's path has its scale: it went {went:g} m from where it began."
    elif found_camera is None:
        yield "The camera is as it was."
    if found_camera is not None:
        yield found_words(found_camera)
    if found_camera is not None and found_camera.focal is not None and found_camera.lens is None:
        share, sigma = found_camera.focal
        focal = after.view.camera.focal_mm
        yield (
            f"Its turns suggest a lens of {share * focal:.1f} ± {sigma * focal:.1f} mm; the "
            f"session has {focal:.1f} mm."
        )


def _facts(found_camera: FoundCamera) -> dict[str, object]:
    facts: dict[str, object] = {
        "kind": found_camera.kind,
        "findings": [
            camera_finding.model_dump(mode="json") for camera_finding in found_camera.findings
        ],
        "focal_share": None if found_camera.focal is None else found_camera.focal[0],
        "focal_share_sigma": None if found_camera.focal is None else found_camera.focal[1],
    }
    if found_camera.motion is not None:
        errors, path = found_camera.motion.errors_px, found_camera.motion.path
        R, centres = path.Ts_camera_world[:, :3, :3], path.Ts_world_camera[:, :3, 3]
        cosines = np.clip((np.trace(R, axis1=1, axis2=2) - 1) / 2, -1, 1)
        facts |= {
            "error_px": float(np.nanmedian(errors)) if np.isfinite(errors).any() else None,
            "turned_deg": float(np.degrees(np.arccos(cosines)).max()),
            "zoom": [float(path.zoom.min()), float(path.zoom.max())],
            "way_m": float(np.linalg.norm(np.diff(centres, axis=0), axis=1).sum()),
        }
    return facts
