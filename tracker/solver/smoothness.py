"""What links neighbouring poses of a segment: how the motion goes on, and how evenly."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.banded import banded_diagonals
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.robust import SQUARED, Kernel
from keypose.tracker.solver.terms import robust_cost


@dataclass(frozen=True, eq=False)
class _Differences(ABC):
    """Wanted differences (m, D) of neighbouring poses.

    precision (D,), or (m, D) of every difference: 1/σ² of what differs from them, 0 where nothing
    is wanted.  stencil: how often each of the poses counts. The Jacobian is taken as that: exact
    for the limit of small turns.
    """

    stencil: ClassVar[tuple[int, ...]]
    skeleton: Skeleton
    wanted: Array
    precision: Array
    kernel: Kernel

    @abstractmethod
    def of(self, motion: Trajectory) -> Array:
        """(m, D) the differences of a motion."""

    def cost(self, motion: Trajectory) -> float:
        away = np.abs(self.of(motion) - self.wanted)
        return robust_cost(self.kernel, np.sqrt(self.precision) * away)

    def equations(self, motion: Trajectory, unknown: slice) -> tuple[Array, Array]:
        away, stencil = self.of(motion) - self.wanted, self.stencil
        weight = self.kernel.weight(np.sqrt(self.precision) * np.abs(away))
        stiff = np.broadcast_to(self.precision * weight, away.shape)
        (m, dofs), count, pull = away.shape, len(motion), stiff * away
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


class Increments(_Differences):
    """The measured motion of every step, as `increments`."""

    stencil = (-1, 1)

    def of(self, motion: Trajectory) -> Array:
        return increments(self.skeleton, motion)


class Smoothness(_Differences):
    """The wanted change of the motion from frame to frame, at each inner frame."""

    stencil = (1, -2, 1)

    @classmethod
    def even(cls, skeleton: Skeleton, frames: int, precision: Array) -> Smoothness:
        """A motion of so many frames that changes as little as it can."""
        return cls(skeleton, np.zeros((max(frames - 2, 0), len(precision))), precision, SQUARED)

    def of(self, motion: Trajectory) -> Array:
        return second_differences(self.skeleton, motion)


def increments(skeleton: Skeleton, motion: Trajectory) -> Array:
    """(N − 1, D) the motion from every pose to the next, in the parts' own frames."""
    R, t = motion.Rs_parent_part, motion.ps_camera_root
    return Posed(skeleton, R[1:], t[1:]).motion_from(R[:-1], t[:-1], backward=False)


def second_differences(skeleton: Skeleton, motion: Trajectory) -> Array:
    """(n, D) how the motion changes from frame to frame at every inner frame."""
    return np.diff(increments(skeleton, motion), axis=0)
