"""`keypose fit`: the motion of a body by observed surfaces, saved beside the session."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.arguments import (
    UNITS,
    UP_AXES,
    Subcommands,
    add_command,
    add_work,
    file_name,
    session_file,
)
from tracker.errors import SessionError

if TYPE_CHECKING:
    from tracker.session import Session
    from tracker.session.schema import Surface

_EXAMPLES = """\
  keypose open scan
  keypose fit scan --session scan.keypose/session.json
  keypose fit --session session.json --weights contact --out try --json > events.jsonl
"""
_DETAILS = (
    "The body is posed in the mesh of one step at least, in the page that `keypose open "
    "MESHES` shows; that surface then moves with it. Results are written beside the session, "
    "which then refers to them and keeps how it was fitted; with --out, a copy of the session "
    "and the results go to that folder and the session stays as it is. An unusable mesh is "
    "left out and reported. Ctrl+C or SIGTERM keeps the steps that are done. The exit code is "
    "1 when the body was lost somewhere."
)


def add(commands: Subcommands) -> None:
    summary = "Fit the body to observed surfaces, one mesh per time step"
    command = add_command(commands, "fit", run, summary, _DETAILS, _EXAMPLES)
    command.add_argument(
        "meshes",
        metavar="MESHES",
        type=file_name,
        nargs="?",
        help="a folder of PLY, OBJ, GLB or OFF files, or an animated GLB file; the session's own "
        "when left out",
    )
    command.add_argument(
        "--session",
        metavar="SESSION",
        type=session_file,
        required=True,
        help="the session's file or folder",
    )
    of_session = "; the session's own when left out"
    command.add_argument(
        "--cameras",
        metavar="FILE",
        type=file_name,
        help="the calibrated cameras whose images show which parts of the surfaces are reliable"
        f"{of_session}",
    )
    command.add_argument(
        "--weights",
        choices=("both", "contact", "photo", "none"),
        help="what makes a place count less: contact of parts, cameras that do not agree on it, "
        f"both, or nothing{of_session}",
    )
    command.add_argument(
        "--distance",
        choices=("plane", "point"),
        help=f"to the surface, or to its nearest point{of_session}",
    )
    command.add_argument(
        "--binding",
        choices=("nearest", "smooth"),
        help=f"whether a place of the surface moves with the nearest part alone{of_session}",
    )
    command.add_argument(
        "--units", choices=UNITS, help="of the meshes; refused where it is another one"
    )
    command.add_argument(
        "--up",
        choices=UP_AXES,
        help="the axis that is up, such as --up=-z; refused likewise",
    )
    qualities = ("full", "fast", "preview")
    command.add_argument("--quality", choices=qualities, help=f"how much work{of_session}")
    add_work(command)


def run(arguments: argparse.Namespace) -> int:
    from app.cli.outcome import track_and_save
    from app.jobs.rerun import require_trackable, with_settings

    session = _with_meshes(_session(arguments), arguments)
    require_trackable(session, arguments.session)
    surface = _surface(session, arguments)
    session = session.model_copy(update={"surface": surface})
    return track_and_save(session, with_settings(session, None, arguments.quality), arguments)


def _session(arguments: argparse.Namespace) -> Session:
    """The session; a sentence on how to get one where there is none yet."""
    from tracker.storage.files import load_session

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
    from app.document.new import path_from
    from tracker.storage.files import video_path
    from tracker.surface.files.sequence import MeshSequence

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
    """How the surfaces are to be fitted. What the poses were set by is not changed."""
    from app.document.new import path_from
    from tracker.session.evidence import surface_of
    from tracker.surface.cameras.rig import Rig

    surface = surface_of(session)
    for name, what in (("units", "in {}"), ("up", "with {} up")):
        said, known = getattr(arguments, name), getattr(surface, name)
        if said not in (None, known):
            raise SessionError(
                f"{arguments.session.name} was posed in meshes read {what.format(known)}, not "
                f"{what.format(said)}: change it under Fit in the page, where the poses follow."
            )
    asked = {name: getattr(arguments, name) for name in ("weights", "distance", "binding")}
    if arguments.cameras is not None:
        Rig.open(arguments.cameras)  # what is wrong with it is said before the work
        asked["cameras"] = path_from(arguments.cameras, arguments.session.absolute().parent)
    chosen = {name: value for name, value in asked.items() if value is not None}
    return surface.model_copy(update=chosen)
