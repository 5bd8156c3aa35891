"""`keypose shot`: a picture of the posed body, over the video or from anywhere."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from keypose.app.cli.arguments import (
    Subcommands,
    add_command,
    add_output,
    add_session,
    note,
    whole_number,
)
from keypose.app.cli.json_output import print_written
from keypose.app.cli.views import add_look, scale, session_to_draw, size, still_view, video_if_there
from keypose.app.export.drawable import MOST_PIXELS, require_frame, require_tint
from keypose.tracker.errors import FormatError, SessionError

if TYPE_CHECKING:
    from keypose.app.render.poses import KnownPoses
    from keypose.app.render.stills import Still
    from keypose.tracker.session import Session

_EXAMPLES = """\
  keypose shot session.json --frame 40 --view main --out frame40.png
  keypose shot session.json --frame 40 --view all --style wire --out views.png --overwrite
  keypose shot session.json --frame 40 --view orbit:60,20 --size 1920x1080 --out corner.png
  keypose shot session.json --frame 40 --background none --scale 2 --out body.png
"""


def add(commands: Subcommands) -> None:
    summary = "Render the body at one frame into a PNG file"
    details = (
        "Uses the keyframe's pose if there is one at this frame, else the tracked pose. Views:"
        " main is the undistorted video frame with the body over it (grey if the frame is "
        "missing); orbit looks at the body from any side, with a floor: an azimuth of 0 looks "
        "along the video's camera, 90 from the right of its picture; the default elevation is "
        "12 degrees. An observed surface is drawn behind the body in main and around it in "
        "every other view."
    )
    command = add_command(commands, "shot", run, summary, details, _EXAMPLES)
    add_session(command)
    command.add_argument(
        "--frame", metavar="N", type=whole_number(0), required=True, help="the frame to draw"
    )
    command.add_argument(
        "--view",
        metavar="VIEW",
        type=still_view,
        default="main",
        help="main, top, side, front, all, or orbit:AZIMUTH,ELEVATION; default: main",
    )
    add_look(command)
    how_large = command.add_mutually_exclusive_group()
    how_large.add_argument(
        "--size",
        metavar="WxH",
        type=size,
        help="size of the picture in pixels; default: the video's",
    )
    how_large.add_argument(
        "--scale",
        metavar="N",
        type=scale,
        default=1.0,
        help="scale the video's size by this factor",
    )
    command.add_argument(
        "--background",
        choices=("video", "none"),
        default="video",
        help="none: the body alone on a transparent background, without labels and floor",
    )
    add_output(command, "FILE.png")


def run(arguments: argparse.Namespace) -> int:
    from keypose.tracker.storage.atomic import write_file

    session, out = session_to_draw(arguments, "picture", ".png"), arguments.out
    require_tint(session, arguments.tint)
    wanted = _wanted(session, arguments)
    poses = _poses(session, arguments.session, arguments.frame, wanted)
    content = _content(session, poses, wanted, arguments)
    write_file(out, content, overwrite=arguments.overwrite)
    print_written([out], arguments.json)
    return 0


def _wanted(session: Session, arguments: argparse.Namespace) -> Still:
    from keypose.app.render.stills import Still
    from keypose.app.render.studio import Paint

    pixels = session.video.width * session.video.height * arguments.scale**2
    if arguments.scale > 1 and pixels > MOST_PIXELS:
        raise FormatError(
            f"A scale of {arguments.scale:g} makes a picture of {pixels / 1e6:.0f} million pixels; "
            f"at most {MOST_PIXELS // 10**6} million are drawn."
        )
    return Still(
        view=arguments.view,
        paint=Paint(arguments.style, arguments.opacity / 100),
        size=arguments.size,
        scale=arguments.scale,
        on_nothing=arguments.background == "none",
        tint=arguments.tint,
    )


def _poses(session: Session, session_path: Path, frame: int, wanted: Still) -> KnownPoses:
    """Return the poses with the one to draw; SessionError when the frame is neither a keyframe nor
    tracked.
    """
    from keypose.app.render.poses import KnownPoses
    from keypose.tracker.body.skeleton import Skeleton
    from keypose.tracker.storage.outdated import outdated_words
    from keypose.tracker.storage.tracks import load_tracks

    require_frame(session, frame)
    skeleton = Skeleton.of(session.body)
    keys = {keyframe.frame: keyframe.pose(skeleton) for keyframe in session.keyframes}
    if frame in keys and not (wanted.has_floor and session.results):
        return KnownPoses(skeleton, keys, None)
    tracks = load_tracks(session, session_path)
    if frame not in keys:
        if tracks.pose(frame) is None:
            raise SessionError(
                f"Frame {frame} is not tracked; the tracked frames are {tracks.runs()}."
            )
        note(outdated_words(session, tracks))
    return KnownPoses(skeleton, keys, tracks)


def _content(
    session: Session, poses: KnownPoses, wanted: Still, arguments: argparse.Namespace
) -> bytes:
    """The PNG file's bytes."""
    from keypose.app.render.stills import still
    from keypose.app.render.studio import png

    with _open_source(session, arguments.session, wanted) as video:
        content = png(still(session, video, arguments.frame, poses, wanted))
        if video is not None:
            note(video.note(arguments.frame))
    return content


def _open_source(session: Session, session_path: Path, wanted: Still) -> Any:
    """The video, or the surfaces around the body, where the picture shows them."""
    from contextlib import nullcontext

    from keypose.tracker.storage.files import open_video_of

    if wanted.needs_video:
        return open_video_of(session, session_path)
    if wanted.on_nothing or not session.evidence.has_surface:
        return nullcontext()
    return video_if_there(session, session_path, "the body is drawn without its surface")
