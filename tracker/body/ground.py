"""The floor, and the worlds that stand on it: y up, the floor at zero.

The floor is at the height that is known, or else where a moving body stands lowest. In the body's
own ground x is where it faces over the motion, on average, as the laboratory axes of the
International Society of Biomechanics point along the progression (Wu et al. 2002), z is to its
right, and the origin lies under the root's first place. In the camera's, the origin lies below the
camera, which looks along −z as nearly as the floor allows, and x is to the right of its picture.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array, frozen, transform

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


AHEAD_PART = (0.0, 0.0, -1.0)
"""Where a body faces at rest, in its root's frame."""

LEAST_AHEAD = 0.1
"""Of a mean of unit vectors; a person who turned all the way round faced nowhere on average."""


@dataclass(frozen=True, eq=False)
class Ground:
    """A frame that stands on the floor: y up, the floor at zero.

    R_ground_camera: (3, 3).  p_ground_camera: (3,) the camera's centre, metres.
    """

    R_ground_camera: Array
    p_ground_camera: Array

    def points(self, ps_camera: Array) -> Array:
        """Points (..., 3) of the camera frame on the ground."""
        return np.asarray(ps_camera @ self.R_ground_camera.T + self.p_ground_camera)

    @property
    def T_ground_camera(self) -> Array:
        """(4, 4)."""
        return transform(self.R_ground_camera, self.p_ground_camera)


def ground_of(
    skeleton: Skeleton, motion: Trajectory, up_camera: ArrayLike, floor_m: float | None
) -> Ground:
    """The ground of a motion, some of whose poses may be NaN, but not all.

    floor_m: metres along up from the camera's centre; None: as low as the body stands.
    """
    up = np.asarray(up_camera, dtype=np.float64)
    up = up / np.linalg.norm(up)
    is_known = np.isfinite(motion.ps_camera_root).all(axis=1)
    Ts = motion.transforms(skeleton)[is_known]
    ahead = _ahead(Ts[:, 0, :3, :3], up)
    R = np.stack([ahead, up, np.cross(ahead, up)])
    floor = floor_height(floor_m, lowest_heights(skeleton, Ts, up))
    x, _, z = R @ Ts[0, 0, :3, 3]
    return Ground(frozen(R), frozen([-x, -floor, -z]))


_FORWARD = (0.0, 0.0, 1.0)
_PICTURE_UP = (0.0, -1.0, 0.0)
_STEEP = 0.02
"""Of a direction, the level share below which it says nothing of where that points."""


def ground_of_camera(up_camera: ArrayLike, floor_m: float) -> Ground:
    """The ground below the camera.  floor_m: metres along up from the camera's centre."""
    up = np.asarray(up_camera, dtype=np.float64)
    up = up / np.linalg.norm(up)
    back = -_level(up)
    R = np.stack([np.cross(up, back), up, back])
    return Ground(frozen(R), frozen([0.0, -floor_m, 0.0]))


def _level(up: Array) -> Array:
    """(3,) where the camera looks, made level; straight down, what is above in its picture."""
    for direction in (_FORWARD, _PICTURE_UP):
        level = direction - (direction @ up) * up
        length = float(np.linalg.norm(level))
        if length > _STEEP:
            break
    return np.asarray(level / length)


def _ahead(Rs_camera_root: Array, up: Array) -> Array:
    """The level unit vector (3,) that the root faces along; on average, else at first."""
    faced = Rs_camera_root @ np.array(AHEAD_PART)
    level = faced - (faced @ up)[:, None] * up
    mean = level.mean(axis=0)
    for direction in (mean, level[0], np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])):
        direction = direction - (direction @ up) * up
        if np.linalg.norm(direction) > LEAST_AHEAD:
            return np.asarray(direction / np.linalg.norm(direction))
    raise AssertionError("one of two axes is not along up")
