"""Poses as the compiled loops take them: contiguous arrays of N poses, one after another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from keypose.tracker.body.joint_limits import LEAST_COS, LEAST_DETERMINED, SoftLimits
from keypose.tracker.body.skeleton import BODIES, Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, transform
from keypose.tracker.kernels.layout import Articulation, JointRanges, Lens, Places
from keypose.tracker.kernels.limits import add_limits, limit_cost
from keypose.tracker.kernels.places import (
    add_depth,
    add_picture,
    depth_cost,
    move_all,
    picture_cost,
    place_all,
    place_poses,
)
from keypose.tracker.kernels.robust import CAUCHY, HUBER, LEAST_SQUARES, TUKEY
from keypose.tracker.kernels.steps import motions_between
from keypose.tracker.solver.robust import Cauchy, Huber, Kernel, Squared, Tukey

NUMBERS: Mapping[type[Kernel], int] = {
    Squared: LEAST_SQUARES,
    Huber: HUBER,
    Tukey: TUKEY,
    Cauchy: CAUCHY,
}


def numbered(kernel: Kernel) -> tuple[int, float]:
    """A robust kernel: its number and its width."""
    return NUMBERS[type(kernel)], kernel.width


@lru_cache(maxsize=BODIES)
def articulation(skeleton: Skeleton) -> Articulation:
    """How the poses of a body move."""
    return Articulation(
        skeleton.parents, skeleton.joints, skeleton.dof_part, skeleton.dof_turns, skeleton.dof_axis
    )


@lru_cache(maxsize=8 * BODIES)
def ranges_of(skeleton: Skeleton, soft: SoftLimits) -> JointRanges:
    """Joint limits, and what may lie beyond them."""
    limits, allowed = soft.limits, soft.allowed
    parts, twists = skeleton.part_count, limits.twists
    place = np.full(parts, -1)
    place[limits.twisted] = np.arange(len(limits.twisted))
    none = np.zeros(0)
    low, high, R_rest = (
        (none, none, np.zeros((0, 3, 3)))
        if twists is None
        else (np.array(twists.low), np.array(twists.high), np.array(twists.R_rest))
    )
    return JointRanges(
        np.array(limits.low),
        np.array(limits.high),
        np.any(np.isfinite([limits.low, limits.high]), axis=(0, 2)),
        place,
        low,
        high,
        R_rest,
        np.zeros((parts, 4)) if allowed is None else np.array(allowed),
        soft.sigma_rad,
        soft.onset_rad,
        LEAST_COS,
        LEAST_DETERMINED,
        np.searchsorted(skeleton.dof_part, np.arange(parts + 1)),
    )


def lens_of(camera: Camera) -> Lens:
    """A camera; its distortion must have been taken out of the pictures."""
    distance = camera.telephoto_distance_m or 1.0
    flat = int(camera.projection == "perspective")
    return Lens(camera.fx, camera.fy, camera.cx, camera.cy, flat, distance)


def motions_of(
    skeleton: Skeleton, R: Array, p: Array, R_to: Array, p_to: Array, *, backward: bool
) -> Array:
    """(N, D) the tracked part of the motions from N poses to others, as `Posed.motion_from`."""
    return _motions(articulation(skeleton), R, p, R_to, p_to, backward)


def _motions(
    chain: Articulation, R: Array, p: Array, R_to: Array, p_to: Array, backward: bool
) -> Array:
    motion = np.empty((len(p), len(chain.dof_part)))
    motions_between(chain, R, p, R_to, p_to, backward, motion)
    return motion


@dataclass(frozen=True, eq=False)
class Placed:
    """N poses of a body, and where they have its parts.

    Rs_parent_part (N, P, 3, 3), ps_camera_root (N, 3) · Rs_camera_part (N, P, 3, 3), ps_camera_part
    (N, P, 3) · twists (N, D, 6) of the degrees of freedom.
    """

    skeleton: Skeleton
    Rs_parent_part: Array
    ps_camera_root: Array
    Rs_camera_part: Array
    ps_camera_part: Array
    twists: Array

    @classmethod
    def of(cls, skeleton: Skeleton, Rs_parent_part: Array, ps_camera_root: Array) -> Placed:
        """All parts of these poses."""
        count, parts = Rs_parent_part.shape[:2]
        R, p = np.empty((count, parts, 3, 3)), np.empty((count, parts, 3))
        S = np.empty((count, skeleton.dof_count, 6))
        place_poses(articulation(skeleton), Rs_parent_part, ps_camera_root, R, p, S)
        return cls(skeleton, Rs_parent_part, ps_camera_root, R, p, S)

    @cached_property
    def Ts_camera_part(self) -> Array:
        """(N, P, 4, 4)"""
        return transform(self.Rs_camera_part, self.ps_camera_part)

    @property
    def chain(self) -> Articulation:
        """How they move."""
        return articulation(self.skeleton)

    def positions(self, places: Places) -> Array:
        """(N, J, 3) in the camera frame."""
        p = np.empty((len(self.ps_camera_root), len(places.starts) - 1, 3))
        place_all(places, self.Rs_camera_part, self.ps_camera_part, p)
        return p

    def jacobian(self, places: Places) -> tuple[Array, Array]:
        """The same, and (N, J, D, 3) how they move with each degree of freedom."""
        p = np.empty((len(self.ps_camera_root), len(places.starts) - 1, 3))
        J = np.zeros((*p.shape[:2], self.twists.shape[1], 3))
        move_all(places, self.Rs_camera_part, self.ps_camera_part, self.twists, p, J)
        return p, J

    def motion_from(self, Rs_parent_part: Array, ps_camera_root: Array, *, backward: bool) -> Array:
        """(N, D) as `Posed.motion_from`."""
        here, there = (Rs_parent_part, ps_camera_root), (self.Rs_parent_part, self.ps_camera_root)
        return _motions(self.chain, *here, *there, backward)

    def picture_cost(
        self,
        places: Places,
        camera: Camera,
        uv: Array,
        scale: Array,
        nearest_m: float,
        kernel: Kernel,
    ) -> float:
        """What it costs that places are seen at uv (N, J, 2), scale (N, J) in 1/px."""
        parts, picture = (self.Rs_camera_part, self.ps_camera_part), (lens_of(camera), uv, scale)
        return float(picture_cost(places, *parts, *picture, nearest_m, *numbered(kernel)))

    def add_picture(
        self,
        places: Places,
        camera: Camera,
        uv: Array,
        scale: Array,
        nearest_m: float,
        kernel: Kernel,
        A: Array,
        b: Array,
    ) -> float:
        """The same, and A (N, D, D), b (N, D) += the normal equations."""
        return float(
            add_picture(
                places,
                self.Rs_camera_part,
                self.ps_camera_part,
                self.twists,
                lens_of(camera),
                uv,
                scale,
                nearest_m,
                *numbered(kernel),
                A,
                b,
            )
        )

    def depth_cost(self, places: Places, depth: Array, scale: Array, kernel: Kernel) -> float:
        """What it costs that places are so much farther than the root: depth, scale (N, J)."""
        return float(
            depth_cost(
                places, self.Rs_camera_part, self.ps_camera_part, depth, scale, *numbered(kernel)
            )
        )

    def add_depth(
        self, places: Places, depth: Array, scale: Array, kernel: Kernel, A: Array, b: Array
    ) -> float:
        """The same, and A, b += the normal equations."""
        measured = depth, scale, *numbered(kernel)
        return float(
            add_depth(
                self.chain,
                places,
                self.Rs_camera_part,
                self.ps_camera_part,
                self.twists,
                *measured,
                A,
                b,
            )
        )

    def limit_cost(self, limits: SoftLimits) -> float:
        """What it costs to lie outside limits by more than is allowed."""
        return float(limit_cost(ranges_of(self.skeleton, limits), self.Rs_parent_part))

    def add_limits(self, limits: SoftLimits, A: Array, b: Array) -> float:
        """The same, and A, b += the normal equations."""
        ranges = ranges_of(self.skeleton, limits)
        return float(add_limits(self.chain, ranges, self.Rs_parent_part, A, b))
