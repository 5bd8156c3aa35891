"""Follow points of the background through a film, one picture after another.

Two looks a frame, both by Lucas and Kanade: from the picture before, which finds where points went
however the camera was jerked; and from the *keyframe*, an earlier picture in which the points were
picked, which says to a fraction of a pixel where they are. What is measured from one keyframe does
not drift, and a point that was occluded is found again. Points are picked one a cell, where the
texture is best, so that no corner of the picture outweighs the others.

Pixels are the film's, whatever the size looked at. Which motion carries points is not known here:
who follows gives the places that are expected.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.robust import GemanMcClure

Grey: TypeAlias = NDArray[np.uint8]
Mask: TypeAlias = NDArray[np.bool_]
Background: TypeAlias = Callable[[int], Mask | None]
"""Of a frame, the pixels (H, W) where background may be seen; None for all."""

LOOK_PX = 960
"""Longest side of the pictures looked at; larger ones are made smaller."""
CELLS = 240
"""Into which the picture is divided; each holds a point at most."""
LEAST_CELL_PX = 8
"""Side of a cell, of a small picture too."""
BORDER_PX = 6
"""Nearer to the picture's edge no point is picked."""
LEAST_CORNER = 1e-5
"""Smaller eigenvalue of the gradients, as OpenCV scales it, below which a point is nothing."""
SURE_CORNER = 3e-4
"""Above which it is a corner; between the two the noise decides."""
ABOVE_NOISE = 5.0
"""Times the noise's strength of corners, above which a point stands out."""
QUIET_CELLS = 10
"""Percentile of the cells' medians that is the noise's strength."""
RETURN_PX = 0.5
"""A point counts where it is followed back to within this of where it began."""
ASIDE_PX = np.float32(1.5)
"""The way back begins this far off, along both axes: what is no corner does not return."""
AROUND_PX = 10
"""Room at the edge of the background in which a point's window would hold what is before it."""
FEWEST_FOLLOWED = 0.3
"""Share of the points from the picture before; with less the whole picture is asked for a shift."""
COARSE = 4
"""By which a picture is made smaller to be asked for the shift of its whole."""
FEWEST_EXPOSED = 12
"""Points by which a change of brightness is measured."""
LEAST_GAIN = 0.015
LEAST_OFFSET = 1.5
"""A smaller change of brightness is left: of the gain, and grey levels."""
GAIN_POWER = 2000.0
"""Grey levels²: the weight of no change, since a spread of a few levels says nothing of a gain."""

_SAME = (1.0, 0.0)
"""Gain and offset of a picture as it is."""


@dataclass(frozen=True)
class _Flow:
    """How Lucas and Kanade look: their window, how often the picture is halved first, and how many
    steps to which fraction of a pixel."""

    window: tuple[int, int]
    halvings: int
    steps: int
    settled_px: float

    def options(self, halvings: int) -> dict[str, object]:
        """As OpenCV takes them."""
        criteria = cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, self.steps, self.settled_px
        flags = cv2.OPTFLOW_USE_INITIAL_FLOW
        options = {"winSize": self.window, "maxLevel": halvings, "criteria": criteria}
        return {**options, "flags": flags}


_ROUGHLY = _Flow((15, 15), 3, 10, 0.05)
"""The first look, from the picture before, which is at half the size already."""
_EXACTLY = _Flow((21, 21), 1, 12, 0.02)
"""The second, from the keyframe."""


@dataclass(frozen=True, eq=False)
class KeyframePicture:
    """The picture of a keyframe at the size looked at, its half, and the points that were picked or
    known in it: their ids (K,) and where they are (K, 2), pixels of the film."""

    grey: Grey
    half: Grey
    ids: NDArray[np.int64]
    uv: Array


