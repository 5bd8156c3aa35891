"""`keypose film`: the body over the video, or the motion as a new camera sees it, as a film."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from keypose.app.cli.arguments import Subcommands, add_command, add_output, add_session, note
from keypose.app.cli.json_output import print_json, print_written
from keypose.app.cli.views import (
    add_look,
    film_view,
    frame_range,
    rate,
    session_to_draw,
    size,
    video_if_there,
)
from keypose.app.export.drawable import require_frame, require_tint

if TYPE_CHECKING:
    from keypose.app.export.film import FilmOrder
    from keypose.app.render.films import Film
    from keypose.app.render.palette import Picture
    from keypose.tracker.session import Session

_EXAMPLES = """\
  keypose film session.json --out overlay.mp4
  keypose film session.json --view orbit --size 1280x720 --out round.mp4
  keypose film session.json --view camera:120,15 --frames 10-60 --out batter.mp4
  keypose film session.json --view all --fps 10 --out slowly.mp4 --overwrite
"""


def add(commands: Subcommands) -> None:
    summary = "Render the tracked body into an MP4 film (H.264, no sound)"
    details = (
        "Views: main draws the body over the video; all adds the top, side and front views; "
        "orbit circles the body once while it moves; camera is a fixed viewpoint at an azimuth"
        " and an elevation. An azimuth of 0 looks along the video's camera, 90 from the right "
        "of its picture. Frames keep their times; frames without a pose are shown without the "
        "body. An observed surface is shown in every view."
    )
    command = add_command(commands, "film", run, summary, details, _EXAMPLES)
    add_session(command)
    command.add_argument(
        "--view",
        metavar="VIEW",
        type=film_view,
        default="main",
        help="main, top, side, front, all, orbit, or camera:AZIMUTH,ELEVATION[,METRES] in "
        "degrees and metres from the body; default: main",
    )
    command.add_argument(
        "--frames",
        metavar="A-B",
        type=frame_range,
        help="first and last frame; default: all frames that have a pose",
    )
    add_look(command)
    command.add_argument(
        "--size", metavar="WxH", type=size, help="size of the film in pixels; default: the video's"
    )
    command.add_argument(
        "--fps", metavar="N", type=rate, help="frames per second; default: the video's own timing"
    )
    add_output(command, "FILE.mp4")


def run(arguments: argparse.Namespace) -> int:
    from keypose.app.export.film import film_of, film_words, write_film
    from keypose.app.render.poses import KnownPoses

    session, out = session_to_draw(arguments, "film", ".mp4"), arguments.out
    require_tint(session, arguments.tint)
    poses = KnownPoses.of(session, arguments.session)
    film = film_of(arguments.session.name, poses, _order(arguments))
    require_frame(session, film.last)
    with _video(session, arguments.session, film) as video:
        facts = write_film(
            out, session, video, poses, film, arguments.fps,
            seen=_with_bar, overwrite=arguments.overwrite,
        )  # fmt: skip
    for words in film_words(session, poses, film):
        note(words)
    if arguments.json:
        print_json({"written": [str(out)], **asdict(facts)})
    else:
        print_written([out], False)
    return 0


def _order(arguments: argparse.Namespace) -> FilmOrder:
    from keypose.app.export.film import FilmOrder
    from keypose.app.render.studio import Paint

    paint = Paint(arguments.style, arguments.opacity / 100)
    asked = (arguments.view, arguments.frames, paint, arguments.size, arguments.tint)
    return FilmOrder(*asked, arguments.fps)


def _video(session: Session, session_path: Path, film: Film) -> Any:
    """The video, for its pictures or its times; a new camera does without it, with a note."""
    from keypose.app.export.film import USUAL_FPS
    from keypose.tracker.storage.files import open_video_of

    if film.needs_video:
        return open_video_of(session, session_path)
    if session.evidence.has_surface:  # and the session knows the pace
        return video_if_there(session, session_path, "the body is filmed without its surface")
    paced = len(session.keyframes) > 1
    pace = (
        "the film's rate is that of the keyframes' times"
        if paced
        else f"the film has {USUAL_FPS:g} frames a second"
    )
    return video_if_there(session, session_path, pace)


def _with_bar(pictures: Iterator[Picture], count: int) -> Iterator[Picture]:
    """Show at a terminal how far it is and how long it will take."""
    if not sys.stderr.isatty():
        yield from pictures
        return
    from tqdm import tqdm

    with tqdm(total=count, unit="frame", file=sys.stderr, dynamic_ncols=True) as bar:
        for picture in pictures:
            yield picture
            bar.update()
