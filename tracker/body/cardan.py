"""Cardan angles z, x, y of rotations over time, R = Rz · Rx · Ry, that run on without jumps.

Every rotation has two triples, (z, x, y) and (z + 180°, 180° − x, y + 180°), and each angle any
whole turns besides. Going from frame to frame to the nearest leads through all of them smoothly but
near the pole, where x is a quarter turn: there z and y turn about one axis, only their sum or
difference counts, and a part that passes beside the pole at a distance d turns both by half a turn
on a way as short as d. So within `POLE_DEG` z is not that of each frame, but the one whose steps
and whose distance from the frames are least in sum: at a distance c = cos x from the pole, z that
is off by e misplaces the part by c · sin e. x and y then are those nearest to the frame's rotation.
Outside, the angles make their rotation exactly.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array

POLE_DEG: Final = 20.0
"""Nearer to the pole z is chosen with regard to its neighbours."""

MISPLACED: Final = np.radians(1.0)
"""How far a part may lie beside its place, a standard deviation."""

STEP: Final = np.radians(7.0)
"""How far z goes from frame to frame, a standard deviation."""

GRID: Final = 60
"""Values of z, within half a turn, among which the way past a pole is searched."""

REFINED: Final = 8
"""Steps of Gauss and Newton after that."""


def continuous_zxy(rotations: Array, turned: float = 0.0) -> Array:
    """Angles [z, x, y] (N, 3), radians, of consecutive rotations (N, 3, 3), without jumps.

    turned: 0 or pi, for that of both triples whose x is, or is not, within a quarter turn of 0 at
    first.
    """
    z = _smooth_z(rotations) + turned
    cos, sin = np.cos(z), np.sin(z)
    levelled = rotations.copy()  # Rz⁻¹ · R
    levelled[:, 0] = cos[:, None] * rotations[:, 0] + sin[:, None] * rotations[:, 1]
    levelled[:, 1] = cos[:, None] * rotations[:, 1] - sin[:, None] * rotations[:, 0]
    x = np.arctan2(levelled[:, 2, 1], levelled[:, 1, 1])
    cos, sin = np.cos(x)[:, None], np.sin(x)[:, None]
    z_row = cos * levelled[:, 2] - sin * levelled[:, 1]  # of Rx⁻¹ · Rz⁻¹ · R
    y = np.arctan2(levelled[:, 0, 2] - z_row[:, 0], levelled[:, 0, 0] + z_row[:, 2])
    return np.unwrap(np.stack([z, x, y], axis=-1), axis=0)


def _smooth_z(rotations: Array) -> Array:
    """(N,) z of one of both triples at each frame, near the pole a smooth one."""
    own = np.arctan2(-rotations[:, 0, 1], rotations[:, 1, 1])
    away = np.hypot(rotations[:, 0, 1], rotations[:, 1, 1])
    near = away < np.sin(np.radians(POLE_DEG))
    if not near.any() or len(own) < 2:
        return np.unwrap(own, period=np.pi)
    z = _searched(own, away, near)
    z = np.where(near, z, own + np.pi * np.round((z - own) / np.pi))
    for _ in range(REFINED):
        z = z + _refining(z, own, away, near)
    return z


def _searched(own: Array, away: Array, near: NDArray[np.bool_]) -> Array:
    """(N,) z of least cost on a grid, by dynamic programming; no step is beyond a quarter turn."""
    grid = np.arange(GRID) * np.pi / GRID
    off = np.abs(np.sin(grid - own[:, None]))
    cost = np.square(away[:, None] * off / MISPLACED)
    cost[~near] = np.where(off[~near] > off[~near].min(axis=1, keepdims=True), np.inf, 0.0)
    steps = grid[:, None] - grid
    change = np.square((steps - np.pi * np.round(steps / np.pi)) / STEP)
    came = np.zeros((len(own), GRID), dtype=np.intp)
    best = cost[0]
    for row in range(1, len(own)):
        ways = change + best
        came[row] = ways.argmin(axis=1)
        best = ways.min(axis=1) + cost[row]
    path = [int(best.argmin())]
    for row in range(len(own) - 1, 0, -1):
        path.append(int(came[row, path[-1]]))
    return np.unwrap(grid[path[::-1]], period=np.pi)


def _refining(z: Array, own: Array, away: Array, near: NDArray[np.bool_]) -> Array:
    """(N,) a step of z toward the least cost, 0 away from the pole. The cost's curvature is taken
    for the largest that it has, so that no step makes it larger."""
    from scipy.linalg import solveh_banded  # scipy: loads longer than a page needs to start

    pull, steps = np.square(away / MISPLACED), np.diff(z) / STEP**2
    slope = pull * np.sin(2 * (z - own)) / 2
    slope[:-1] -= steps
    slope[1:] += steps
    inside = near[1:] & near[:-1]
    bands = np.zeros((2, len(z)))
    bands[0, 1:] = np.where(inside, -1 / STEP**2, 0.0)
    links = np.full(len(z), 2.0)
    links[[0, -1]] = 1.0
    bands[1] = np.where(near, pull + links / STEP**2, 1.0)
    return np.asarray(solveh_banded(bands, np.where(near, -slope, 0.0)))
