"""A square piece of a picture, and where it is found again."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.matching import UNUSABLE, Grey, find_sequentially
from keypose.tracker.video.pyramid import IGNORED, USABLE, FloatPicture

MOST = 30
"""Grey levels that one pixel may count at most: what hides a part then costs little more than what
is a little unlike it."""
LEAST_SHARE = 0.12
"""Of a template's pixels, how many must count for it to be one."""


@dataclass(frozen=True, eq=False)
class GreyPicture:
    """A prepared picture for the searches: grey (h, w) whole numbers."""

    grey: Grey

    @classmethod
    def of(cls, picture: FloatPicture) -> GreyPicture:
        """Prepare one picture (h, w, 4) of a clip, in grey levels."""
        grey = np.where(picture[..., 3] != IGNORED, np.rint(picture[..., 0]), UNUSABLE)
        return cls(grey.astype(np.int16))


@dataclass(frozen=True, eq=False)
class Template:
    """A piece of a picture around a place.

    grey, wanted: (n, n), wanted 1 where a pixel counts. rows: (n,) the order in which rows are
    compared, the most varied first. offset: (2,) pixels (u, v) from the upper left pixel's centre
    to the place. contrast: mean distance of its pixels from their mean, grey levels.
    """

    grey: Grey
    wanted: Grey
    rows: NDArray[np.int64]
    offset: Array
    contrast: float

    @property
    def pixels(self) -> int:
        return int(self.wanted.sum())


@dataclass(frozen=True)
class Match:
    """Where a template was found, and its mean absolute difference there, grey levels."""

    uv: tuple[float, float]
    miss: float


def cut(
    picture: FloatPicture, uv: Array, half: int, wanted: NDArray[np.bool_] | None = None
) -> Template | None:
    """The (2 half + 1)² pixels around a place; None where too few of them may be used.

    Ignored pixels, those beyond the border and those of the background do not count; nor do those
    where `wanted` (h, w) is False.
    """
    column, row = np.rint(uv).astype(int) - half
    side = 2 * half + 1
    grey, counts = np.zeros((side, side), np.int16), np.zeros((side, side), np.int16)
    height, width = picture.shape[:2]
    v = slice(max(row, 0), min(row + side, height))
    u = slice(max(column, 0), min(column + side, width))
    if v.start >= v.stop or u.start >= u.stop:
        return None
    inside = slice(v.start - row, v.stop - row), slice(u.start - column, u.stop - column)
    piece = picture[v, u]
    grey[inside] = np.rint(piece[..., 0])
    chosen = piece[..., 3] == USABLE
    counts[inside] = chosen if wanted is None else chosen & wanted[v, u]
    if counts.sum() < LEAST_SHARE * side * side:
        return None
    away = np.abs(grey - grey[counts > 0].mean()) * counts
    rows = np.argsort(-away.sum(axis=1), kind="stable")
    offset = np.asarray(uv, np.float64) - (column, row)
    return Template(grey, counts, rows, offset, float(away.sum() / counts.sum()))


def find_match(template: Template, shown: GreyPicture, uv: Array, reach: int) -> Match:
    """Where a template fits best within `reach` pixels of a predicted place."""
    column, row = np.rint(np.asarray(uv) - template.offset).astype(int)
    v, u, total, _ = find_sequentially(
        shown.grey,
        template.grey,
        template.wanted,
        template.rows,
        row,
        column,
        outwards(reach),
        MOST,
    )
    place = (float(u + template.offset[0]), float(v + template.offset[1]))
    return Match(place, float(total / template.pixels))


@lru_cache(maxsize=64)
def outwards(reach: int) -> NDArray[np.int64]:
    """(K, 2) all steps (rows, columns) of at most `reach` along both axes, the nearest first."""
    steps = np.mgrid[-reach : reach + 1, -reach : reach + 1].reshape(2, -1).T
    order = np.lexsort((steps[:, 1], steps[:, 0], (steps**2).sum(axis=1)))
    ordered = np.ascontiguousarray(steps[order], dtype=np.int64)
    ordered.setflags(write=False)
    return ordered
