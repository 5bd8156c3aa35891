"""`keypose shot`: a picture of the posed body, over the video or from the top, side and front."""

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
    whole_number,
)
from app.commands.json_output import print_written
from tracker.errors import FormatError, SessionError

if TYPE_CHECKING:
    from tracker.pose import Pose
    from tracker.session import Session
    from tracker.skeleton import Skeleton

_EXAMPLES = """\
  keypose shot session.json --frame 40 --view main --out frame40.png
  keypose shot session.json --frame 40 --view all --style wire --out views.png --overwrite
"""


def add(commands: Subcommands) -> None:
    text = (
        "Draw the body at one frame into a PNG file. The pose is the keyframe's where one is set "
        "and the tracked one elsewhere; main is the video's frame with the body over it, without "
        "the lens's distortion, or plain grey where the video's frame is missing."
    )
    command = add_command(commands, "shot", run, text, _EXAMPLES)
    add_session(command)
    command.add_argument("--frame", metavar="N", type=whole_number(0), required=True)
    views = ("main", "top", "side", "front", "all")
    command.add_argument("--view", choices=views, default="main", help="default: main")
    styles = ("wire", "solid", "both")
    command.add_argument(
        "--style", choices=styles, default="both", help="of the body over the video; default: both"
    )
    command.add_argument(
        "--opacity",
        metavar="PERCENT",
        type=whole_number(0, 100),
        default=50,
        help="of the solid body over the video; default: 50",
    )
    command.add_argument("--out", metavar="FILE.png", type=file_name, required=True)
    add_json(command)
    add_overwrite(command)


def run(arguments: argparse.Namespace) -> int:
    from tracker.session.atomic import demand_absent, demand_folder, write_file
    from tracker.session.files import load_session
    from tracker.skeleton import Skeleton

    out: Path = arguments.out
    if out.suffix.lower() != ".png":
        raise FormatError(f"{str(out)!r} must end in .png, the format of the picture.")
    session = load_session(arguments.session)
    if not arguments.overwrite:
        demand_absent([out])
    demand_folder(out.parent)
    skeleton = Skeleton.of(session.body)
    pose = _pose(session, arguments.session, skeleton, arguments.frame)
    write_file(out, _content(session, skeleton, pose, arguments), overwrite=arguments.overwrite)
    print_written([out], arguments.json)
    return 0


def _pose(session: Session, session_path: Path, skeleton: Skeleton, frame: int) -> Pose:
    """The pose to draw; SessionError when the frame is neither a keyframe nor tracked."""
    from tracker.session.tracks import load_tracks, outdated_words

    if frame >= session.video.frame_count:
        raise SessionError(
            f"There is no frame {frame}; the video's frames are 0 to "
            f"{session.video.frame_count - 1}."
        )
    for keyframe in session.keyframes:
        if keyframe.frame == frame:
            return keyframe.pose(skeleton)
    tracks = load_tracks(session, session_path)
    pose = tracks.pose(frame)
    if pose is None:
        raise SessionError(f"Frame {frame} is not tracked; the tracked frames are {tracks.runs()}.")
    note(outdated_words(session, tracks))
    return pose


def _content(
    session: Session, skeleton: Skeleton, pose: Pose, arguments: argparse.Namespace
) -> bytes:
    """The PNG file's bytes."""
    from contextlib import nullcontext

    from app.drawing.snapshots import Look, png, snapshot
    from tracker.session.files import open_video_of

    look = Look(arguments.view, arguments.style, arguments.opacity / 100)
    needs_video = look.view in ("main", "all")
    opened = open_video_of(session, arguments.session) if needs_video else nullcontext()
    with opened as video:
        return png(snapshot(session, video, arguments.frame, pose, look))
