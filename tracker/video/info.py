"""The facts of a video that are known without decoding its frames."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import VideoError
from keypose.tracker.video.file_lens import FileLens
from keypose.tracker.video.timecode import Timecode


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
