"""What links neighbouring poses of a segment: how the motion goes on, and how evenly."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.steps import add_link, link_cost
from keypose.tracker.solver.placed import motions_of, numbered
from keypose.tracker.solver.robust import SQUARED, Kernel


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

    def width(self, dofs: int) -> int:
        """Each degree of freedom is coupled with its own of other frames alone."""
        return 1 + (len(self.stencil) - 1) * dofs

    def cost(self, motion: Trajectory) -> float:
        return float(link_cost(self.of(motion), *self._wanted))

    def add_to(self, motion: Trajectory, unknown: slice, rows: Array, b: Array) -> None:
        first, _, _ = unknown.indices(len(motion))
        stencil = np.array(self.stencil, np.float64)
        add_link(self.of(motion), *self._wanted, stencil, first, rows, b)

    @cached_property
    def _wanted(self) -> tuple[Array, Array, int, float]:
        """For the loops, which would be compiled once more for values that lie in another order."""
        precision = np.array(np.broadcast_to(self.precision, self.wanted.shape), order="C")
        return np.array(self.wanted, order="C"), precision, *numbered(self.kernel)


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
    R, t = motion.writable()
    return motions_of(skeleton, R[:-1], t[:-1], R[1:], t[1:], backward=False)


def second_differences(skeleton: Skeleton, motion: Trajectory) -> Array:
    """(n, D) how the motion changes from frame to frame at every inner frame."""
    return np.diff(increments(skeleton, motion), axis=0)
