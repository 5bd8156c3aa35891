"""The poses of a segment as a problem of least squares: terms of every frame, and links between."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.layout import BodyArrays
from keypose.tracker.kernels.whole import move_inner
from keypose.tracker.solver.banded import added, banded_step, with_frames
from keypose.tracker.solver.least_squares import Problem
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.smoothness import INNER, Link
from keypose.tracker.solver.terms import Term, total_cost, total_equations


@dataclass(frozen=True, eq=False)
class SegmentPoses(Problem[Trajectory, "SegmentPoint"]):
    """The motion that agrees best with all terms and links.

    Its first pose stays, and its last unless `open_end`; the others are unknown, and `terms` are
    about them: their batch axis is that of the unknown poses.
    arrays: of the body, for the loops.
    """

    skeleton: Skeleton
    arrays: BodyArrays
    terms: Sequence[Term]
    links: Sequence[Link]
    open_end: bool = False

    @property
    def unknown(self) -> slice:
        return slice(1, None) if self.open_end else INNER

    def at(self, state: Trajectory, count: int) -> SegmentPoint:
        return SegmentPoint(self, state)

    def moved(self, state: Trajectory, step: Array) -> Trajectory:
        R, t = state.writable()
        move_inner(self.arrays, R, t, step.reshape(-1, self.skeleton.dof_count))
        return Trajectory(state.first_frame, R, t)


@dataclass(frozen=True, eq=False)
class SegmentPoint:
    """What is known at a motion; the equations of a rejected one are never computed."""

    problem: SegmentPoses
    motion: Trajectory

    @cached_property
    def _posed(self) -> Posed:
        """The unknown poses."""
        unknown = self.problem.unknown
        R, t = self.motion.Rs_parent_part[unknown], self.motion.ps_camera_root[unknown]
        return Posed(self.problem.skeleton, R, t)

    @cached_property
    def cost(self) -> float:
        linked = sum(link.cost(self.motion) for link in self.problem.links)
        return total_cost(self.problem.terms, self._posed) + linked

    @cached_property
    def equations(self) -> tuple[Array, Array]:
        """Upper banded (3D, uD) and gradient (uD,) of the u unknown poses."""
        frames = total_equations(self.problem.terms, self._posed)
        banded = np.zeros((frames.b.shape[-1], frames.b.size))
        pull = np.zeros_like(frames.b)
        for link in self.problem.links:
            own, gradient = link.equations(self.motion, self.problem.unknown)
            banded, pull = added(banded, own), pull + gradient
        return with_frames(banded, frames.A), (frames.b + pull).ravel()

    def step(self, damping: float) -> Array | None:
        return banded_step(*self.equations, damping)