@dataclass(eq=False)
class PointFollower:
    """Points of one film, width × height pixels.

    Of every frame first `look`, then `refine`; and `pick` where a new keyframe is due.
    scale: from pixels of the film to those looked at.  visible: of the latest picture, how many
    points were expected where background may be seen.
    """

    width: int
    height: int
    keyframe: KeyframePicture | None = None
    scale: float = field(init=False)
    visible: int = field(default=0, init=False)
    _raw: Grey | None = field(default=None, init=False)
    _now: Grey | None = field(default=None, init=False)
    _exposure: tuple[float, float] = field(default=(1.0, 0.0), init=False)
    _half: Grey | None = field(default=None, init=False)
    _half_before: Grey | None = field(default=None, init=False)
    _last: Array = field(default_factory=lambda: np.zeros((0, 2)), init=False)
    _next_id: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self.scale = min(1.0, LOOK_PX / max(self.width, self.height))

    def look(self, picture: Grey, most: int | None = None) -> tuple[Array, NDArray[np.bool_]]:
        """Take the next picture and return roughly where the keyframe's points went (K, 2), and
        which of them (K,) were followed from the picture before.

        most: how many are asked, of those in the picture before, found in it or not: what moves
        there tells how much of the picture moves alike.
        """
        self._raw = self._small(picture)
        self._now = _exposed(self._raw, self._exposure)
        self._half_before, self._half = self._half, _halved(self._now)
        if self.keyframe is None or self._half_before is None:
            return self._last, np.zeros(len(self._last), bool)
        asked = self._asked(most)
        start = self.to_look(self._last[asked]) / 2
        halves = self._half_before, self._half
        there, is_found = _followed(halves, start, start, _ROUGHLY)
        if len(asked) and is_found.mean() < FEWEST_FOLLOWED:
            guess = start + _whole_shift(halves)
            again, is_found_again = _followed(halves, start, guess, _ROUGHLY)
            if is_found_again.sum() > is_found.sum():
                there, is_found = again, is_found_again
        rough, followed = self._last.copy(), np.zeros(len(self._last), bool)
        rough[asked], followed[asked] = self.to_film(2 * there), is_found
        self._expose(asked[is_found], there[is_found])
        return rough, followed

    def _expose(self, followed: NDArray[np.int64], there: Array) -> None:
        """Make the latest picture as bright as the keyframe's, by points (K,) that were followed to
        (K, 2) of its half: Lucas and Kanade take every other difference for motion.
        """
        assert self.keyframe is not None
        assert self._raw is not None
        assert self._half is not None
        if len(followed) < FEWEST_EXPOSED:
            return
        was = _brightness(self.keyframe.half, self.to_look(self.keyframe.uv[followed]) / 2)
        change = _line(_brightness(self._half, there), was)
        if abs(change[0] - 1) < LEAST_GAIN and abs(change[1]) < LEAST_OFFSET:
            return
        gain, offset = self._exposure
        self._exposure = (gain * change[0], offset * change[0] + change[1])
        self._now = _exposed(self._raw, self._exposure)
        self._half = _halved(self._now)

    def _asked(self, most: int | None) -> NDArray[np.int64]:
        every = np.arange(len(self._last))
        if most is None or len(every) <= most:
            return every
        inside = every[self.inside(self.to_look(self._last), 0.0)]
        if len(inside) <= most:
            return inside
        return np.asarray(inside[np.linspace(0, len(inside) - 1, most).astype(int)])

    def refine(
        self, expected: Array, usable: Mask | None, halvings: int = 1
    ) -> tuple[Array, NDArray[np.bool_]]:
        """Where the keyframe's points are (K, 2), and which (K,) were found.

        expected: (K, 2); also the places that are taken for points that were not found.
        usable: of the picture's pixels (H, W), those that may be background.  halvings: 0 where
        the places are expected to within a few pixels, one more for twice as far.
        """
        assert self.keyframe is not None
        assert self._now is not None
        start, guess = self.to_look(self.keyframe.uv), self.to_look(expected)
        inside = self.inside(guess, 0.0)
        open_ = self._open(usable)
        self.visible = int((inside & self._on(open_, expected)).sum())
        guess = np.where(inside[:, None], guess, start)
        flow = replace(_EXACTLY, halvings=halvings)
        there, is_found = _followed((self.keyframe.grey, self._now), start, guess, flow)
        is_found &= inside & self.inside(there, 1.0)
        uv = self.to_film(there)
        is_found &= self._on(open_, uv)
        uv = np.where(is_found[:, None], uv, expected)
        self._last = uv
        return uv, is_found

    def pick(self, usable: Mask | None, ids: NDArray[np.int64], uv: Array) -> KeyframePicture:
        """Make the latest picture the keyframe: with points that are known in it (K,), (K, 2), and
        new ones in the cells that hold none.
        """
        assert self._raw is not None
        picked = self.to_film(self._corners(self._open(usable), self.to_look(uv)))
        fresh = self._next_id + np.arange(len(picked))
        self._next_id += len(picked)
        ids, uv = np.concatenate([ids, fresh]), np.concatenate([uv, picked])
        keyframe = KeyframePicture(self._raw, _halved(self._raw), ids, uv)
        self.use(keyframe, uv)
        return keyframe

    def could_pick(self, usable: Mask | None, fewest: int) -> bool:
        """Whether a keyframe in the latest picture would have so many points."""
        return len(self._corners(self._open(usable), np.zeros((0, 2)))) >= fewest

    def use(self, keyframe: KeyframePicture, expected: Array) -> None:
        """Go on with a keyframe whose points were or would be at (K, 2) in the latest picture."""
        assert self._raw is not None
        self.keyframe, self._last = keyframe, expected
        self._exposure = _SAME
        self._now, self._half = self._raw, _halved(self._raw)

    def shift_from(self, keyframe: KeyframePicture) -> Array:
        """The shift (2,) of the whole picture since a keyframe, pixels of the film."""
        assert self._half is not None
        return 2 * _whole_shift((keyframe.half, self._half)) / self.scale

    @property
    def look_height(self) -> int:
        """Rows of the pictures looked at."""
        return round(self.height * self.scale)

    @property
    def now(self) -> Grey | None:
        """The latest picture, at the size looked at."""
        return self._now

    def _small(self, picture: Grey) -> Grey:
        if self.scale == 1.0:
            return picture
        size = (round(self.width * self.scale), round(self.height * self.scale))
        return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)

    def to_look(self, uv: Array) -> Array:
        """Pixels of the picture looked at from those of the film."""
        return (uv + 0.5) * self.scale - 0.5

    def to_film(self, uv: Array) -> Array:
        """Pixels of the film from those of the picture looked at."""
        return (uv + 0.5) / self.scale - 0.5

    def in_empty_cells(self, uv: Array, taken: Array) -> NDArray[np.bool_]:
        """Which places (K, 2), one a cell, lie where none of the taken ones (M, 2) does."""
        cells, held = self._cells(self.to_look(uv)), self._cells(self.to_look(taken))
        first = np.zeros(len(uv), bool)
        first[np.unique(cells, return_index=True)[1]] = True
        return np.asarray(first & ~np.isin(cells, held))

    def _side(self) -> int:
        assert self._now is not None
        return max(LEAST_CELL_PX, round(float(np.sqrt(self._now.size / CELLS))))

    def _cells(self, at: Array) -> NDArray[np.int64]:
        """The number (K,) of the cell of each place (K, 2) of the picture looked at."""
        assert self._now is not None
        side = self._side()
        rows, columns = (-(-length // side) for length in self._now.shape)
        column, row = np.clip(np.rint(at) // side, 0, (columns - 1, rows - 1)).astype(int).T
        return np.asarray(row * columns + column)

    def usable_at(self, usable: Mask | None, at: Array) -> NDArray[np.bool_]:
        """Which places (K, 2) of the picture looked at may show background."""
        return self._on(self._open(usable), self.to_film(at))

    def inside(self, at: Array, border: float) -> NDArray[np.bool_]:
        """Which places (K, 2) lie so far inside the picture looked at."""
        assert self._now is not None
        height, width = self._now.shape
        far = (width - 1 - border, height - 1 - border)
        return np.asarray(((at >= border) & (at <= far)).all(axis=1))

    def _open(self, usable: Mask | None) -> Mask | None:
        """A fourth of the size looked at: where nothing near is before the background."""
        if usable is None or usable.all():
            return None
        assert self._now is not None
        height, width = (-(-side // 4) for side in self._now.shape)
        share = cv2.resize(
            usable.astype(np.uint8) * 255, (width, height), interpolation=cv2.INTER_AREA
        )
        reach = 2 * -(-AROUND_PX // 4) + 1
        eroded = cv2.erode(share, np.ones((reach, reach), np.uint8), borderValue=255)
        return np.asarray(eroded == 255)

    def _on(self, open_: Mask | None, uv: Array) -> NDArray[np.bool_]:
        if open_ is None:
            return np.ones(len(uv), bool)
        height, width = open_.shape
        near = np.rint(self.to_look(uv) / 4 - 0.375)
        ahead = np.isfinite(near.sum(axis=1))  # points behind the camera have no place
        column, row = np.clip(np.where(ahead[:, None], near, 0), 0, (width - 1, height - 1)).T
        return np.asarray(open_[row.astype(int), column.astype(int)] & ahead)

    def _corners(self, open_: Mask | None, taken: Array) -> Array:
        """The best corner of every cell that holds no point and has one, pixels looked at."""
        assert self._now is not None
        height, width = self._now.shape
        strength = cv2.cornerMinEigenVal(self._now, 5)
        if open_ is not None:
            large = cv2.resize(
                open_.astype(np.uint8),
                (4 * open_.shape[1], 4 * open_.shape[0]),
                interpolation=cv2.INTER_NEAREST,
            )
            strength = strength * large[:height, :width]
        strength[:BORDER_PX] = strength[-BORDER_PX:] = 0.0
        strength[:, :BORDER_PX] = strength[:, -BORDER_PX:] = 0.0
        side = self._side()
        rows, columns = -(-height // side), -(-width // side)
        padded = np.zeros((rows * side, columns * side), np.float32)
        padded[:height, :width] = strength
        squares = padded.reshape(rows, side, columns, side).swapaxes(1, 2)
        cells = squares.reshape(rows * columns, side * side)
        quiet = _quiet(cells)
        least = np.clip(ABOVE_NOISE * quiet, LEAST_CORNER, SURE_CORNER)
        cells[self._cells(taken)] = 0.0
        best = cells.argmax(axis=1)
        good = cells[np.arange(len(cells)), best] > least
        cell = np.flatnonzero(good)
        v = (cell // columns) * side + best[cell] // side
        u = (cell % columns) * side + best[cell] % side
        return np.stack([u, v], axis=1).astype(float)


def _followed(
    pictures: tuple[Grey, Grey], start: Array, guess: Array, flow: _Flow
) -> tuple[Array, NDArray[np.bool_]]:
    """Where points of one picture are in another (K, 2), and which of them (K,) are found back.

    Args:
        pictures: the one and the other.
        start: (K, 2) where the points are in the one.
        guess: (K, 2) about where they are in the other.
        flow: how to look.
    """
    if not len(start):
        return np.zeros((0, 2)), np.zeros(0, bool)
    before, after = pictures
    p, q = (np.ascontiguousarray(uv[:, None], np.float32) for uv in (start, guess))
    there, forth, _ = cv2.calcOpticalFlowPyrLK(before, after, p, q, **flow.options(flow.halvings))  # type: ignore[call-overload]
    again, back, _ = cv2.calcOpticalFlowPyrLK(
        after, before, there, p + ASIDE_PX, **flow.options(min(flow.halvings, 1))
    )  # type: ignore[call-overload]
    returned = np.linalg.norm((again - p)[:, 0], axis=1) < RETURN_PX
    is_found = (forth[:, 0] > 0) & (back[:, 0] > 0) & returned
    return np.asarray(there[:, 0], float), is_found


def _quiet(cells: NDArray[np.float32]) -> float:
    """The strength of corners that noise has, of strengths (cells, pixels); 0 is not looked at."""
    sample = cells[:, ::7]
    full = sample[(sample > 0).mean(axis=1) > 0.7]
    return float(np.percentile(np.median(full, axis=1), QUIET_CELLS)) if len(full) else 0.0


def _halved(grey: Grey) -> Grey:
    return np.asarray(cv2.pyrDown(grey), np.uint8)


def _exposed(grey: Grey, exposure: tuple[float, float]) -> Grey:
    """gain · grey + offset."""
    if exposure == _SAME:
        return grey
    level = np.arange(256) * exposure[0] + exposure[1]
    return np.asarray(cv2.LUT(grey, np.clip(np.rint(level), 0, 255).astype(np.uint8)), np.uint8)


def _brightness(half: Grey, at: Array) -> Array:
    """The mean grey levels (K,) about places (K, 2)."""
    blurred = cv2.blur(half, (7, 7))
    height, width = half.shape
    column, row = np.rint(at).astype(int).T
    levels = blurred[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
    return np.asarray(levels, dtype=float)


def _line(x: Array, y: Array) -> tuple[float, float]:
    """The gain and offset that lead from values (K,) to others, by those that agree."""
    gain, offset = 1.0, float(np.median(y - x))
    for _ in range(4):
        away = y - gain * x - offset
        spread = max(1.5, 1.5 * float(np.median(np.abs(away))))
        w = GemanMcClure(spread).weight(np.abs(away))
        mean_x, mean_y = (w @ x) / w.sum(), (w @ y) / w.sum()
        power = w @ (x - mean_x) ** 2
        if power < 1e-9:
            break
        # a spread of a few levels says nothing of the gain
        gain = float((w @ ((x - mean_x) * (y - mean_y)) + GAIN_POWER) / (power + GAIN_POWER))
        offset = float(mean_y - gain * mean_x)
    return float(np.clip(gain, 0.4, 2.5)), offset


def _whole_shift(pictures: tuple[Grey, Grey]) -> Array:
    """The shift (2,) of a whole picture that best leads to another, by phase correlation."""
    first, second = (
        cv2.resize(grey, None, fx=1 / COARSE, fy=1 / COARSE, interpolation=cv2.INTER_AREA)
        for grey in pictures
    )
    height, width = first.shape
    if min(height, width) < 8:
        return np.zeros(2)
    window = cv2.createHanningWindow((width, height), cv2.CV_32F)
    shift, _ = cv2.phaseCorrelate(first.astype(np.float32), second.astype(np.float32), window)
    whole = np.asarray(shift, float) * COARSE
    return whole if np.isfinite(whole).all() else np.zeros(2)
