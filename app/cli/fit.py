"""`keypose fit`: the motion of a body by observed surfaces, saved beside the session."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from keypose.app.cli.arguments import (
    SESSION,
    SESSION_FOLDER,
    UNITS,
    UP_AXES,
    Subcommands,
    add_command,
    add_work,
    file_name,
    session_file,
)
from keypose.tracker.errors import SessionError

if TYPE_CHECKING:
    from keypose.tracker.session import Session
    from keypose.tracker.session.references import Surface

_EXAMPLES = """\
  keypose open scan
  keypose fit scan
  keypose fit --session session.json --weights contact --out try --json > events.jsonl
"""
_DETAILS = (
    "Pose the body in at least one mesh first, with `keypose open MESHES`; the surface of that"
    " mesh then moves with the body. Results are written beside the session. With --out, a "
    "copy of the session and the results are written to that folder and the session is not "
    "changed. An unusable mesh is skipped and reported. Ctrl+C or SIGTERM keeps finished "
    "steps. The exit code is 1 when the body was lost somewhere."
)


def add(commands: Subcommands) -> None:
    command = add_command(commands, "fit", run, _DETAILS, _EXAMPLES)
    command.add_argument(
        "meshes",
        metavar="MESHES",
        type=file_name,
        nargs="?",
        help="a folder of numbered PLY, OBJ or GLB files; default: the session's meshes",
    )
    command.add_argument(
        "--session",
        metavar="SESSION",
        type=session_file,
        help="the session's file or folder; default: the one beside the meshes, or in this folder",
    )
    of_session = "; default: the session's setting"
    command.add_argument(
        "--cameras",
        metavar="FILE",
        type=file_name,
        help="JSON file with the calibrated cameras, whose images tell which parts of the "
        f"surfaces are reliable{of_session}",
    )
    command.add_argument(
        "--weights",
        choices=("both", "contact", "photo", "none"),
        help="give surface near other parts (contact), surface where cameras disagree "
        f"(photo), or both less weight{of_session}",
    )
    command.add_argument(
        "--distance",
        choices=("plane", "point"),
        help=f"measure distance to the surface's tangent plane or to its nearest point{of_session}",
    )
    command.add_argument(
        "--binding",
        choices=("nearest", "smooth"),
        help="nearest: each surface point moves with the nearest part; smooth: near joints "
        f"with both parts{of_session}",
    )
    command.add_argument(
        "--units", choices=UNITS, help="unit of the meshes; must match the session's"
    )
    command.add_argument(
        "--up",
        choices=UP_AXES,
        help="up axis of the meshes, such as --up=-z; must match the session's",
    )
    command.add_argument(
        "--quality",
        choices=("full", "preview"),
        help=f"full, or less accurate and faster{of_session}",
    )
    add_work(command)


def run(arguments: argparse.Namespace) -> int:
    from keypose.app.cli.outcome import track_and_save
    from keypose.app.jobs.rerun import require_trackable, with_settings

    if arguments.session is None:
        arguments.session = _usual_place(arguments.meshes)
    session = _with_meshes(_session(arguments), arguments)
    require_trackable(session, arguments.session)
    surface = _surface(session, arguments)
    session = session.model_copy(update={"surface": surface})
    return track_and_save(session, with_settings(session, None, arguments.quality), arguments)


def _usual_place(meshes: Path | None) -> Path:
    """Return where the session lies when nobody says."""
    if meshes is None:
        return Path(SESSION)
    stem = meshes.name if meshes.is_dir() else meshes.stem
    return meshes.with_name(f"{stem}{SESSION_FOLDER}") / SESSION


def _session(arguments: argparse.Namespace) -> Session:
    """The session; a sentence on how to get one where there is none yet."""
    from keypose.tracker.storage.files import load_session

    path: Path = arguments.session
    if not path.exists() and arguments.meshes is not None:
        raise SessionError(
            f"There is no session {str(path)!r}: pose the body in one of the meshes first, with "
            f"`keypose open {shlex.quote(str(arguments.meshes))}`."
        )
    session = load_session(path)
    if session.surface is None:
        raise SessionError(
            f"{path.name} is about a video: track it with keypose track, or begin a session about "
            "the meshes with `keypose open MESHES`."
        )
    return session


def _with_meshes(session: Session, arguments: argparse.Namespace) -> Session:
    """The session with the meshes that were named, if they are its own, wherever they lie now."""
    from keypose.app.document.new import path_from
    from keypose.tracker.storage.files import video_path
    from keypose.tracker.surface.files.sequence import MeshSequence

    meshes, path = arguments.meshes, arguments.session
    if meshes is None or meshes.resolve() == video_path(session, path).resolve():
        return session
    with MeshSequence.open(meshes) as sequence:
        is_own = session.video.fingerprint in ("", sequence.fingerprint())
    if not is_own:
        raise SessionError(
            f"{str(meshes)!r} holds other meshes than those that {path.name} was posed in: begin a "
            f"session of their own with `keypose open {shlex.quote(str(meshes))}`."
        )
    video = session.video.model_copy(update={"path": path_from(meshes, path.absolute().parent)})
    return session.model_copy(update={"video": video})


def _surface(session: Session, arguments: argparse.Namespace) -> Surface:
    """Return how the surfaces are to be fitted. What the poses were set by is not changed."""
    from keypose.app.document.new import path_from
    from keypose.tracker.session.evidence import surface_of
    from keypose.tracker.surface.cameras.rig import Rig

    surface = surface_of(session)
    for name, what in (("units", "in {}"), ("up", "with {} up")):
        given, known = getattr(arguments, name), getattr(surface, name)
        if given not in (None, known):
            raise SessionError(
                f"{arguments.session.name} was posed in meshes read {what.format(known)}, not "
                f"{what.format(given)}: change it under Fit in the page, where the poses follow."
            )
    asked = {name: getattr(arguments, name) for name in ("weights", "distance", "binding")}
    if arguments.cameras is not None:
        Rig.open(arguments.cameras)  # what is wrong with it is said before the work
        asked["cameras"] = path_from(arguments.cameras, arguments.session.absolute().parent)
    chosen = {name: value for name, value in asked.items() if value is not None}
    return surface.model_copy(update=chosen)
