"""Poses as `Placed` has them, in plain NumPy: for one pose, of which loops would have to be loaded
first. Who poses by hand needs none.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.body.joint_limits import SoftLimits
from keypose.tracker.body.pose import part_transforms, twists
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, log_rotation, transpose
from keypose.tracker.solver.projection import image_jacobian, image_points
from keypose.tracker.solver.robust import Kernel

if TYPE_CHECKING:
    from keypose.tracker.kernels.layout import Places


@dataclass(frozen=True, eq=False)
class PlainPlaced:
    """N poses of a body: Rs_parent_part (N, P, 3, 3), ps_camera_root (N, 3)."""

    skeleton: Skeleton
    Rs_parent_part: Array
    ps_camera_root: Array

    @cached_property
    def Ts_camera_part(self) -> Array:
        """(N, P, 4, 4)"""
        return part_transforms(self.skeleton, self.Rs_parent_part, self.ps_camera_root)

    @cached_property
    def twists(self) -> Array:
        """(N, D, 6)"""
        return twists(self.skeleton, self.Ts_camera_part)

    def positions(self, places: Places) -> Array:
        """(N, J, 3) in the camera frame."""
        return _means(places, self._points(places))

    def jacobian(self, places: Places) -> tuple[Array, Array]:
        """The same, and (N, J, D, 3) how they move with each degree of freedom."""
        p = self._points(places)
        S = self.twists[:, None]
        J = S[..., :3] + np.cross(S[..., 3:], p[:, :, None])
        J *= places.moves[..., None]
        return _means(places, p), _means(places, J)

    def motion_from(self, Rs_parent_part: Array, ps_camera_root: Array, *, backward: bool) -> Array:
        """(N, D) as `Posed.motion_from`."""
        skeleton = self.skeleton
        turn = log_rotation(transpose(Rs_parent_part) @ self.Rs_parent_part)
        Rs = self.Rs_parent_part if backward else Rs_parent_part
        shift = (transpose(Rs[:, 0]) @ (self.ps_camera_root - ps_camera_root)[..., None])[..., 0]
        by_turn = turn[:, skeleton.dof_part, skeleton.dof_axis]
        return np.where(skeleton.dof_turns == 1, by_turn, shift[:, skeleton.dof_axis])

    def picture_cost(
        self,
        places: Places,
        camera: Camera,
        uv: Array,
        scale: Array,
        nearest_m: float,
        kernel: Kernel,
    ) -> float:
        """As `Placed.picture_cost`."""
        p = self.positions(places)
        if not (p[..., 2] > nearest_m).all():
            return np.inf
        away = _known(image_points(camera, p) - uv, scale[..., None])
        return _cost(kernel, np.linalg.norm(away, axis=-1))

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
        """As `Placed.add_picture`."""
        p, J = self.jacobian(places)
        away = _known(image_points(camera, p) - uv, scale[..., None])
        length = np.linalg.norm(away, axis=-1)
        weight = np.sqrt(kernel.weight(length))[..., None]
        rows = image_jacobian(camera, p, J) * (weight * scale[..., None])[..., None]
        _add(A, b, np.swapaxes(rows, -1, -2), away * weight)
        return _cost(kernel, length) if (p[..., 2] > nearest_m).all() else np.inf

    def depth_cost(self, places: Places, depth: Array, scale: Array, kernel: Kernel) -> float:
        """As `Placed.depth_cost`."""
        return _cost(kernel, np.abs(self._deeper(self.positions(places), depth, scale)))

    def add_depth(
        self, places: Places, depth: Array, scale: Array, kernel: Kernel, A: Array, b: Array
    ) -> float:
        """As `Placed.add_depth`."""
        p, J = self.jacobian(places)
        away = self._deeper(p, depth, scale)
        along = J[..., 2] * (self.skeleton.dof_turns == 1)  # what shifts them shifts the root
        weight = np.sqrt(kernel.weight(np.abs(away)))
        _add(A, b, (along * (weight * scale)[..., None])[..., None, :], (away * weight)[..., None])
        return _cost(kernel, np.abs(away))

    def limit_cost(self, limits: SoftLimits) -> float:
        """As `Placed.limit_cost`."""
        outside, _ = limits.excess(self.Rs_parent_part)
        return 0.5 * float(((outside / limits.sigma_rad) ** 2).sum())

    def add_limits(self, limits: SoftLimits, A: Array, b: Array) -> float:
        """As `Placed.add_limits`."""
        skeleton, sigma_rad = self.skeleton, limits.sigma_rad
        outside, slopes = limits.excess(self.Rs_parent_part)
        part, angle = np.nonzero((outside != 0).any(axis=0))
        own = (part[:, None] == skeleton.dof_part) & (skeleton.dof_turns == 1)
        rows = own * slopes[:, part[:, None], angle[:, None], skeleton.dof_axis]
        r = outside[:, part, angle] / sigma_rad
        _add(A, b, (rows / sigma_rad)[..., None, :], r[..., None])
        return 0.5 * float((r**2).sum())

    def _points(self, places: Places) -> Array:
        """(N, K, 3) the single points."""
        T = self.Ts_camera_part[:, places.parts]
        return np.asarray((T[..., :3, :3] @ places.points[..., None])[..., 0] + T[..., :3, 3])

    def _deeper(self, p: Array, depth: Array, scale: Array) -> Array:
        """(N, J) by how much places p are farther than they should be, in σ."""
        return _known(p[..., 2] - self.ps_camera_root[:, None, 2] - depth, scale)


def _known(away: Array, scale: Array) -> Array:
    """Differences in standard deviations; 0 where nothing is known, whatever stands there."""
    return np.where(scale > 0, away, 0.0) * scale


def _means(places: Places, of_points: Array) -> Array:
    """(N, J, …) of what belongs to single points (N, K, …)."""
    counts = np.diff(places.starts)
    if (counts == 1).all():
        return of_points
    sums = np.add.reduceat(of_points, places.starts[:-1], axis=1)
    return np.asarray(sums / counts.reshape(-1, *[1] * (of_points.ndim - 2)))


def _add(A: Array, b: Array, rows: Array, r: Array) -> None:
    """A (N, D, D), b (N, D) += the normal equations of rows (N, J, c, D), residuals (N, J, c)."""
    J, r = rows.reshape(len(A), -1, rows.shape[-1]), r.reshape(len(A), -1, 1)
    A += transpose(J) @ J
    b += (transpose(J) @ r)[..., 0]


def _cost(kernel: Kernel, away: Array) -> float:
    return 0.5 * float(kernel.loss(away).sum())
