"""The compiled loops of visual hulls: how deep places lie within the silhouettes of all views.

A view's map holds the signed distance of every pixel to the silhouette's outline in pixels, inside
positive, NaN where the view has neither. Times z / f it is a length at the place's own depth. Of
all views that see a place the smallest counts: a hull is what all silhouettes have in common.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.kernels import compiled

Array = NDArray[np.float64]


@compiled
def judge_cells(
    centres: Array,
    radius: float,
    Ts: Array,
    lenses: Array,
    sizes: NDArray[np.int64],
    maps: NDArray[np.float32],
    least_views: int,
    outside: NDArray[np.bool_],
) -> None:
    """Write whether balls about the centres (N, 3) surely lie outside the hull."""
    for i in range(centres.shape[0]):
        may_see, outside[i] = 0, False
        for k in range(Ts.shape[0]):
            u, v, z = _pixel(Ts[k], lenses[k], centres[i])
            if z < 1.01 * radius:
                may_see += z > -radius  # the ball is about the camera, which may see some of it
                continue
            x, y = (u - lenses[k, 2]) / lenses[k, 0], (v - lenses[k, 3]) / lenses[k, 1]
            reach = lenses[k, 0] * radius / (z - radius) * math.sqrt(1.0 + x * x + y * y)
            right, bottom = sizes[k, 0] - 1, sizes[k, 1] - 1
            if u < -reach or v < -reach or u > right + reach or v > bottom + reach:
                continue
            may_see += 1
            if u < reach or v < reach or u > right - reach or v > bottom - reach:
                continue
            if maps[k, int(v + 0.5), int(u + 0.5)] < -reach - 1.0:
                outside[i] = True
                break
        outside[i] |= may_see < least_views


@compiled
def measure_cells(
    cells: NDArray[np.int64],
    p_origin: Array,
    voxel: float,
    Ts: Array,
    lenses: Array,
    sizes: NDArray[np.int64],
    maps: NDArray[np.float32],
    least_views: int,
    limit: float,
    depths: NDArray[np.float32],
) -> None:
    """Write the depth within the hull, within ±limit, at the points of cells: (N, S, S, S).

    cells (N, 3): each cell's first point; point (i, j, k) lies at p_origin + voxel · (i, j, k).
    """
    p, side = np.empty(3), depths.shape[1]
    for n in range(cells.shape[0]):
        for a in range(side):
            p[0] = p_origin[0] + voxel * (cells[n, 0] + a)
            for b in range(side):
                p[1] = p_origin[1] + voxel * (cells[n, 1] + b)
                for c in range(side):
                    p[2] = p_origin[2] + voxel * (cells[n, 2] + c)
                    depths[n, a, b, c] = _depth(p, Ts, lenses, sizes, maps, least_views, limit)


@compiled
def _depth(
    p: Array,
    Ts: Array,
    lenses: Array,
    sizes: NDArray[np.int64],
    maps: NDArray[np.float32],
    least_views: int,
    limit: float,
) -> float:
    least, seen = limit, 0
    for k in range(Ts.shape[0]):
        u, v, z = _pixel(Ts[k], lenses[k], p)
        if z <= 1e-6:
            continue
        if not (u >= 0 and v >= 0 and u < sizes[k, 0] - 1 and v < sizes[k, 1] - 1):
            continue
        column, row = int(u), int(v)
        s, t = u - column, v - row
        depth = (1 - t) * ((1 - s) * maps[k, row, column] + s * maps[k, row, column + 1]) + t * (
            (1 - s) * maps[k, row + 1, column] + s * maps[k, row + 1, column + 1]
        )
        if math.isnan(depth):
            continue
        seen += 1
        depth *= z / lenses[k, 0]
        if depth <= -limit:
            return -limit
        least = min(least, depth)
    return least if seen >= least_views else -limit


@compiled
def _pixel(T: Array, lens: Array, p: Array) -> tuple[float, float, float]:
    """Column, row and depth of a place of the world in a view."""
    x = T[0, 0] * p[0] + T[0, 1] * p[1] + T[0, 2] * p[2] + T[0, 3]
    y = T[1, 0] * p[0] + T[1, 1] * p[1] + T[1, 2] * p[2] + T[1, 3]
    z = T[2, 0] * p[0] + T[2, 1] * p[1] + T[2, 2] * p[2] + T[2, 3]
    return lens[0] * x / z + lens[2], lens[1] * y / z + lens[3], z
