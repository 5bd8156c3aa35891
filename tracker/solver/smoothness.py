"""What links neighbouring poses of a segment: how the motion goes on, and how evenly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array, log_rotation, transpose
from keypose.tracker.solver.banded import banded_diagonals
from keypose.tracker.solver.posed import by_dof
from keypose.tracker.solver.robust import Kernel

INNER = slice(1, -1)
"""The poses between two that do not move."""


class Link(Protocol):
    """A residual that links neighbouring frames of a motion."""

    def cost(self, motion: Trajectory) -> float:
        """Half the sum of squares, robust ones by their kernel."""

    def equations(self, motion: Trajectory, unknown: slice = INNER) -> tuple[Array, Array]:
        """Upper banded (w, uD) and gradient (u, D) of the u unknown poses."""


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

    def equations(self, motion: Trajectory, unknown: slice = INNER) -> tuple[Array, Array]:
        return _equations((1, -2, 1), self._away(motion), self.precision, self.kernel, unknown)

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

    def equations(self, motion: Trajectory, unknown: slice = INNER) -> tuple[Array, Array]:
        """The Jacobian of a step is taken as −1 and 1: exact for the limit of small turns."""
        return _equations((-1, 1), self._away(motion), self.precision, self.kernel, unknown)

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


def _cost(kernel: Kernel, precision: Array, away: Array) -> float:
    return 0.5 * float(kernel.loss(np.sqrt(precision) * np.abs(away)).sum())


def _equations(
    stencil: tuple[int, ...], away: Array, precision: Array, kernel: Kernel, unknown: slice
) -> tuple[Array, Array]:
    """Make the equations of residuals away (m, D), each the differences of poses i, i + 1, … times
    the stencil.
    """
    stiff = np.broadcast_to(
        precision * kernel.weight(np.sqrt(precision) * np.abs(away)), away.shape
    )
    m, dofs = away.shape
    count, pull = m + len(stencil) - 1, stiff * away
    gradient = np.zeros((count, dofs))
    for i, share in reversed(tuple(enumerate(stencil))):
        gradient[i : i + m] += share * pull
    blocks = []
    for off in range(len(stencil)):
        diagonal = np.zeros((count - off, dofs))
        for i in reversed(range(len(stencil) - off)):
            diagonal[i : i + m] += stencil[i] * stencil[i + off] * stiff
        blocks.append(diagonal)
    return banded_diagonals(blocks, unknown), gradient[unknown]
