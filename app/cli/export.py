"""`keypose export`: the tracked motion for other programs."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from keypose.app.cli.arguments import (
    Subcommands,
    add_command,
    add_output,
    add_session,
    motion_formats,
    note,
)
from keypose.app.cli.json_output import print_written
from keypose.app.cli.views import cutoff_hz, frame_range, rate, video_if_there
from keypose.app.export.motion_formats import FORMATS, MARKER_SETS
from keypose.tracker.errors import FormatError, listed
from keypose.tracker.formats.rigs import OWN, RIGS
from keypose.tracker.formats.units import FILE_UNITS

if TYPE_CHECKING:
    from keypose.app.export.motion_files import Sampling
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
    summary = "Write the tracked motion for other programs"
    command = add_command(commands, "export", run, summary, _details(), _EXAMPLES)
    add_session(command)
    command.add_argument(
        "--format",
        metavar="FORMAT[,FORMAT]",
        type=motion_formats,
        required=True,
        help=f"one or several of {', '.join(FORMATS)}",
    )
    command.add_argument(
        "--filter",
        metavar="HZ",
        type=cutoff_hz,
        help="cut-off of a zero-phase low-pass filter, such as 6Hz (Butterworth, fourth "
        "order); default: none",
    )
    command.add_argument(
        "--fps",
        metavar="N",
        type=rate,
        help="sample the motion at so many frames per second, as fast as it was; default: the "
        "video's rate. How fast it was recorded is said by `keypose open --recorded-fps`",
    )
    command.add_argument(
        "--frames",
        metavar="A-B",
        type=frame_range,
        help="first and last frame of the video; default: all",
    )
    rigged = [name for name, kind in FORMATS.items() if kind.rigged]
    rigs = "; ".join(f"{name}: {words}" for name, words in RIGS.items())
    command.add_argument(
        "--rig",
        metavar="NAME",
        choices=tuple(RIGS),
        help=f"names and rest pose of the bones in {listed(rigged)}: {rigs}; default: {OWN}",
    )
    units = "; ".join(f"{name}: {words}" for name, words in FILE_UNITS.items())
    command.add_argument(
        "--unit",
        choices=tuple(FILE_UNITS),
        help=f"of lengths in bvh, which cannot name its own: {units}; default: m",
    )
    command.add_argument(
        "--markers",
        choices=MARKER_SETS,
        default="keypose",
        help="of trc and c3d: keypose, the body's joints and landmarks; halpe26, a person's by the "
        "names of Pose2Sim; default: keypose",
    )
    command.add_argument(
        "--from-zero",
        action="store_true",
        help="times and frames begin at 0, as game engines and web players expect, and not where "
        "they are in the film",
    )
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

    _require_bones(arguments)
    session = load_session(arguments.session)
    tracks = load_tracks(session, arguments.session)
    recording = saved_motion(session, tracks, *_clock(session, arguments.session))
    sampling = _sampling(arguments)
    files = {
        name: content
        for format_name in arguments.format
        for name, content in motion_files(format_name, recording, sampling).items()
    }
    for_model = None
    if arguments.model is not None:
        for_model = files_for_model(recording, sampling, arguments.model, arguments.out)
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
    note(sampling_words(recording, sampling, arguments.format))
    note(outdated_words(session, tracks))
    return 0


def _sampling(arguments: argparse.Namespace) -> Sampling:
    from keypose.app.export.motion_files import Sampling

    fps = None if arguments.fps is None else float(arguments.fps)
    return Sampling(
        fps,
        arguments.filter,
        arguments.frames,
        arguments.rig or OWN,
        arguments.unit or "m",
        arguments.markers,
        arguments.from_zero,
    )


def _require_bones(arguments: argparse.Namespace) -> None:
    """A rig or a unit for formats that have none would be ignored in silence."""
    rigged = [name for name, kind in FORMATS.items() if kind.rigged]
    if arguments.rig is not None and not set(rigged) & set(arguments.format):
        raise FormatError(f"--rig is for formats with bones: {listed(rigged)}.")
    if arguments.unit is not None and "bvh" not in arguments.format:
        raise FormatError("--unit is for bvh: all other formats name their unit.")


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
