"""Colour models of the body and of its background in the pictures of several keyframes.

A part's colours are those seen well inside it, in all keyframes together; the background's those
around it. Where the camera stands still, the empty scene is known as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array

BINS = (16, 32, 32)
"""Of lightness and of the two colour axes of CIE Lab."""
CORE_PX, NEAR_PX, AROUND_PX = 2.5, 8.0, 40.0
"""How deep inside a part its colours are learnt, and from where to where outside the body those of
the background."""
LEAST_PIXELS = 40
MOST = 2.5
"""The most one pixel counts, log odds."""
FEWEST_FOR_PLATE = 5
TEMPER = 0.5
"""Neighbouring pixels are not independent."""

Picture = NDArray[np.uint8]
Map = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class ColourModels:
    """K pictures, and the log odds that their pixels show each of G groups of parts.

    rgb: (h, w, 3) each. usable: (h, w) each. cells: (h, w) index of each pixel's colour.
    group_of (P,): the group of every part. odds_of (G, C): log odds of each colour.
    plates: log odds by the empty scene, (h, w) each; trusted (K, G): where these may be used.
    """

    rgb: Sequence[Picture]
    usable: Sequence[NDArray[np.bool_]]
    cells: Sequence[NDArray[np.int32]]
    group_of: NDArray[np.int64]
    odds_of: Map
    plates: Sequence[Map]
    trusted: NDArray[np.bool_]

    def odds(self, frame: int, parts: NDArray[np.int64], uv: Array) -> Array:
        """(M, T) log odds that pixels uv (M, T, 2) show the part (M,)."""
        height, width = self.cells[frame].shape
        column, row = np.round(uv).astype(np.int64).transpose(2, 0, 1)
        within = (column >= 0) & (row >= 0) & (column < width) & (row < height)
        column, row = np.clip(column, 0, width - 1), np.clip(row, 0, height - 1)
        groups = self.group_of[parts]
        odds = self.odds_of[groups[:, None], self.cells[frame][row, column]]
        plate = self.plates[frame][row, column]
        odds = odds + np.where(self.trusted[frame, groups][:, None], plate, 0.0)
        odds = TEMPER * np.clip(odds, -MOST, MOST)
        return np.where(within & self.usable[frame][row, column], odds, np.nan)

    def sample(self, frame: int, uv: Array, normals: Array, offsets: Array) -> tuple[Array, Array]:
        """t (T,) pixels and colours (M, T, 3) there, about the places `offsets` (M,) outward."""
        t = np.arange(-3.5, 3.6, 0.25)
        at = np.nan_to_num(offsets)[:, None] + t
        place = (uv[:, None] + at[..., None] * normals[:, None]).astype(np.float32)
        if not len(place):
            return t, np.zeros((0, len(t), 3))
        seen = cv2.remap(
            self.rgb[frame].astype(np.float32), place[..., 0], place[..., 1], cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
        return t, np.asarray(seen, dtype=np.float64)


def colour_cells(rgb: Picture) -> NDArray[np.int32]:
    """(h, w) index of each pixel's colour among coarse ones."""
    lab = cv2.cvtColor(cv2.GaussianBlur(rgb, (0, 0), 0.7), cv2.COLOR_RGB2LAB).astype(np.int32)
    light, a, b = (lab[..., k] * BINS[k] // 256 for k in range(3))
    return np.asarray((light * BINS[1] + a) * BINS[2] + b, dtype=np.int32)


def learn_colours(
    rgb: Sequence[Picture],
    usable: Sequence[NDArray[np.bool_]],
    cells: Sequence[NDArray[np.int32]],
    shown: Sequence[NDArray[np.int16]],
    group_of: NDArray[np.int64],
    plates: Sequence[Map],
) -> ColourModels:
    """The models, given the part (h, w) that each pose shows at each pixel."""
    groups, size = int(group_of.max()) + 1, int(np.prod(BINS))
    figure, ground = np.zeros((groups, size)), np.zeros((groups, size))
    trusted = np.zeros((len(rgb), groups), dtype=np.bool_)
    for k, (cell, use, part) in enumerate(zip(cells, usable, shown, strict=True)):
        outside = use & (_distance(part < 0) > NEAR_PX)
        for g in range(groups):
            own = np.isin(part, np.flatnonzero(group_of == g))
            if own.sum() < LEAST_PIXELS:
                continue
            near = _window(own)
            core = use[near] & (_distance(own[near]) > CORE_PX)
            around = outside[near] & (_distance(~own[near]) < AROUND_PX)
            figure[g] += np.bincount(cell[near][core], minlength=size)
            ground[g] += np.bincount(cell[near][around], minlength=size)
            trusted[k, g] = core.any() and np.median(plates[k][near][core]) > 0
    odds_of = np.stack([_odds(f, g) for f, g in zip(figure, ground, strict=True)])
    return ColourModels(rgb, usable, cells, group_of, odds_of.astype(np.float32), plates, trusted)


def _window(own: NDArray[np.bool_]) -> tuple[slice, slice]:
    """What lies around a part, as far as it matters."""
    margin = int(AROUND_PX) + 1
    spans = (np.flatnonzero(own.any(axis=1 - axis)) for axis in (0, 1))
    rows, columns = (slice(max(0, s[0] - margin), s[-1] + margin + 1) for s in spans)
    return rows, columns


def _distance(inside: NDArray[np.bool_]) -> Map:
    """How deep every pixel lies inside, pixels."""
    return np.asarray(cv2.distanceTransform(inside.astype(np.uint8), cv2.DIST_L2, 3), np.float32)


def _odds(figure: Array, ground: Array) -> Array:
    """(C,) log odds of every colour; 0 where too little was seen."""
    if figure.sum() < LEAST_PIXELS or ground.sum() < LEAST_PIXELS:
        return np.zeros_like(figure)
    one, other = (_spread(counts) for counts in (figure, ground))
    least = 0.02 * max(float(one.max()), float(other.max()))
    return np.asarray(np.log((one + least) / (other + least)))


def _spread(counts: Array) -> Array:
    """Counts as shares, each colour a little of its neighbours' as well."""
    cube = counts.reshape(BINS) / counts.sum()
    for axis in range(3):
        padded = np.pad(cube, [(1, 1) if k == axis else (0, 0) for k in range(3)])
        low, middle, high = (np.moveaxis(padded, axis, 0)[k : k - 2 or None] for k in range(3))
        cube = np.moveaxis(0.25 * low + 0.5 * middle + 0.25 * high, 0, axis)
    return np.asarray(cube.ravel())


def plate_odds(rgb: Sequence[Picture], others: Sequence[Picture]) -> list[Map]:
    """Log odds (h, w) by the empty scene, for every picture; 0 unless the camera stands still.

    The empty scene is every pixel's median over all the pictures. It holds where most of the
    pictures agree with it; where the body never leaves a place, it is in the plate itself, which
    `learn_colours` notices.
    """
    every = np.stack([*rgb, *others])
    plate = np.median(every, axis=0)
    apart = [np.abs(picture - plate).max(axis=2) for picture in rgb]
    noise = max(2.0, 1.4826 * float(np.median(np.stack(apart))))
    moving = noise > 8.0 or np.mean([(a > 4 * noise).mean() for a in apart]) > 0.3
    if len(every) < FEWEST_FOR_PLATE or moving:
        return [np.zeros(a.shape, np.float32) for a in apart]
    return [np.clip(0.5 * (a / noise) ** 2 - 4.0, -MOST, MOST).astype(np.float32) for a in apart]
