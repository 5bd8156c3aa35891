"""The facts of a video that are known without decoding its frames: lens, timecode, size, rate.

A frame is written as HH:MM:SS:FF. Where the rate is 30/1.001 or 60/1.001 frames a second, a
semicolon before FF says that numbers are dropped: 2 or 4 of them at every minute but each tenth, so
that the timecode keeps to the clock.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import VideoError
from keypose.tracker.video.picture import Mirrored

NEAREST_MM = 4.0
FARTHEST_MM = 2000.0
"""Focal lengths, as a 35 mm film would have them, between which there are lenses."""

LONGEST_NAME = 60

_FOCAL = ("focal_length.35mm_equivalent", "focallengthin35mmfilm", "focallengthin35mmformat")
_MAKE = ("com.apple.quicktime.make", "com.android.manufacturer", "make")
_MODEL = ("com.apple.quicktime.model", "com.android.model", "model")
_NUMBER = re.compile(r"\s*([0-9]{1,4}(?:\.[0-9]{1,6})?)\s*(?:mm)?\s*", re.ASCII)


@dataclass(frozen=True)
class FileLens:
    """focal_mm: as on 35 mm film, whose frame is 36 mm wide.  device: its name, or empty."""

    focal_mm: float
    device: str = ""


def lens_in(tags: Iterable[Mapping[str, str]]) -> FileLens | None:
    """The lens named by tags of QuickTime and MP4 files, or by the EXIF tags of an image.

    None where no focal length is given, or one that no lens has.
    """
    value_of = {key.casefold(): value for group in tags for key, value in group.items()}
    texts = [value for key, value in value_of.items() if key.endswith(_FOCAL)]
    focal_mm = next((mm for mm in map(_millimetres, texts) if mm is not None), None)
    if focal_mm is None:
        return None
    return FileLens(focal_mm, _device(_first(value_of, _MAKE), _first(value_of, _MODEL)))


def _millimetres(text: str) -> float | None:
    match = _NUMBER.fullmatch(text)
    mm = float(match[1]) if match else math.nan
    return mm if NEAREST_MM <= mm <= FARTHEST_MM else None


def _first(value_of: Mapping[str, str], keys: tuple[str, ...]) -> str:
    return next((value_of[key] for key in keys if key in value_of), "")


def _device(make: str, model: str) -> str:
    """ "Google Pixel 7"; the maker once."""
    make, model = _printable(make), _printable(model)
    name = model if model.casefold().startswith(make.casefold()) else f"{make} {model}"
    return name.strip()[:LONGEST_NAME]


def _printable(text: str) -> str:
    return " ".join("".join(c for c in text if c.isprintable()).split())


_TIMECODE = re.compile(r"([01]\d|2[0-3]):([0-5]\d):([0-5]\d)([:;.,])(\d{2,3})", re.ASCII)
_TAG = "timecode"
_MINUTES = 24 * 60


@dataclass(frozen=True)
class Timecode:
    """A film's timecode.

    rate: numbers of frames in a second, the film's rate rounded.
    number: of the film's first frame, since midnight.
    mark: what stands before the frame; anything but a colon says that numbers are dropped.
    of_files: the film is image files, and `number` is that in the name of the first.
    """

    rate: int
    number: int
    mark: str = ":"
    of_files: bool = False

    @classmethod
    def read(cls, text: str, fps: float) -> Self | None:
        """The timecode of a first frame; None where the text is none of this rate."""
        match, rate = _TIMECODE.fullmatch(text.strip()), round(fps)
        if match is None or int(match[5]) >= rate:
            return None
        hours, minutes, seconds, frame = (int(match[k]) for k in (1, 2, 3, 5))
        minutes += 60 * hours
        number = (60 * minutes + seconds) * rate + frame
        dropped = _dropped(rate, match[4])
        return cls(rate, number - dropped * (minutes - minutes // 10), match[4])

    @classmethod
    def of_numbers(cls, numbers: Sequence[int | None], fps: float) -> Self | None:
        """The timecode of image files by the numbers in their names, frame 0 of which is midnight;
        None unless these are consecutive and within a day."""
        first, rate = numbers[0], round(fps)
        if first is None or len(numbers) < 2 or first + len(numbers) > 60 * _MINUTES * rate:
            return None
        if any(number != first + n for n, number in enumerate(numbers)):
            return None
        return cls(rate, first, of_files=True)

    def at(self, frame: int) -> str:
        """The timecode of a frame of the film; a day has 24 hours."""
        dropped = _dropped(self.rate, self.mark)
        minute, tens = 60 * self.rate - dropped, 600 * self.rate - 9 * dropped
        number = (self.number + frame) % (_MINUTES // 10 * tens)
        whole, rest = divmod(number, tens)
        number += dropped * (9 * whole + max(0, (rest - dropped) // minute))
        seconds, shown = divmod(number, self.rate)
        clock = f"{seconds // 3600:02}:{seconds // 60 % 60:02}:{seconds % 60:02}"
        return f"{clock}{self.mark}{shown:02}"

    def __str__(self) -> str:
        return self.at(0)


def timecode_in(tags: Iterable[Mapping[str, str]], fps: float) -> Timecode | None:
    """The timecode that tags of a file give for its first frame; None where none do."""
    texts = (value for group in tags for key, value in group.items() if key.casefold() == _TAG)
    return next((code for text in texts if (code := Timecode.read(text, fps)) is not None), None)


def _dropped(rate: int, mark: str) -> int:
    """How many numbers a minute drops, but for every tenth."""
    return 0 if mark == ":" else 2 * round(rate / 30)


class MissingFrame(VideoError):
    """One frame of the video cannot be decoded; the others can.

    reason: what is wrong with it, where that is known and a person can fix it.
    """

    def __init__(self, message: str, reason: str = "") -> None:
        super().__init__(message)
        self.reason = reason


@dataclass(frozen=True, eq=False)
class VideoInfo:
    """The facts of a video. `pts` and `times_s` are read-only."""

    path: Path
    container: str  # "mov", "matroska", "images" …
    codec: str
    width: int  # of the upright picture, pixels as stored
    height: int
    frame_count: int
    time_base: Fraction  # seconds per unit of pts
    pts: NDArray[np.int64]  # (frame_count,) strictly increasing
    times_s: NDArray[np.float64]  # (frame_count,) seconds since the first frame
    fps: float  # mean rate
    variable_rate: bool
    rotation_deg: int  # turned by this much counter-clockwise to stand upright: 0, 90, 180, 270
    interlaced: bool  # as the file marks it, or its first frame
    pixel_aspect: Fraction  # width over height of one pixel of the upright picture
    missing: tuple[int, ...]  # frames known so far to be undecodable, ascending
    damaged: tuple[int, ...] = ()  # known so far to show something wrong, ascending; not missing
    lens: FileLens | None = None  # as the file gives it
    timecode: Timecode | None = None  # of the first frame, as the file gives it
    deinterlaced: bool = False  # each frame that is marked interlaced is made a progressive one
    depth: int | None = None  # bits used of sixteen in image files, spread to the full range
    file_numbers: tuple[int, ...] | None = None  # in the names of image files, where they ascend
    mirrored: Mirrored = ""  # how, after it was turned
    numbering: str = ""  # how the numbers in the names of image files go on unevenly, a sentence


@dataclass(frozen=True, eq=False)
class Clock:
    """When each frame is shown."""

    times_s: NDArray[np.float64]  # (frames,) seconds since the first frame
    fps: float
    variable: bool


def clock(pts: NDArray[np.int64], time_base: Fraction, nominal: Fraction) -> Clock:
    """Times and rate of frames at `pts`; `nominal` is the header's rate, frames/s."""
    ticks = (pts - pts[0]).astype(np.float64)
    times_s = ticks * float(time_base)
    times_s.setflags(write=False)
    if len(pts) < 2:
        return Clock(times_s, float(nominal), variable=False)
    step = ticks[-1] / (len(pts) - 1)
    # A coarse clock rounds each time to a tick, and a camera's own clock trembles a little.
    wander = np.abs(ticks - step * np.arange(len(pts))).max()
    variable = bool(wander > max(1.0, 0.02 * step))
    fps = 1.0 / (step * float(time_base))
    rounding = 1.0 / (ticks[-1] or 1.0)  # relative: one tick over the whole length
    if not variable and abs(fps - float(nominal)) <= fps * rounding:
        fps = float(nominal)
    return Clock(times_s, fps, variable)
