"""`keypose export`: the tracked motion for other programs."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.arguments import (
    Subcommands,
    add_command,
    add_json,
    add_overwrite,
    add_session,
    file_name,
    note,
)
from app.cli.json_output import print_written
from app.cli.views import video_if_there
from tracker.errors import FormatError

if TYPE_CHECKING:
    from app.export.motion_files import MotionFormat
    from tracker.geometry.rotations import Array
    from tracker.session import Session
    from tracker.storage.tracks import Tracks

_EXAMPLES = """\
  keypose export session.json --format bvh --out motion
  keypose export session.json --format csv,npz --out tables --overwrite
"""


def add(commands: Subcommands) -> None:
    text = (
        "Write the tracked motion for other programs. bvh: motion.bvh for animation programs, "
        "centimetres and degrees. glb: motion.glb, the moving body for any 3D viewer, metres. "
        "trc and c3d: motion.trc and motion.c3d, joints as markers for OpenSim and motion "
        "laboratories, millimetres. All four have x right, y up, z toward the camera. csv: "
        "joints.csv, metres in the camera frame (x right, y down, z forward), angles.csv, degrees, "
        "and frames.csv, how far to trust every frame. npz: motion.npz, all of this and the camera "
        "for NumPy, metres and radians. Frames that are not tracked stay empty in csv, npz, trc "
        "and c3d; bvh and glb hold no gaps."
    )
    command = add_command(commands, "export", run, text, _EXAMPLES)
    add_session(command)
    command.add_argument(
        "--format",
        metavar="FORMAT[,FORMAT]",
        type=_formats,
        required=True,
        help="one or several of bvh, glb, trc, c3d, csv, npz",
    )
    command.add_argument(
        "--out",
        metavar="DIR",
        type=file_name,
        required=True,
        help="folder; made when it is missing",
    )
    add_json(command)
    add_overwrite(command)


def run(arguments: argparse.Namespace) -> int:
    from tracker.storage.atomic import make_folder, require_absent, require_folder, write_file
    from tracker.storage.files import load_session
    from tracker.storage.outdated import outdated_words
    from tracker.storage.tracks import load_tracks

    session = load_session(arguments.session)
    tracks = load_tracks(session, arguments.session)
    files = _files(arguments.format, session, arguments.session, tracks)
    places = {arguments.out / name: content for name, content in files.items()}
    if not arguments.overwrite:
        require_absent(places)
    require_folder(arguments.out)
    make_folder(arguments.out)
    for place, content in places.items():
        write_file(place, content, overwrite=arguments.overwrite)
    print_written(places, arguments.json)
    note(outdated_words(session, tracks))
    return 0


def _formats(text: str) -> tuple[MotionFormat, ...]:
    """The formats of a list with commas between, each once."""
    from app.export.motion_files import FORMATS

    names = dict.fromkeys(name.strip().lower() for name in text.split(","))
    known = tuple(name for name in FORMATS if name in names)
    unknown = [name for name in names if name not in FORMATS]
    if unknown:
        choices = ", ".join(FORMATS)
        raise argparse.ArgumentTypeError(
            f"invalid choice: {unknown[0][:40]!r} (choose from {choices})"
        )
    return known


def _files(
    formats: tuple[MotionFormat, ...], session: Session, session_path: Path, tracks: Tracks
) -> dict[str, bytes]:
    """The contents to write by file name."""
    from app.export.motion_files import motion_files, saved_motion

    recording = saved_motion(session, tracks, _times_s(session, session_path))
    return {
        name: content
        for format_name in formats
        for name, content in motion_files(format_name, recording).items()
    }


def _times_s(session: Session, session_path: Path) -> Array:
    """The time of every frame; from the keyframes, with a word on it, when the video is gone."""
    import numpy as np

    with video_if_there(session, session_path, "times are those between keyframes") as video:
        if video is not None:
            return np.asarray(video.info.times_s)
    if session.surface is not None:
        return np.arange(session.video.frame_count) / session.surface.fps
    frames = [keyframe.frame for keyframe in session.keyframes]
    times_s = [keyframe.time_s for keyframe in session.keyframes]
    if len(frames) < 2 or min(np.diff(times_s)) <= 0:
        raise FormatError("Without the video, two keyframes with ascending times are needed.")
    return np.interp(np.arange(session.video.frame_count), frames, times_s)
