"""Where the floor is: at the height that is known, or else where a moving body stands lowest."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array

LOW_PERCENT = 10.0
"""Of the moments, in which the lowest point of a body may lie under a guessed floor: poses that are
a little off reach deeper than the feet stood, and a jump says nothing."""


def floor_height(height_m: float | None, lowest_m: ArrayLike) -> float:
    """Metres along what is up, from the camera's centre, at which the floor lies.

    height_m: the height that somebody set or that was found; None where there is none.
    lowest_m: (N,) of the body's lowest point at every known moment, one at least, from which the
    floor is guessed then; as of `lowest_heights`.
    """
    if height_m is not None:
        return height_m
    return float(np.percentile(np.asarray(lowest_m, dtype=np.float64), LOW_PERCENT))


def lowest_heights(skeleton: Skeleton, Ts_camera_part: Array, up_camera: ArrayLike) -> Array:
    """(N,) metres along up (3,), from the camera's centre, of the lowest point of every pose.

    Ts_camera_part: (N, P, 4, 4).
    """
    up = np.asarray(up_camera, dtype=np.float64)
    up = up / np.linalg.norm(up)
    lowest = np.full(len(Ts_camera_part), np.inf)
    for i, part in enumerate(skeleton.body.parts):
        T = Ts_camera_part[:, i]
        ups_part = np.einsum("nji,j->ni", T[:, :3, :3], up)
        own = (ups_part @ part.shape.mesh().vertices.T).min(axis=1)
        lowest = np.minimum(lowest, own + T[:, :3, 3] @ up)
    return lowest
