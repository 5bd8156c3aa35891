"""A template's place in a picture to a fraction of a pixel, with its turn and scale."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.kernels import compiled
from keypose.tracker.kernels.chain import solve_positive

Array: TypeAlias = NDArray[np.float64]
Picture: TypeAlias = NDArray[np.float32]

LONGEST_STEP = 2.0
"""Pixels; a longer step would leave what the gradient describes."""


@compiled
def settle(
    picture: Picture,
    xy: Picture,
    values: Picture,
    place: Array,
    hold: Array,
    soft: float,
    solves: int,
    spread: Array,
) -> float:
    """Gauss–Newton from `place`, which is overwritten; how alike picture and template are, 0 to 1.

    picture (h, w, 4) as in a clip. xy (K, 2): the template's pixels from its middle; values (K,)
    their brightness. place (4,): the middle's u, v, turn (u towards v) and log scale. hold (4,):
    1/σ² that keeps each where it starts. soft: grey levels beyond which a pixel counts less and
    less. spread (2,): variance of u and v for each grey level² of noise that is not shared by
    neighbouring pixels. The brightness may differ by a constant. The similarity is the mean weight
    of all pixels, those beyond the border or ignored weighing nothing.
    """
    begun = place.copy()
    A, b = np.empty((5, 5)), np.empty(5)
    bias, alike = _offset(picture, xy, values, place), 0.0
    for solve in range(solves + 1):
        alike = _sums(picture, xy, values, place, bias, soft, A, b)
        for i in range(4):
            A[i, i] += hold[i]
            b[i] += hold[i] * (begun[i] - place[i])
        if solve == solves or alike == 0.0:
            break
        if not solve_positive(A, b):
            break
        length = math.sqrt(b[0] ** 2 + b[1] ** 2)
        share = min(1.0, LONGEST_STEP / max(length, 1e-12))
        for i in range(4):
            place[i] += share * b[i]
        bias += b[4]
        if length < 0.01 and solve > 0:
            solves = solve + 1
    for i in range(2):
        b[:] = 0.0
        b[i] = 1.0
        inverse = A.copy()
        spread[i] = b[i] if solve_positive(inverse, b) else np.inf
    return alike


@compiled
def _offset(picture: Picture, xy: Picture, values: Picture, place: Array) -> float:
    """Mean difference of brightness where the template lies."""
    total, count = 0.0, 0
    sample = np.empty(4)
    c, s = _axis(place)
    for k in range(xy.shape[0]):
        dx, dy = c * xy[k, 0] - s * xy[k, 1], s * xy[k, 0] + c * xy[k, 1]
        if _sample(picture, place[0] + dx, place[1] + dy, sample):
            total += values[k] - sample[0]
            count += 1
    return total / count if count else 0.0


@compiled
def _sums(
    picture: Picture,
    xy: Picture,
    values: Picture,
    place: Array,
    bias: float,
    soft: float,
    A: Array,
    b: Array,
) -> float:
    """The normal equations A x = b of [u, v, turn, log scale, bias], and the mean weight."""
    A[:], b[:] = 0.0, 0.0
    total = 0.0
    sample, row = np.empty(4), np.empty(5)
    c, s = _axis(place)
    for k in range(xy.shape[0]):
        dx, dy = c * xy[k, 0] - s * xy[k, 1], s * xy[k, 0] + c * xy[k, 1]
        if not _sample(picture, place[0] + dx, place[1] + dy, sample):
            continue
        r = values[k] - sample[0] - bias
        weight = 1.0 / (1.0 + (r / soft) ** 2) ** 2  # Geman and McClure's
        total += weight
        row[0], row[1] = sample[1], sample[2]
        row[2] = sample[2] * dx - sample[1] * dy
        row[3] = sample[1] * dx + sample[2] * dy
        row[4] = 1.0
        for i in range(5):
            b[i] += weight * row[i] * r
            for j in range(i + 1):
                A[i, j] += weight * row[i] * row[j]
    for i in range(5):
        for j in range(i):
            A[j, i] = A[i, j]
    return total / max(xy.shape[0], 1)


@compiled
def _axis(place: Array) -> tuple[float, float]:
    """Where the template's x axis points, as long as one of its pixels."""
    scale = math.exp(place[3])
    return scale * math.cos(place[2]), scale * math.sin(place[2])


@compiled
def _sample(picture: Picture, u: float, v: float, sample: Array) -> bool:
    """All four numbers of the picture at a place between pixels; False where there are none."""
    if not (u >= 0.0 and v >= 0.0 and u < picture.shape[1] - 1 and v < picture.shape[0] - 1):
        return False
    column, row = int(u), int(v)
    fu, fv = u - column, v - row
    for i in range(4):
        upper = picture[row, column, i] * (1.0 - fu) + picture[row, column + 1, i] * fu
        lower = picture[row + 1, column, i] * (1.0 - fu) + picture[row + 1, column + 1, i] * fu
        sample[i] = upper * (1.0 - fv) + lower * fv
    return sample[3] > 0.25
