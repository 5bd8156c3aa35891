"""`keypose export`: the tracked motion for other programs."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from keypose.app.cli.arguments import (
    Subcommands,
    add_command,
    add_order,
    add_output,
    add_session,
    motion_formats,
    note,
    order_of,
)
from keypose.app.cli.json_output import print_written
from keypose.app.cli.views import video_if_there
from keypose.app.export.motion_formats import FORMATS, require_meant
from keypose.app.orders.motion import MotionOrder
from keypose.tracker.errors import FormatError, listed

if TYPE_CHECKING:
    from keypose.tracker.geometry.rotations import Array
    from keypose.tracker.session import Session
    from keypose.tracker.video.info import Timecode

_EXAMPLES = """\
  keypose export session.json --format bvh --out motion
  keypose export session.json --format csv,npz --out tables --overwrite
  keypose export session.json --format glb --rig mixamo --out rig
  keypose export session.json --format trc --filter 6Hz --fps 30 --frames 10-60 --out walk
  keypose export session.json --format trc,mot --markers halpe26 --out walk
  keypose export session.json --format mot --model Model_Pose2Sim_simple.osim --out walk
"""


def add(commands: Subcommands) -> None:
    command = add_command(commands, "export", run, _details(), _EXAMPLES)
    add_session(command)
    command.add_argument(
        "--format",
        metavar="FORMAT[,FORMAT]",
        type=motion_formats,
        required=True,
        help=f"one or several of {', '.join(FORMATS)}",
    )
    add_order(command, MotionOrder)
    command.add_argument(
        "--model",
        metavar="FILE.osim",
        type=Path,
        help="a full-body model of OpenSim 4 after Rajagopal: adds motion.trc and motion.mot for "
        "it, what OpenSim's tools need to scale it to the body and to follow the markers "
        "(markers.xml, scale.xml, ik.xml), and the scaled model where OpenSim is installed "
        "(pip install 'keypose[opensim]')",
    )
    add_output(command, "DIR", "folder; created if missing")


def _details() -> str:
    kinds = (f"{name}: {', '.join(kind.names)}, {kind.words}." for name, kind in FORMATS.items())
    gaps = listed([name for name, kind in FORMATS.items() if kind.gaps])
    no_gaps = listed([name for name, kind in FORMATS.items() if not kind.gaps])
    own_times = listed([name for name, kind in FORMATS.items() if kind.own_times])
    return (
        f"{' '.join(kinds)} Frames that are not tracked stay empty in {gaps}; "
        f"{no_gaps} cannot have gaps. If the video's frame rate varies, {own_times} keep "
        "the time of every frame and the others use the mean rate. For FBX, Blender converts glb: "
        "the command is in app/README.md."
    )


def run(arguments: argparse.Namespace) -> int:
    from keypose.app.export.motion_files import motion_files, sampling_words, saved_motion
    from keypose.app.export.opensim_files import files_for_model
    from keypose.tracker.storage.atomic import (
        make_folder,
        require_absent,
        require_folder,
        write_file,
    )
    from keypose.tracker.storage.files import load_session
    from keypose.tracker.storage.outdated import outdated_words
    from keypose.tracker.storage.tracks import load_tracks

    order = order_of(MotionOrder, arguments)
    require_meant(order, arguments.format)
    session = load_session(arguments.session)
    tracks = load_tracks(session, arguments.session)
    recording = saved_motion(session, tracks, *_clock(session, arguments.session))
    files = {
        name: content
        for format_name in arguments.format
        for name, content in motion_files(format_name, recording, order).items()
    }
    for_model = None
    if arguments.model is not None:
        for_model = files_for_model(recording, order, arguments.model, arguments.out)
        files |= for_model.files
    places = {arguments.out / name: content for name, content in files.items()}
    if not arguments.overwrite:
        require_absent(places)
    require_folder(arguments.out)
    make_folder(arguments.out)
    for place, content in places.items():
        write_file(place, content, overwrite=arguments.overwrite)
    print_written(places, arguments.json)
    note(for_model.words if for_model else None)
    note(sampling_words(recording, order, arguments.format))
    note(outdated_words(session, tracks))
    return 0


def _clock(session: Session, session_path: Path) -> tuple[Array, Timecode | None]:
    """The time of every frame, and the timecode; from the keyframes, with a word on it, when the
    video is gone."""
    import numpy as np

    with video_if_there(session, session_path, "times are those between keyframes") as video:
        if video is not None:
            return session.evidence.times_s(video.info.times_s), video.info.timecode
    if session.evidence.fps is not None:
        return session.evidence.times_s(None), None
    frames = [keyframe.frame for keyframe in session.keyframes]
    times_s = [keyframe.time_s for keyframe in session.keyframes]
    if len(frames) < 2 or min(np.diff(times_s)) <= 0:
        raise FormatError("Without the video, two keyframes with ascending times are needed.")
    return np.interp(np.arange(session.video.frame_count), frames, times_s), None
