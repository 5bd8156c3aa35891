"""`keypose export`: the tracked motion for other programs."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from app.commands.arguments import (
    Subcommands,
    add_command,
    add_json,
    add_overwrite,
    add_session,
    file_name,
    note,
)
from app.commands.json_output import print_written
from tracker.errors import FormatError

if TYPE_CHECKING:
    from app.motion_files import MotionFormat
    from tracker.geometry import Array
    from tracker.session import Session
    from tracker.trajectory import Trajectory

_EXAMPLES = """\
  keypose export session.json --format csv --out tables
  keypose export session.json --format bvh --out motion --overwrite
"""


def add(commands: Subcommands) -> None:
    text = (
        "Write the tracked motion as joints.csv and angles.csv, or as motion.bvh. CSV: metres in "
        "the camera frame (x right, y down, z forward) and degrees. BVH: centimetres, y up."
    )
    command = add_command(commands, "export", run, text, _EXAMPLES)
    add_session(command)
    command.add_argument("--format", choices=("csv", "bvh"), required=True)
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
    from tracker.session.atomic import demand_absent, demand_folder, make_folder, write_file
    from tracker.session.files import load_session
    from tracker.session.tracks import load_trajectory, outdated_words

    session = load_session(arguments.session)
    trajectory = load_trajectory(session, arguments.session)
    files = _files(arguments.format, session, arguments.session, trajectory)
    places = {arguments.out / name: text for name, text in files.items()}
    if not arguments.overwrite:
        demand_absent(places)
    demand_folder(arguments.out)
    make_folder(arguments.out)
    for place, text in places.items():
        write_file(place, text.encode(), overwrite=arguments.overwrite)
    print_written(places, arguments.json)
    note(outdated_words(session, trajectory))
    return 0


def _files(
    format_name: MotionFormat, session: Session, session_path: Path, trajectory: Trajectory
) -> dict[str, str]:
    """The texts to write by file name."""
    from app.motion_files import motion_files
    from tracker.skeleton import Skeleton

    times_s = _times_s(session, session_path)[trajectory.first_frame : trajectory.last_frame + 1]
    return motion_files(format_name, Skeleton.of(session.body), trajectory, times_s)


def _times_s(session: Session, session_path: Path) -> Array:
    """The time of every frame; from the keyframes, with a word on it, when the video is gone."""
    import numpy as np

    from tracker.session.files import open_video_of, video_path

    if video_path(session, session_path).exists():
        with open_video_of(session, session_path) as video:
            return video.info.times_s
    note("the video is missing; times are those between keyframes.")
    frames = [keyframe.frame for keyframe in session.keyframes]
    times_s = [keyframe.time_s for keyframe in session.keyframes]
    if len(frames) < 2 or min(np.diff(times_s)) <= 0:
        raise FormatError("Without the video, two keyframes with ascending times are needed.")
    return np.interp(np.arange(session.video.frame_count), frames, times_s)
