"""A session's motion as a film in a file: of the command line and the page."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TypeAlias

from keypose.app.orders.drawing import FilmOrder
from keypose.app.render.films import Film, film_pictures, film_size, posed_frames
from keypose.app.render.palette import Picture
from keypose.app.render.poses import KnownPoses
from keypose.tracker.errors import SessionError
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.atomic import sweep
from keypose.tracker.storage.outdated import outdated_words
from keypose.tracker.video import Video
from keypose.tracker.video.encode import FilmWriter, film_file

USUAL_FPS = 25.0
"""Where neither the video nor two keyframes give the pace."""

Seen: TypeAlias = Callable[[Iterator[Picture], int], Iterator[Picture]]
"""Lets somebody count the pictures that go by; their number is known before."""


@dataclass(frozen=True)
class FilmFacts:
    """Of the film that was written: first and last frame, pixels, seconds."""

    first_frame: int
    last_frame: int
    width: int
    height: int
    seconds: float


@dataclass(frozen=True)
class Clock:
    """When the film's frames are shown: pts counts in time_base seconds."""

    time_base: Fraction
    pts: list[int]
    rate: Fraction


def film_of(name: str, poses: KnownPoses, order: FilmOrder) -> Film:
    """The film that is ordered; SessionError where there is nothing to film, by the file's name."""
    frames_posed = poses.frames
    if not frames_posed:
        raise SessionError(f"{name} has no pose to film: set a keyframe first.")
    first, last = order.frames or (frames_posed[0], frames_posed[-1])
    return Film(order.view, first, last, order.paint, order.size, order.tint)


def write_film(
    out: Path,
    session: Session,
    video: Video | None,
    poses: KnownPoses,
    film: Film,
    fps: Fraction | None,
    *,
    seen: Seen = lambda pictures, _: pictures,
    overwrite: bool = False,
) -> FilmFacts:
    """Draw and write a film; KeyposeError, and no file, when it cannot be made."""
    sweep(out.parent)
    clock = clock_of(session, video, film.first, film.last, fps)
    wanted = film_size(session, poses, film)
    aspect = video.info.pixel_aspect if video and film.view == "main" and not film.size else None
    pictures = film_pictures(session, video, poses, film, float(clock.rate))
    with (
        film_file(out, overwrite=overwrite) as place,
        FilmWriter(place, wanted, clock.time_base, clock.rate, aspect) as writer,
    ):
        for pts, picture in zip(clock.pts, seen(pictures, len(clock.pts)), strict=True):
            writer.add(picture, pts)
    seconds = float(clock.pts[-1] * clock.time_base) + 1 / float(clock.rate)
    return FilmFacts(film.first, film.last, *wanted, round(seconds, 6))


def film_words(session: Session, poses: KnownPoses, film: Film) -> list[str]:
    """What a person should know of a film: what it does not show, sentences."""
    changed = outdated_words(session, poses.tracks) if poses.tracks is not None else None
    count, posed = film.last - film.first + 1, len(posed_frames(poses, film))
    without = f"{count - posed} of the film's {count} frames have no pose and show no body."
    return [*([changed] if changed else []), *([without] if posed < count else [])]


def clock_of(
    session: Session, video: Video | None, first: int, last: int, fps: Fraction | None = None
) -> Clock:
    """When the frames first to last are shown; fps None: as in the video."""
    count = last - first + 1
    if fps is None and video is not None and not _has_no_clock(session, video):
        info = video.info
        pts = info.pts[first : last + 1]
        return Clock(info.time_base, (pts - pts[0]).tolist(), _fraction(info.fps))
    if fps is None:
        fps = _fraction(_fps_of_keyframes(session))
    return Clock(1 / fps, list(range(count)), fps)


def _has_no_clock(session: Session, video: Video) -> bool:
    """Whether its rate is what the session says: images have none; slow motion stays so."""
    return video.info.container == "images" and session.evidence.fps is not None


def _fps_of_keyframes(session: Session) -> float:
    if session.evidence.fps is not None:
        return session.evidence.fps
    keys = session.subject.keyframes
    seconds = keys[-1].time_s - keys[0].time_s if keys else 0.0
    return (keys[-1].frame - keys[0].frame) / seconds if seconds > 0 else USUAL_FPS


def _fraction(value: float) -> Fraction:
    return Fraction(min(max(float(value), 0.01), 1000.0)).limit_denominator(100_000)
