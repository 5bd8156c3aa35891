"""Terms of one pose: points in space and in pictures, joint limits, and a prior pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import BodyPoints, Posed, image_jacobian, image_points
from keypose.tracker.solver.robust import SQUARED, Kernel
from keypose.tracker.solver.terms import (
    Diagonal,
    DiagonalTerm,
    Rows,
    RowTerm,
    half_squares,
    robust_cost,
)


@dataclass(frozen=True, eq=False)
class PointsInSpace(RowTerm):
    """Points of the body at positions (..., K, 3) in the camera frame, metres."""

    points: BodyPoints
    positions: Array
    sigma_m: float

    def cost(self, posed: Posed) -> float:
        return half_squares((self.points.of(posed) - self.positions) / self.sigma_m)

    def rows(self, posed: Posed) -> Rows:
        p, J = self.points.jacobian(posed)
        away = (p - self.positions) / self.sigma_m
        return Rows(_flat(away), _rows_of(J / self.sigma_m), half_squares(away))


@dataclass(frozen=True, eq=False)
class PointsInPicture(RowTerm):
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
        p = self.points.of(posed)
        away = np.linalg.norm(image_points(self.camera, p) - self.uv, axis=-1) * self.scale
        return self._cost(p, away)

    def rows(self, posed: Posed) -> Rows:
        p, J = self.points.jacobian(posed)
        away = (image_points(self.camera, p) - self.uv) * self.scale[..., None]
        length = np.linalg.norm(away, axis=-1)
        weight = np.sqrt(self.kernel.weight(length))
        seen = image_jacobian(self.camera, p, J) * (weight * self.scale)[..., None, None]
        return Rows(_flat(away * weight[..., None]), _rows_of(seen), self._cost(p, length))

    def _cost(self, p: Array, away: Array) -> float:
        """The cost of points p whose pixels are so many σ away."""
        if not (p[..., 2] > self.nearest_m).all():
            return np.inf
        return robust_cost(self.kernel, away)


@dataclass(frozen=True, eq=False)
class DepthFromRoot(RowTerm):
    """Points of the body so much farther away than its root: depth (..., K), metres along z.

    scale (..., K): 1/σ in 1/m, 0 where a depth is not known.
    """

    points: BodyPoints
    depth: Array
    scale: Array
    kernel: Kernel = SQUARED

    def cost(self, posed: Posed) -> float:
        return robust_cost(self.kernel, np.abs(self._away(posed, self.points.of(posed))))

    def rows(self, posed: Posed) -> Rows:
        skeleton = posed.skeleton
        p, J = self.points.jacobian(posed)
        away = self._away(posed, p)
        shifts = np.flatnonzero(skeleton.dof_turns == 0)
        along = J[..., 2].copy()
        R_root = posed.Rs_parent_part[..., 0, :, :]
        along[..., shifts] -= R_root[..., None, 2, skeleton.dof_axis[shifts]]
        length = np.abs(away)
        weight, cost = np.sqrt(self.kernel.weight(length)), robust_cost(self.kernel, length)
        return Rows(away * weight, along * (weight * self.scale)[..., None], cost)

    def _away(self, posed: Posed, p: Array) -> Array:
        """(..., K) in σ."""
        return np.asarray((p[..., 2] - posed.p_camera_root[..., None, 2] - self.depth) * self.scale)


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


def _flatten_rows(J: Array) -> Array:
    """(..., K · C, D) of (..., K, C, D)."""
    return J.reshape(*J.shape[:-3], -1, J.shape[-1])


def _rows_of(J: Array) -> Array:
    """(..., K · C, D) of a Jacobian of points (..., K, D, C)."""
    return _flatten_rows(np.swapaxes(J, -1, -2))


@dataclass(frozen=True, eq=False)
class JointLimits(RowTerm):
    """Joint angles and twists within their limits.

    allowed (P, 4): radians, signed, by which a joint may lie outside, as in a posed keyframe.
    onset_rad:      so far beyond a limit its slope grows from 0 to 1, and the residual lags behind
                    by half of it: then a descent of few steps depends steadily on where it starts.
    """

    limits: Limits
    sigma_rad: float
    allowed: Array | None = None
    onset_rad: float = 0.0

    def excess(self, posed: Posed) -> tuple[Array, Array]:
        """Radians (..., P, 4) beyond what is allowed, and their slopes (..., P, 4, 3)."""
        outside, slopes = self.limits.excess(posed.Rs_parent_part)
        if self.allowed is not None:
            low, high = np.minimum(self.allowed, 0.0), np.maximum(self.allowed, 0.0)
            outside = outside - np.clip(outside, low, high)
        if self.onset_rad == 0.0:
            return outside, slopes
        share = np.minimum(np.abs(outside) / self.onset_rad, 1.0)
        lag = self.onset_rad * (share - share**2 / 2)
        return np.copysign(np.abs(outside) - lag, outside), slopes * share[..., None]

    def cost(self, posed: Posed) -> float:
        return half_squares(self.excess(posed)[0] / self.sigma_rad)

    def rows(self, posed: Posed) -> Rows:
        """Only of angles that are exceeded at some pose, of one pose mostly none."""
        skeleton = posed.skeleton
        outside, slopes = self.excess(posed)
        over = outside != 0
        part, angle = np.nonzero(over.reshape(-1, *over.shape[-2:]).any(axis=0))
        turns = np.flatnonzero(skeleton.dof_turns == 1)
        row, turn = np.nonzero(part[:, None] == skeleton.dof_part[turns])
        column = turns[turn]
        J = np.zeros((*outside.shape[:-2], len(part), skeleton.dof_count))
        J[..., row, column] = (slopes * over[..., None])[
            ..., part[row], angle[row], skeleton.dof_axis[column]
        ]
        r = outside[..., part, angle] / self.sigma_rad
        return Rows(r, J / self.sigma_rad, half_squares(r))


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
