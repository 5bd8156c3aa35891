"""Find repeated frames: copies of the frame before, as a change of the frame rate leaves them.

A copy is recognised by how little the picture changes to it, beside how much it changes right
before and after. Where nothing moves for longer than a change of rate repeats a frame, the scene
stands still.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.trajectory import runs
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.references import Repeats

WIDTH_PX = 160
"""Of the small grey pictures that are compared."""
MOST_CHANGE = 0.5
"""Mean grey levels by which a copy may differ from what it is a copy of: compression."""
LEAST_CHANGE = 0.15
"""Mean grey levels before and after a copy, at least: less is what compression does to a picture in
which nothing moves, most of it at the codec's key frames."""
LEAST_RATIO = 3.0
"""How many times as much the picture must change before and after a copy."""
SHARE = 0.3
"""Of the usual change nearby, so much at least before and after a copy: a body that turns round
comes to rest over some frames."""
LONGEST = 3
"""Copies one after the other, as from 15 to 60 frames a second."""
NEAR = 6
"""Frames before and after that tell the usual change."""
FEWEST = 3
"""A film with fewer has no changed rate; a single copy may well be a moment of stillness."""
EVEN_RATIO = 1.4
"""The change after a copy, over the usual one, from which on a frame was lost for the copy."""


PLANAR = {"yuv420p", "yuvj420p", "yuv422p", "yuvj422p", "yuv444p", "yuvj444p", "nv12", "gray"}
"""Formats whose first plane is brightness, a byte a pixel."""
FULL_RANGE = 2
"""FFmpeg's number for brightness from 0 to 255; otherwise it spans 16 to 235."""
STRETCH = 255 / 219
"""Of that span to the other."""


def small_grey(frame: av.VideoFrame) -> NDArray[np.int16]:
    """Make the small picture (h, w) of a frame that frames are compared by."""
    height = max(2, round(WIDTH_PX * frame.height / frame.width))
    if frame.format.name in PLANAR:
        plane = frame.planes[0]
        rows = np.frombuffer(memoryview(plane), np.uint8).reshape(plane.height, plane.line_size)
        whole = rows[:, : plane.width]
        small = cv2.resize(whole, (WIDTH_PX, height), interpolation=cv2.INTER_AREA)
        is_full = frame.format.name.startswith(("yuvj", "gray")) or frame.color_range == FULL_RANGE
        stretched = small.astype(np.float32) * (1.0 if is_full else STRETCH)
        return np.asarray(np.rint(stretched), np.int16)
    made = frame.reformat(width=WIDTH_PX, height=height, format="gray", interpolation="AREA")
    return made.to_ndarray().astype(np.int16)


class Changes:
    """Measure how much the picture changes from each frame to the next, as they are decoded."""

    def __init__(self) -> None:
        self._last: tuple[int, NDArray[np.int16]] | None = None

    def to(self, number: int, frame: av.VideoFrame) -> float | None:
        """Mean absolute difference in grey levels from the frame before; None unless that one was
        given last."""
        grey, last = small_grey(frame), self._last
        self._last = number, grey
        if last is None or last[0] != number - 1 or last[1].shape != grey.shape:
            return None
        return float(np.abs(grey - last[1]).mean())


def repeats_of(changes: Mapping[int, float], frame_count: int) -> Repeats:
    """Find the repeated frames of a film by the change to each frame from the one before."""
    change = np.full(frame_count, np.nan)
    change[list(changes)] = list(changes.values())
    frames = [frame for first, last in _copies(change) for frame in range(first, last + 1)]
    if len(frames) < FEWEST:
        return Repeats()
    return Repeats(frames=tuple(frames), even=_is_even(change, frames))


def _copies(change: Array) -> list[tuple[int, int]]:
    """First and last frames of every run of copies."""
    copies = []
    usual = _usual(change)
    calm = np.nan_to_num(change, nan=np.inf) <= np.minimum(MOST_CHANGE, usual / LEAST_RATIO)
    for first, last in runs(calm):
        if first == 0 or last + 1 == len(change) or last - first >= LONGEST:
            continue
        beside = min(change[first - 1], change[last + 1])  # NaN where one is not known
        is_copy = beside >= max(LEAST_CHANGE, LEAST_RATIO * change[first : last + 1].max())
        if is_copy and beside > SHARE * usual[first]:
            copies.append((first, last))
    return copies


def _usual(change: Array) -> Array:
    """How much the picture changes around each frame: the third largest change near it, as
    the largest may be cuts."""
    padded = np.pad(np.nan_to_num(change), NEAR)
    near = np.lib.stride_tricks.sliding_window_view(padded, 2 * NEAR + 1)
    return np.asarray(np.sort(near, axis=-1)[:, -3])


def _is_even(change: Array, frames: Sequence[int]) -> bool:
    """Tell whether frames were put in between, so that the others are evenly spaced in time; not
    where each copy took the place of a frame, after which the picture changes twice as much."""
    copied = np.zeros(len(change), np.bool_)
    copied[list(frames)] = True
    after = np.roll(copied, 1) & ~copied
    usual = change[~copied & ~after]
    if 2 * np.isfinite(usual).sum() < after.sum():
        return True  # each frame stands twice or more often
    return bool(np.nanmedian(change[after]) < EVEN_RATIO * np.nanmedian(usual))
