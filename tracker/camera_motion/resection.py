"""Find where a camera is in one picture from points whose places are known more or less.

A point whose depth is uncertain counts fully across the line along which depth would shift it in
the picture, and along it by as much as is known. With points at infinity alone the camera is
turned, and stays where it is expected.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.bundle import (
    KERNEL,
    LEAST_DEPTH,
    cross_rows,
    nudged,
    projection_slopes,
)
from keypose.tracker.geometry.rotations import Array

SCALES = (6.0, 2.5, 1.0, 1.0, 1.0)
"""Of the noise from step to step: far off at first, what is right must not seem an outlier."""
INLIER = 3.0
"""Standard deviations."""
DONE = 1e-7


@dataclass(frozen=True, eq=False)
class SeenPoints:
    """K points and where they are seen.

    world: (K, 3), times their inverse depths (K,); so a point at infinity is a direction.
    spread: (K,) standard deviations of the inverse depths.  eyes: (K, 3), the places from which
        these depths count.  xy: (K, 2).
    """

    world: Array
    depths: Array
    spread: Array
    eyes: Array
    xy: Array


@dataclass(frozen=True, eq=False)
class Resected:
    """T (4, 4) camera from world, and which points (K,) agree."""

    T: Array
    agree: NDArray[np.bool_]


def resected(
    start: Array,
    seen: SeenPoints,
    noise: float,
    step_sd: float,
    scales: tuple[float, ...] = SCALES,
) -> Resected:
    """Gauss–Newton on robustly weighed residuals.

    start: (4, 4).  noise: standard deviation of a place.  step_sd: how far from the start's place
    the camera may be, all else unknown.
    """
    T, held = start, np.diag([1 / step_sd**2] * 3 + [1e-6] * 3)
    for scale in scales:
        J, miss, squares = _whitened(T, seen, scale * noise)
        weight = 1 / (1 + squares / KERNEL**2)
        wJ = (J * weight[:, None, None]).reshape(-1, 6)
        flat = J.reshape(-1, 6)
        gone = T[:3, 3] - T[:3, :3] @ start[:3, :3].T @ start[:3, 3]
        g = wJ.T @ miss.ravel() + np.concatenate([gone / step_sd**2, np.zeros(3)])
        step = -np.linalg.solve(wJ.T @ flat + held, g)
        T = nudged(T, step)
        if scale == 1.0 and np.abs(step).max() < DONE:
            break
    squares = _whitened(T, seen, noise)[2]
    return Resected(T, squares < INLIER**2)


def _whitened(T: Array, seen: SeenPoints, noise: float) -> tuple[Array, Array, Array]:
    """Slopes (K, 2, 6), residuals (K, 2) and their squares (K,), in standard deviations."""
    R, t, depth = T[:3, :3], T[:3, 3], seen.depths[:, None]
    Y = seen.world @ R.T + depth * t
    ahead = Y[:, 2] > LEAST_DEPTH
    P = projection_slopes(Y)
    z = np.where(ahead, Y[:, 2], 1.0)[:, None]
    miss = Y[:, :2] / z - seen.xy
    J = np.concatenate([P * depth[..., None], cross_rows(P, Y)], axis=2)
    along = np.einsum("kab,kb->ka", P, seen.eyes @ R.T + t)
    length = np.sqrt((along**2).sum(axis=1))
    unit = along / np.maximum(length, 1e-12)[:, None]
    kept = 1 - noise / np.sqrt(noise**2 + (seen.spread * length) ** 2)
    # symmetric square root of the covariance's inverse: I − kept · unit unitᵀ, over the noise
    W = (np.eye(2) - kept[:, None, None] * unit[:, :, None] * unit[:, None, :]) / noise
    W = W * ahead[:, None, None]
    miss = (W @ miss[..., None])[..., 0]
    squares = np.where(ahead, (miss**2).sum(axis=1), np.inf)
    return W @ J, miss, squares
