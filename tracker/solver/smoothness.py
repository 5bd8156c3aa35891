"""How smooth a motion is from frame to frame, over a whole segment between two fixed poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tracker.body.skeleton import Skeleton
from tracker.body.trajectory import Trajectory
from tracker.geometry.rotations import Array, log_rotation, transpose
from tracker.solver.posed import by_dof
from tracker.solver.robust import Kernel


@dataclass(frozen=True, eq=False)
class Smoothness:
    """The wanted change of the motion from frame to frame, at each of n inner frames.

    wanted (n, D): second differences of the poses; precision (D,): 1/σ² of what differs from them.
    """

    skeleton: Skeleton
    wanted: Array
    precision: Array
    kernel: Kernel

    def cost(self, motion: Trajectory) -> float:
        """Half the sum of squares, robust ones by their kernel."""
        away = np.sqrt(self.precision) * np.abs(self._away(motion))
        return 0.5 * float(self.kernel.loss(away).sum())

    def equations(self, motion: Trajectory) -> tuple[Array, Array]:
        """Upper banded (3D, nD) and gradient (n, D) of the inner poses."""
        away = self._away(motion)
        stiff = self.precision * self.kernel.weight(np.sqrt(self.precision) * np.abs(away))
        n, dofs = away.shape
        k = -2 * np.eye(n) + np.eye(n, k=1) + np.eye(n, k=-1)  # the ends do not move
        banded = np.zeros((3 * dofs, n * dofs))
        for off in range(min(3, n)):
            products = k[:, : n - off] * k[:, off:]
            banded[-1 - off * dofs, off * dofs :] = (products.T @ stiff).ravel()
        return banded, k @ (stiff * away)

    def _away(self, motion: Trajectory) -> Array:
        return second_differences(self.skeleton, motion) - self.wanted


def second_differences(skeleton: Skeleton, motion: Trajectory) -> Array:
    """(n, D) how the motion changes from frame to frame at every inner frame."""
    R, t = motion.Rs_parent_part, motion.ps_camera_root
    turn = log_rotation(transpose(R[:-1]) @ R[1:])
    return np.diff(by_dof(skeleton, turn, R[:-1, 0], np.diff(t, axis=0)), axis=0)
