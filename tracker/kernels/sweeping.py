"""The compiled loop of depth from pictures: along a ray, where the other views agree best."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.kernels import compiled

Array = NDArray[np.float64]

HALF = 3
"""Patches have (2 · HALF + 1)² pixels."""


@compiled
def sweep(
    picture: NDArray[np.uint8],
    lens: Array,
    T_world_view: Array,
    others: NDArray[np.uint8],
    sizes: NDArray[np.int64],
    As: Array,
    bs: Array,
    p_origin: Array,
    voxel: float,
    inside: NDArray[np.bool_],
    stride: int,
    reach: Array,
    step: float,
    depth: NDArray[np.float32],
    score: NDArray[np.float32],
) -> None:
    """Write depth and score, both (h, w), of every `stride`-th pixel of a view's picture.

    A patch about the pixel, parallel to the picture, is moved along the ray in steps through the
    places of the grid that are `inside`. The score is the mean ZNCC with the better half of the
    other views.  As (M, 3, 3), bs (M, 3): pixel · z · A + b is another view's homogeneous pixel.
    reach: nearest and farthest z.  No depth (NaN, score −1) where the ray misses all places.
    """
    side = 2 * HALF + 1
    own, found = np.empty(side * side), np.empty(len(As))
    for row in range(depth.shape[0]):
        v = row * stride
        for column in range(depth.shape[1]):
            u = column * stride
            depth[row, column], score[row, column] = np.nan, -1.0
            if u < HALF or v < HALF or u >= picture.shape[1] - HALF or v >= picture.shape[0] - HALF:
                continue
            has_own = False
            z = reach[0]
            while z <= reach[1]:
                if not _is_inside(u, v, z, lens, T_world_view, p_origin, voxel, inside):
                    z += step
                    continue
                if not has_own:
                    _cut(picture, u, v, own)
                    has_own = True
                value = _agreement(own, u, v, z, others, sizes, As, bs, found)
                if value > score[row, column]:
                    depth[row, column], score[row, column] = z, value
                z += step


@compiled
def _is_inside(
    u: float,
    v: float,
    z: float,
    lens: Array,
    T: Array,
    p_origin: Array,
    voxel: float,
    inside: NDArray[np.bool_],
) -> bool:
    x, y = (u - lens[2]) / lens[0] * z, (v - lens[3]) / lens[1] * z
    i = _index(T[0], x, y, z, p_origin[0], voxel)
    j = _index(T[1], x, y, z, p_origin[1], voxel)
    k = _index(T[2], x, y, z, p_origin[2], voxel)
    if i < 0 or j < 0 or k < 0:
        return False
    if i >= inside.shape[0] or j >= inside.shape[1] or k >= inside.shape[2]:
        return False
    return inside[i, j, k]


@compiled
def _index(row: Array, x: float, y: float, z: float, start: float, voxel: float) -> int:
    """The grid point nearest to a place of the view's frame, along one axis."""
    return math.floor((row[0] * x + row[1] * y + row[2] * z + row[3] - start) / voxel + 0.5)


@compiled
def _cut(picture: NDArray[np.uint8], u: int, v: int, patch: Array) -> None:
    """The patch about a pixel, mean 0 and length 1."""
    s, mean, square = 0, 0.0, 0.0
    for a in range(-HALF, HALF + 1):
        for b in range(-HALF, HALF + 1):
            patch[s] = picture[v + a, u + b]
            mean += patch[s]
            s += 1
    mean /= s
    for i in range(s):
        patch[i] -= mean
        square += patch[i] * patch[i]
    length = math.sqrt(square) + 1e-6
    for i in range(s):
        patch[i] /= length


@compiled
def _agreement(
    own: Array,
    u: float,
    v: float,
    z: float,
    others: NDArray[np.uint8],
    sizes: NDArray[np.int64],
    As: Array,
    bs: Array,
    found: Array,
) -> float:
    """Mean ZNCC of the better half of the views that show the place; −1 where none does."""
    count = 0
    for m in range(As.shape[0]):
        value = _zncc(own, u, v, z, others[m], sizes[m], As[m], bs[m])
        if value > -1.0:
            found[count] = value
            count += 1
    if count == 0:
        return -1.0
    best = np.sort(found[:count])
    taken = (count + 1) // 2
    return best[count - taken :].sum() / taken


@compiled
def _zncc(
    own: Array,
    u: float,
    v: float,
    z: float,
    other: NDArray[np.uint8],
    size: NDArray[np.int64],
    A: Array,
    b: Array,
) -> float:
    s, mean, square, product = 0, 0.0, 0.0, 0.0
    for down in range(-HALF, HALF + 1):
        for right in range(-HALF, HALF + 1):
            pu, pv = (u + right) * z, (v + down) * z
            w = A[2, 0] * pu + A[2, 1] * pv + A[2, 2] * z + b[2]
            if w <= 1e-6:
                return -1.0
            x = (A[0, 0] * pu + A[0, 1] * pv + A[0, 2] * z + b[0]) / w
            y = (A[1, 0] * pu + A[1, 1] * pv + A[1, 2] * z + b[1]) / w
            if not (x >= 0 and y >= 0 and x < size[0] - 1 and y < size[1] - 1):
                return -1.0
            column, row = int(x), int(y)
            du, dv = x - column, y - row
            above = (1 - du) * other[row, column] + du * other[row, column + 1]
            below = (1 - du) * other[row + 1, column] + du * other[row + 1, column + 1]
            value = (1 - dv) * above + dv * below
            mean += value
            square += value * value
            product += own[s] * value  # own has mean 0
            s += 1
    spread = square - mean * mean / s
    return product / math.sqrt(spread) if spread > 1e-6 else 0.0
