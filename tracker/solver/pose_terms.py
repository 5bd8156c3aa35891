"""Terms of one pose: points in space and in pictures, joint limits, and a prior pose."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from keypose.tracker.body.joint_limits import Limits, SoftLimits
from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import BodyPoints, Posed
from keypose.tracker.solver.robust import SQUARED, Kernel
from keypose.tracker.solver.terms import (
    Diagonal,
    DiagonalTerm,
    Rows,
    RowTerm,
    SummedTerm,
    half_squares,
    robust_cost,
)


@dataclass(frozen=True, eq=False)
class PointsInSpace(RowTerm):
    """Points of the body at positions (..., K, 3) in the camera frame, metres.

    sigma_m: of all, or of each (..., K, 1): infinite where nothing is known.
    """

    points: BodyPoints
    positions: Array
    sigma_m: float | Array

    def cost(self, posed: Posed) -> float:
        return half_squares((self.points.of(posed) - self.positions) / self.sigma_m)

    def rows(self, posed: Posed) -> Rows:
        p, J = self.points.jacobian(posed)
        away = (p - self.positions) / self.sigma_m
        sigma_m = np.asarray(self.sigma_m)
        scale = 1 / (sigma_m[..., None, :] if sigma_m.ndim else sigma_m)
        return Rows(_flat(away), _rows_of(J * scale), half_squares(away))


@dataclass(frozen=True, eq=False)
class PointsInPicture(SummedTerm):
    """Points of the body seen at pixels uv (..., K, 2) by a camera without distortion.

    scale (..., K): 1/σ in 1/px, 0 where a pixel is not known. nearest_m: a pose with a point nearer
    to the camera than that cannot be.
    """

    points: BodyPoints
    camera: Camera
    uv: Array
    scale: Array
    nearest_m: float
    kernel: Kernel = SQUARED

    def cost(self, posed: Posed) -> float:
        return posed.placed.picture_cost(self.points.places, *self._compared(posed))

    def add_to(self, posed: Posed, A: Array, b: Array) -> float:
        return posed.placed.add_picture(self.points.places, *self._compared(posed), A, b)

    def _compared(self, posed: Posed) -> tuple[Camera, Array, Array, float, Kernel]:
        uv, scale = posed.each(self.uv, 2), posed.each(self.scale, 1)
        return self.camera, uv, scale, self.nearest_m, self.kernel


@dataclass(frozen=True, eq=False)
class DepthFromRoot(SummedTerm):
    """Points of the body so much farther away than its root: depth (..., K), metres along z.

    scale (..., K): 1/σ in 1/m, 0 where a depth is not known.
    """

    points: BodyPoints
    depth: Array
    scale: Array
    kernel: Kernel = SQUARED

    def cost(self, posed: Posed) -> float:
        return posed.placed.depth_cost(self.points.places, *self._compared(posed))

    def add_to(self, posed: Posed, A: Array, b: Array) -> float:
        return posed.placed.add_depth(self.points.places, *self._compared(posed), A, b)

    def _compared(self, posed: Posed) -> tuple[Array, Array, Kernel]:
        return posed.each(self.depth, 1), posed.each(self.scale, 1), self.kernel


@dataclass(frozen=True, eq=False)
class RootPosition(RowTerm):
    """The root near a position p (3,) in the camera frame.

    directions (M, 3): what is compared, each over its σ: rows times how far the root is away.
    """

    p_camera_root: Array
    directions: Array

    @classmethod
    def depth(cls, p_camera_root: Array, share: float) -> RootPosition:
        """The root's depth within a share of what it was."""
        return cls(p_camera_root, np.array([[0.0, 0.0, 1 / (share * p_camera_root[2])]]))

    def cost(self, posed: Posed) -> float:
        return half_squares(self._residuals(posed))

    def rows(self, posed: Posed) -> Rows:
        skeleton = posed.skeleton
        shifts = np.flatnonzero(skeleton.dof_turns == 0)
        r = self._residuals(posed)
        J = np.zeros((*r.shape, skeleton.dof_count))
        R = posed.Rs_parent_part[..., 0, :, :]
        J[..., shifts] = (self.directions @ R)[..., skeleton.dof_axis[shifts]]
        return Rows(r, J, half_squares(r))

    def _residuals(self, posed: Posed) -> Array:
        away = posed.p_camera_root - self.p_camera_root
        return np.asarray((self.directions @ away[..., None])[..., 0])


def _flat(r: Array) -> Array:
    return r.reshape(*r.shape[:-2], -1)


def _rows_of(J: Array) -> Array:
    """(..., K · C, D) of a Jacobian of points (..., K, D, C)."""
    rows = np.swapaxes(J, -1, -2)
    return rows.reshape(*rows.shape[:-3], -1, rows.shape[-1])


@dataclass(frozen=True, eq=False)
class JointLimits(SummedTerm):
    """Joint angles and twists within their limits, as `SoftLimits`.

    With an onset, a descent of few steps depends steadily on where it starts.
    """

    limits: Limits
    sigma_rad: float
    allowed: Array | None = None
    onset_rad: float = 0.0

    def cost(self, posed: Posed) -> float:
        return posed.placed.limit_cost(self._soft)

    def add_to(self, posed: Posed, A: Array, b: Array) -> float:
        return posed.placed.add_limits(self._soft, A, b)

    @cached_property
    def _soft(self) -> SoftLimits:
        """One object, of which the loops' arrays are made once."""
        return SoftLimits(self.limits, self.sigma_rad, self.allowed, self.onset_rad)


@dataclass(frozen=True, eq=False)
class PosePrior(DiagonalTerm):
    """The pose near another one, R (..., P, 3, 3) and p (..., 3); precision (D,) is 1/σ².

    Deviations are rotation vectors: their Jacobian is taken as 1. The gradient is exact all the
    same where the axes of a part have one σ, for a rotation vector lies on its own axis.

    backward: see `Posed.motion_from`; without it the gradient is that of small deviations only.
    """

    Rs_parent_part: Array
    p_camera_root: Array
    precision: Array
    kernel: Kernel = SQUARED
    backward: bool = True

    @classmethod
    def of(cls, pose: Pose, precision: Array, backward: bool = True) -> PosePrior:
        """Near one pose."""
        return cls(pose.Rs_parent_part, pose.p_camera_root, precision, backward=backward)

    def away(self, posed: Posed) -> Array:
        """(..., D) the motion that leads from there to a pose."""
        return posed.motion_from(self.Rs_parent_part, self.p_camera_root, self.backward)

    def cost(self, posed: Posed) -> float:
        return robust_cost(self.kernel, np.sqrt(self.precision) * np.abs(self.away(posed)))

    def diagonal(self, posed: Posed) -> Diagonal:
        away = self.away(posed)
        length = np.sqrt(self.precision) * np.abs(away)
        held = self.precision * self.kernel.weight(length)
        return Diagonal(held, held * away, robust_cost(self.kernel, length))
