"""Views, sizes and frames as a person writes them, for the commands that draw."""

from __future__ import annotations

import argparse
import math
import re
from contextlib import nullcontext
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from keypose.app.cli.arguments import note, whole_number
from keypose.app.export.drawable import LARGEST_SIDE, MOST_PIXELS, SMALLEST_SIDE
from keypose.tracker.errors import FormatError, SessionError

if TYPE_CHECKING:
    from keypose.app.render.films import FilmView
    from keypose.app.render.studio import Size, View
    from keypose.app.render.viewpoints import Viewpoint
    from keypose.tracker.session import Session

NAMES = ("main", "top", "side", "front", "all")
_NUMBER = re.compile(r"[+-]?\d{1,6}(\.\d{0,9})?")


def session_to_draw(arguments: argparse.Namespace, what: str, *suffixes: str) -> Session:
    """The session to draw, once it is known that the file can be written."""
    from keypose.tracker.storage.atomic import require_absent, require_folder
    from keypose.tracker.storage.files import load_session

    out: Path = arguments.out
    if out.suffix.lower() not in suffixes:
        raise FormatError(f"{str(out)!r} must end in {suffixes[0]}, the format of the {what}.")
    session = load_session(arguments.session)
    if not arguments.overwrite:
        require_absent([out])
    require_folder(out.parent)
    return session


def add_look(command: argparse.ArgumentParser) -> None:
    """Add how the body is drawn over the video, and what colours an observed surface."""
    styles = ("wire", "solid", "both")
    command.add_argument(
        "--style",
        choices=styles,
        default="both",
        help="how the body is drawn over the video; default: both",
    )
    command.add_argument(
        "--opacity",
        metavar="PERCENT",
        type=whole_number(0, 100),
        default=50,
        help="opacity of the solid body over the video; default: 50",
    )
    command.add_argument(
        "--tint",
        choices=("clay", "contact", "photo", "distance"),
        default="clay",
        help="colour an observed surface by its contact or photo weight, or by its distance "
        "from the body; default: clay",
    )


def video_if_there(session: Session, session_path: Path, otherwise: str) -> Any:
    """The session's video, opened; where it is gone, nothing, with a note."""
    from keypose.tracker.storage.files import open_video_of, video_path

    try:
        return open_video_of(session, session_path)
    except SessionError:
        if _exists(video_path(session, session_path)):  # another one, or damaged
            raise
    note(f"the {session.evidence.words.noun_with_is} missing; {otherwise}.")
    return nullcontext()


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:  # such as a name too long for any file
        return False


def still_view(text: str) -> View | Viewpoint:
    """main, top, side, front, all, orbit:AZIMUTH[,ELEVATION] or camera:AZIMUTH,ELEVATION[,M]."""
    if text in NAMES:
        return text  # type: ignore[return-value]
    return _viewpoint(text, f"{', '.join(NAMES)}, orbit:AZIMUTH,ELEVATION in degrees")


def film_view(text: str) -> FilmView:
    """main, top, side, front, all, orbit or camera:AZIMUTH,ELEVATION[,METRES]."""
    if text in (*NAMES, "orbit"):
        return text  # type: ignore[return-value]
    return _viewpoint(text, f"{', '.join(NAMES)}, orbit, camera:AZIMUTH,ELEVATION in degrees")


def size(text: str) -> Size:
    """Such as 1920x1080."""
    found = re.fullmatch(r"(\d{1,5})[x×X](\d{1,5})", text)
    sides = (int(found[1]), int(found[2])) if found else (0, 0)
    if not found or not SMALLEST_SIDE <= min(sides) <= max(sides) <= LARGEST_SIDE:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a size such as 1920x1080, sides from {SMALLEST_SIDE} to "
            f"{LARGEST_SIDE} pixels"
        )
    if sides[0] * sides[1] > MOST_PIXELS:
        millions = MOST_PIXELS // 10**6
        raise argparse.ArgumentTypeError(f"{text!r} has more than {millions} million pixels")
    return sides


def scale(text: str) -> float:
    """Such as 2 or 0.5."""
    value = float(text) if _NUMBER.fullmatch(text) else 0.0
    if not 0.05 <= value <= 16:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number from 0.05 to 16")
    return value


def rate(text: str) -> Fraction:
    """Frames a second, such as 25, 29.97 or 30000/1001."""
    try:
        value = Fraction(text) if len(text) <= 16 and "e" not in text.lower() else Fraction(0)
    except (ValueError, ZeroDivisionError):
        value = Fraction(0)
    if not Fraction(1, 10) <= value <= 1000:
        raise argparse.ArgumentTypeError(f"{text!r} is not a rate from 0.1 to 1000 frames a second")
    return value.limit_denominator(100_000)


def cutoff_hz(text: str) -> float:
    """Such as 6 or 6Hz."""
    number = re.sub(r"\s*hz$", "", text.strip().lower())
    value = float(number) if _NUMBER.fullmatch(number) else 0.0
    if not 0.01 <= value <= 1000:
        raise argparse.ArgumentTypeError(f"{text!r} is not a cut-off such as 6Hz")
    return value


def frame_range(text: str) -> tuple[int, int]:
    """Frames such as 10-60."""
    found = re.fullmatch(r"(\d{1,9})[-–](\d{1,9})", text)
    if not found or int(found[1]) > int(found[2]):
        raise argparse.ArgumentTypeError(f"{text!r} are no frames such as 10-60")
    return int(found[1]), int(found[2])


def _viewpoint(text: str, views: str) -> Viewpoint:
    from keypose.app.render.viewpoints import ELEVATION_DEG, Viewpoint

    kind, _, numbers_text = text.partition(":")
    numbers = [float(word) for word in numbers_text.split(",") if _NUMBER.fullmatch(word)]
    least, most = {"orbit": (1, 2), "camera": (2, 3)}.get(kind, (1, 0))
    if len(numbers) != numbers_text.count(",") + 1 or not least <= len(numbers) <= most:
        raise argparse.ArgumentTypeError(f"{text!r} is not a view; choose {views}")
    azimuth, elevation = math.fmod(numbers[0], 360.0), [*numbers, ELEVATION_DEG][1]
    if abs(elevation) > 90:
        raise argparse.ArgumentTypeError(f"{text!r}: an elevation is from -90 to 90 degrees")
    distance = numbers[2] if len(numbers) == 3 else None
    if distance is not None and not 0.1 <= distance <= 10_000:
        raise argparse.ArgumentTypeError(f"{text!r}: a distance is from 0.1 to 10000 metres")
    return Viewpoint(azimuth, elevation, distance)
