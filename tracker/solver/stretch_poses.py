"""All poses of a stretch of neighbouring segments, and what many of its frames share.

Keyframes are among the unknown poses: terms hold them, exactly or softly. What is shared, such as
the place where a planted foot stands, is unknown too and solved along.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array, exp_rotation, nearest_rotation
from keypose.tracker.solver.banded import added, bordered_step, with_frames
from keypose.tracker.solver.least_squares import Problem
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.smoothness import Link
from keypose.tracker.solver.terms import Term, total_cost, total_equations

EVERY = slice(None)


@dataclass(frozen=True, eq=False)
class MotionWindow:
    """A state: the poses of N frames, and S shared unknowns."""

    motion: Trajectory
    shared: Array


@dataclass(frozen=True, eq=False)
class SharedEquations:
    """Normal equations of some frames and some of the shared unknowns; those of no others.

    frames: of n neighbouring ones, A (n, D, D) and b (n, D).  unknown (s,): which of the shared.
    border (n, D, s), corner (s, s), gradient (s,): of these.
    """

    frames: slice
    A: Array
    b: Array
    unknown: NDArray[np.int64]
    border: Array
    corner: Array
    gradient: Array

    @classmethod
    def alone(
        cls, dofs: int, unknown: NDArray[np.int64], corner: Array, gradient: Array
    ) -> SharedEquations:
        """Make equations of shared unknowns that are compared with no pose."""
        A, b = np.zeros((0, dofs, dofs)), np.zeros((0, dofs))
        border = np.zeros((0, dofs, len(unknown)))
        return cls(slice(0, 0), A, b, unknown, border, corner, gradient)


class SharedTerm(Protocol):
    """What poses and shared unknowns are compared with."""

    def cost(self, posed: Posed, shared: Array) -> float:
        """Half the sum of squares, robust ones by their kernel."""

    def equations(self, posed: Posed, shared: Array) -> SharedEquations:
        """Linearized there."""


@dataclass(frozen=True, eq=False)
class StretchPoses(Problem[MotionWindow, "StretchPoint"]):
    """The motion and the shared unknowns that agree best with all terms and links."""

    skeleton: Skeleton
    terms: Sequence[Term]
    links: Sequence[Link]
    shared_terms: Sequence[SharedTerm] = ()

    def at(self, state: MotionWindow, count: int) -> StretchPoint:
        return StretchPoint(self, state)

    def moved(self, state: MotionWindow, step: Array) -> MotionWindow:
        dofs = self.skeleton.dof_count
        own = len(state.motion) * dofs
        motion = moved_poses(self.skeleton, state.motion, step[:own].reshape(-1, dofs))
        return MotionWindow(motion, state.shared + step[own:])


@dataclass(frozen=True, eq=False)
class StretchPoint:
    """What is known at a state; the equations of a rejected one are never computed."""

    problem: StretchPoses
    state: MotionWindow

    @cached_property
    def _posed(self) -> Posed:
        motion = self.state.motion
        return Posed(self.problem.skeleton, motion.Rs_parent_part, motion.ps_camera_root)

    @cached_property
    def cost(self) -> float:
        problem, shared = self.problem, self.state.shared
        cost = total_cost(problem.terms, self._posed)
        cost += sum(link.cost(self.state.motion) for link in problem.links)
        return cost + sum(term.cost(self._posed, shared) for term in problem.shared_terms)

    def step(self, damping: float) -> Array | None:
        problem, motion, shared = self.problem, self.state.motion, self.state.shared
        frames = total_equations(problem.terms, self._posed)
        count, dofs = frames.b.shape
        A, b = frames.A, frames.b
        border = np.zeros((count, dofs, len(shared)))
        corner, gradient = np.zeros((len(shared), len(shared))), np.zeros(len(shared))
        for term in problem.shared_terms:
            own = term.equations(self._posed, shared)
            A[own.frames] += own.A
            b[own.frames] += own.b
            border[own.frames, :, own.unknown] += own.border
            corner[np.ix_(own.unknown, own.unknown)] += own.corner
            gradient[own.unknown] += own.gradient
        banded = np.zeros((dofs, count * dofs))
        for link in problem.links:
            linked, pull = link.equations(motion, EVERY)
            banded, b = added(banded, linked), b + pull
        flat = border.reshape(count * dofs, len(shared))
        found = bordered_step(with_frames(banded, A), flat, corner, b.ravel(), gradient, damping)
        return None if found is None else np.concatenate(found)


def moved_poses(skeleton: Skeleton, motion: Trajectory, steps: Array) -> Trajectory:
    """Every pose moved by its row of steps (N, D), as `keypose.tracker.body.pose.moved`."""
    turns, shifts = (np.flatnonzero(skeleton.dof_turns == kind) for kind in (1, 0))
    turn, shift = np.zeros((len(motion), skeleton.part_count, 3)), np.zeros((len(motion), 3))
    turn[:, skeleton.dof_part[turns], skeleton.dof_axis[turns]] = steps[:, turns]
    shift[:, skeleton.dof_axis[shifts]] = steps[:, shifts]
    R, t = motion.Rs_parent_part, motion.ps_camera_root
    along = (R[:, 0] @ shift[..., None])[..., 0]
    return Trajectory(motion.first_frame, nearest_rotation(R @ exp_rotation(turn)), t + along)
