"""What links neighbouring poses of a segment: how the motion goes on, and how evenly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tracker.body.skeleton import Skeleton
from tracker.body.trajectory import Trajectory
from tracker.geometry.rotations import Array, log_rotation, transpose
from tracker.solver.posed import by_dof
from tracker.solver.robust import Kernel


class Link(Protocol):
    """What a motion is compared with from frame to frame.

    Unknown are its poses but the first, which does not move, and the last, unless `open_end`.
    """

    def cost(self, motion: Trajectory) -> float:
        """Half the sum of squares, robust ones by their kernel."""

    def equations(self, motion: Trajectory, open_end: bool = False) -> tuple[Array, Array]:
        """Upper banded (3D, uD) and gradient (u, D) of the u unknown poses."""


@dataclass(frozen=True, eq=False)
class Smoothness:
    """The wanted change of the motion from frame to frame, at each of n inner frames.

    wanted (n, D): second differences of the poses.
    precision (D,), or (n, D) of every inner frame: 1/σ² of what differs from them.
    """

    skeleton: Skeleton
    wanted: Array
    precision: Array
    kernel: Kernel

    def cost(self, motion: Trajectory) -> float:
        return _cost(self.kernel, self.precision, self._away(motion))

    def equations(self, motion: Trajectory, open_end: bool = False) -> tuple[Array, Array]:
        away = self._away(motion)
        n = len(away)
        k = np.eye(n, n + 2) - 2 * np.eye(n, n + 2, k=1) + np.eye(n, n + 2, k=2)
        return _equations(_of_unknown(k, open_end), away, self.precision, self.kernel)

    def _away(self, motion: Trajectory) -> Array:
        return second_differences(self.skeleton, motion) - self.wanted


@dataclass(frozen=True, eq=False)
class Increments:
    """The measured motion of every step.

    measured (n, D): from pose j to pose j + 1, as `increments`; precision (n, D): 1/σ² of each, 0
    where nothing was measured.
    """

    skeleton: Skeleton
    measured: Array
    precision: Array
    kernel: Kernel

    def cost(self, motion: Trajectory) -> float:
        return _cost(self.kernel, self.precision, self._away(motion))

    def equations(self, motion: Trajectory, open_end: bool = False) -> tuple[Array, Array]:
        """The Jacobian of a step is taken as −1 and 1: exact for the limit of small turns."""
        away = self._away(motion)
        n = len(away)
        k = np.eye(n, n + 1, k=1) - np.eye(n, n + 1)
        return _equations(_of_unknown(k, open_end), away, self.precision, self.kernel)

    def _away(self, motion: Trajectory) -> Array:
        return increments(self.skeleton, motion) - self.measured


def increments(skeleton: Skeleton, motion: Trajectory) -> Array:
    """(N − 1, D) the motion from every pose to the next, in the parts' own frames."""
    R, t = motion.Rs_parent_part, motion.ps_camera_root
    turn = log_rotation(transpose(R[:-1]) @ R[1:])
    return by_dof(skeleton, turn, R[:-1, 0], np.diff(t, axis=0))


def second_differences(skeleton: Skeleton, motion: Trajectory) -> Array:
    """(n, D) how the motion changes from frame to frame at every inner frame."""
    return np.diff(increments(skeleton, motion), axis=0)


def _of_unknown(k: Array, open_end: bool) -> Array:
    """The columns of the unknown poses."""
    return k[:, 1:] if open_end else k[:, 1:-1]


def _cost(kernel: Kernel, precision: Array, away: Array) -> float:
    return 0.5 * float(kernel.loss(np.sqrt(precision) * np.abs(away)).sum())


def _equations(k: Array, away: Array, precision: Array, kernel: Kernel) -> tuple[Array, Array]:
    """Of residuals away (m, D) whose Jacobian is k (m, u) for every degree of freedom."""
    stiff = precision * kernel.weight(np.sqrt(precision) * np.abs(away))
    unknown, dofs = k.shape[1], away.shape[1]
    banded = np.zeros((3 * dofs, unknown * dofs))
    for off in range(min(3, unknown)):
        products = k[:, : unknown - off] * k[:, off:]
        banded[-1 - off * dofs, off * dofs :] = (products.T @ stiff).ravel()
    return banded, k.T @ (stiff * away)
