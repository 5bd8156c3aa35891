"""The poses of neighbouring frames as one problem of least squares.

Unknown are the poses of some frames, and what many of them share, such as the place where a planted
foot stands; the other frames are held exactly. To compare a motion with something more, write a
term or a link and put it into the list of the solve that it belongs to.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.steps import add_blocks, move_poses
from keypose.tracker.solver.banded import banded_step, bordered_step
from keypose.tracker.solver.least_squares import Criteria, Problem, least_squares
from keypose.tracker.solver.placed import articulation
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.terms import Link, SharedTerm, Term, total_cost, total_equations

EVERY = slice(None)
INNER = slice(1, -1)
"""All frames; those between two that are held."""


@dataclass(frozen=True, eq=False)
class MotionState:
    """The poses of N frames, and S shared unknowns."""

    motion: Trajectory
    shared: Array = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True, eq=False)
class MotionProblem(Problem[MotionState, "MotionPoint"]):
    """The motion that agrees best with all terms and links.

    unknown: frames whose poses are to be found, which terms are about: their batch axis is that of
    these poses. The others are held exactly.
    """

    skeleton: Skeleton
    terms: Sequence[Term] = ()
    links: Sequence[Link] = ()
    unknown: slice = field(default_factory=lambda: INNER)
    shared_terms: Sequence[SharedTerm] = ()

    def at(self, state: MotionState, count: int) -> MotionPoint:
        return MotionPoint(self, state)

    def moved(self, state: MotionState, step: Array) -> MotionState:
        own = len(step) - len(state.shared)
        steps = step[:own].reshape(-1, self.skeleton.dof_count)
        motion = moved_poses(self.skeleton, state.motion, steps, self.unknown)
        return MotionState(motion, state.shared + step[own:])

    def cost(self, motion: Trajectory) -> float:
        """The cost of a motion where nothing is shared."""
        return self.at(MotionState(motion), 0).cost

    def solve(
        self, start: Trajectory, criteria: Criteria, cancelled: Callable[[], bool] | None = None
    ) -> Trajectory:
        """The motion found from a start where nothing is shared."""
        return least_squares(self, MotionState(start), criteria, cancelled).state.motion


@dataclass(frozen=True, eq=False)
class MotionEquations:
    """Normal equations of u unknown poses and S shared unknowns.

    rows (uD, w) from the diagonal on, b (uD,): of the poses.  border (uD, S), corner (S, S),
    gradient (S,).
    """

    rows: Array
    b: Array
    border: Array
    corner: Array
    gradient: Array

    def step(self, damping: float) -> Array | None:
        """The damped step of all, the poses first; None where they have no solution."""
        if not len(self.gradient):
            return banded_step(self.rows, self.b, damping)
        border, corner = self.border, self.corner
        return bordered_step(self.rows, border, corner, self.b, self.gradient, damping)


@dataclass(frozen=True, eq=False)
class MotionPoint:
    """What is known at a state; the equations of a rejected one are never computed."""

    problem: MotionProblem
    state: MotionState

    @cached_property
    def _posed(self) -> Posed:
        """The unknown poses."""
        motion, unknown = self.state.motion, self.problem.unknown
        R, t = motion.Rs_parent_part[unknown], motion.ps_camera_root[unknown]
        return Posed(self.problem.skeleton, R, t)

    @cached_property
    def cost(self) -> float:
        problem, motion, shared = self.problem, self.state.motion, self.state.shared
        linked = sum(link.cost(motion) for link in problem.links)
        common = sum(term.cost(self._posed, shared) for term in problem.shared_terms)
        return total_cost(problem.terms, self._posed) + linked + common

    @cached_property
    def equations(self) -> MotionEquations:
        problem, shared = self.problem, self.state.shared
        frames = total_equations(problem.terms, self._posed)
        count, dofs = frames.b.shape
        A, b = frames.A, frames.b
        border = np.zeros((count, dofs, len(shared)))
        corner, gradient = np.zeros((len(shared), len(shared))), np.zeros(len(shared))
        for term in problem.shared_terms:
            own = term.rows(self._posed, shared)
            J, K, r = np.swapaxes(own.J, -1, -2), np.swapaxes(own.K, -1, -2), own.r[..., None]
            A[own.frames] += J @ own.J
            b[own.frames] += (J @ r)[..., 0]
            border[own.frames, :, own.unknown] += J @ own.K
            corner[np.ix_(own.unknown, own.unknown)] += (K @ own.K).sum(axis=0)
            gradient[own.unknown] += (K @ r)[..., 0].sum(axis=0)
        width = max((link.width(dofs) for link in problem.links), default=0)
        rows, pull = np.zeros((count * dofs, max(width, dofs))), b.ravel()
        add_blocks(A, 0, rows)
        for link in problem.links:
            link.add_to(self.state.motion, problem.unknown, rows, pull)
        flat = border.reshape(count * dofs, len(shared))
        return MotionEquations(rows, pull, flat, corner, gradient)

    def step(self, damping: float) -> Array | None:
        return self.equations.step(damping)


def moved_poses(
    skeleton: Skeleton, motion: Trajectory, steps: Array, unknown: slice = EVERY
) -> Trajectory:
    """Some poses moved by their rows of steps (u, D), as `keypose.tracker.body.pose.moved`."""
    R, t = motion.writable()
    move_poses(articulation(skeleton), R[unknown], t[unknown], np.ascontiguousarray(steps))
    return Trajectory(motion.first_frame, R, t)
