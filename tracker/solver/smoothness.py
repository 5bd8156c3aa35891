"""What links neighbouring poses of a segment: how the motion goes on, and how evenly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.banded import banded_diagonals
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.robust import SQUARED, Kernel


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

    @classmethod
    def even(cls, skeleton: Skeleton, frames: int, precision: Array) -> Smoothness:
        """A motion of so many frames that changes as little as it can."""
        return cls(skeleton, np.zeros((max(frames - 2, 0), len(precision))), precision, SQUARED)

    def cost(self, motion: Trajectory) -> float:
        return _cost(self.kernel, self.precision, self._away(motion))

    def equations(self, motion: Trajectory, unknown: slice) -> tuple[Array, Array]:
        away = self._away(motion)
        return _equations((1, -2, 1), len(motion), away, self.precision, self.kernel, unknown)

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

    def equations(self, motion: Trajectory, unknown: slice) -> tuple[Array, Array]:
        """The Jacobian of a step is taken as −1 and 1: exact for the limit of small turns."""
        away = self._away(motion)
        return _equations((-1, 1), len(motion), away, self.precision, self.kernel, unknown)

    def _away(self, motion: Trajectory) -> Array:
        return increments(self.skeleton, motion) - self.measured


def increments(skeleton: Skeleton, motion: Trajectory) -> Array:
    """(N − 1, D) the motion from every pose to the next, in the parts' own frames."""
    R, t = motion.Rs_parent_part, motion.ps_camera_root
    return Posed(skeleton, R[1:], t[1:]).motion_from(R[:-1], t[:-1], backward=False)


def second_differences(skeleton: Skeleton, motion: Trajectory) -> Array:
    """(n, D) how the motion changes from frame to frame at every inner frame."""
    return np.diff(increments(skeleton, motion), axis=0)


def _cost(kernel: Kernel, precision: Array, away: Array) -> float:
    return 0.5 * float(kernel.loss(np.sqrt(precision) * np.abs(away)).sum())


def _equations(
    stencil: tuple[int, ...], count: int, away: Array, precision: Array, kernel: Kernel,
    unknown: slice,
) -> tuple[Array, Array]:  # fmt: skip
    """Make the equations of residuals away (m, D), each the differences of poses i, i + 1, … of
    `count` times the stencil.
    """
    stiff = np.broadcast_to(
        precision * kernel.weight(np.sqrt(precision) * np.abs(away)), away.shape
    )
    m, dofs = away.shape
    pull = stiff * away
    gradient = np.zeros((count, dofs))
    for i, share in reversed(tuple(enumerate(stencil))):
        gradient[i : i + m] += share * pull
    blocks = []
    for off in range(len(stencil)):
        diagonal = np.zeros((max(count - off, 0), dofs))
        for i in reversed(range(len(stencil) - off)):
            diagonal[i : i + m] += stencil[i] * stencil[i + off] * stiff
        blocks.append(diagonal)
    return banded_diagonals(blocks, unknown), gradient[unknown]
