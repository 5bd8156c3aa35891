"""`keypose film`: the body over the video, or the motion as a new camera sees it, as a film."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.cli.arguments import (
    Subcommands,
    add_command,
    add_output,
    add_session,
    note,
)
from app.cli.json_output import print_json, print_written
from app.cli.views import (
    add_look,
    film_view,
    frame_range,
    rate,
    require_frame,
    require_tint,
    session_to_draw,
    size,
    video_if_there,
)
from tracker.errors import SessionError

if TYPE_CHECKING:
    from app.render.films import Film
    from app.render.palette import Picture
    from app.render.poses import KnownPoses
    from tracker.session import Session
    from tracker.video import Video

USUAL_FPS = 25.0
"""Where neither the video nor two keyframes give the pace."""

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
    from app.render.poses import KnownPoses

    session, out = session_to_draw(arguments, "film", ".mp4"), arguments.out
    require_tint(session, arguments.tint)
    poses = KnownPoses.of(session, arguments.session)
    film = _film(session, poses, arguments)
    opened = _video(session, arguments.session, film)
    with opened as video:
        clock = _clock(session, video, film, arguments.fps)
        facts = _shoot(session, video, poses, film, clock, arguments)
    _note(session, poses, film)
    if arguments.json:
        print_json({"written": [str(out)], **facts})
    else:
        print_written([out], False)
    return 0


@dataclass(frozen=True)
class _Clock:
    """When the film's frames are shown: pts counts in time_base seconds."""

    time_base: Fraction
    pts: list[int]
    rate: Fraction


def _film(session: Session, poses: KnownPoses, arguments: argparse.Namespace) -> Film:
    from app.render.films import Film
    from app.render.studio import Paint

    known = poses.frames
    if not known:
        raise SessionError(f"{arguments.session.name} has no pose to film: set a keyframe first.")
    first, last = arguments.frames or (known[0], known[-1])
    require_frame(session, last)
    paint = Paint(arguments.style, arguments.opacity / 100)
    return Film(arguments.view, first, last, paint, arguments.size, arguments.tint)


def _video(session: Session, session_path: Path, film: Film) -> Any:
    """The video, for its pictures or its times; a new camera does without it, with a note."""
    from tracker.storage.files import open_video_of

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


def _clock(session: Session, video: Video | None, film: Film, fps: Fraction | None) -> _Clock:
    count = film.last - film.first + 1
    if fps is None and video is not None:
        info = video.info
        pts = info.pts[film.first : film.last + 1]
        return _Clock(info.time_base, (pts - pts[0]).tolist(), _fraction(info.fps))
    if fps is None:
        fps = _fraction(_fps_of_keyframes(session))
    return _Clock(1 / fps, list(range(count)), fps)


def _fps_of_keyframes(session: Session) -> float:
    if session.evidence.fps is not None:
        return session.evidence.fps
    keys = session.keyframes
    seconds = keys[-1].time_s - keys[0].time_s if keys else 0.0
    return (keys[-1].frame - keys[0].frame) / seconds if seconds > 0 else USUAL_FPS


def _fraction(value: float) -> Fraction:
    return Fraction(min(max(float(value), 0.01), 1000.0)).limit_denominator(100_000)


def _shoot(
    session: Session,
    video: Video | None,
    poses: KnownPoses,
    film: Film,
    clock: _Clock,
    arguments: argparse.Namespace,
) -> dict[str, Any]:
    """Draw and write; the facts of the film."""
    from app.render.films import film_pictures, film_size
    from tracker.video.encode import FilmWriter, film_file

    wanted = film_size(session, poses, film)
    aspect = video.info.pixel_aspect if video and film.view == "main" and not film.size else None
    pictures = film_pictures(session, video, poses, film, float(clock.rate))
    with (
        film_file(arguments.out, overwrite=arguments.overwrite) as place,
        FilmWriter(place, wanted, clock.time_base, clock.rate, aspect) as writer,
    ):
        for pts, picture in zip(clock.pts, _with_bar(pictures, len(clock.pts)), strict=True):
            writer.add(picture, pts)
    seconds = float(clock.pts[-1] * clock.time_base) + 1 / float(clock.rate)
    return {
        "first_frame": film.first,
        "last_frame": film.last,
        "width": wanted[0],
        "height": wanted[1],
        "seconds": round(seconds, 6),
    }


def _with_bar(pictures: Iterator[Picture], count: int) -> Iterator[Picture]:
    """At a terminal, how far it is and how long it will take."""
    if not sys.stderr.isatty():
        yield from pictures
        return
    from tqdm import tqdm

    with tqdm(total=count, unit="frame", file=sys.stderr, dynamic_ncols=True) as bar:
        for picture in pictures:
            yield picture
            bar.update()


def _note(session: Session, poses: KnownPoses, film: Film) -> None:
    """What the film does not show."""
    from app.render.films import posed_frames
    from tracker.storage.outdated import outdated_words

    if poses.tracks is not None:
        note(outdated_words(session, poses.tracks))
    count, posed = film.last - film.first + 1, len(posed_frames(poses, film))
    if posed < count:
        note(f"{count - posed} of the film's {count} frames have no pose and show no body.")
