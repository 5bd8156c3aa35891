"""How the body is turned: joint limits, and the pose near another one, as terms of the solver."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.robust import SQUARED, Kernel
from keypose.tracker.solver.terms import Diagonal, DiagonalTerm, Rows, RowTerm, half_squares


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
        return self._cost(np.sqrt(self.precision) * np.abs(self.away(posed)))

    def diagonal(self, posed: Posed) -> Diagonal:
        away = self.away(posed)
        length = np.sqrt(self.precision) * np.abs(away)
        held = self.precision * self.kernel.weight(length)
        return Diagonal(held, held * away, self._cost(length))

    def _cost(self, away: Array) -> float:
        return 0.5 * float(self.kernel.loss(away).sum())
