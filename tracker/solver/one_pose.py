"""One pose and the terms it is compared with, as a problem of least squares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from keypose.tracker.body.pose import Pose, moved
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.least_squares import Problem, damped_step
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.terms import Equations, Term, total_equations


@dataclass(frozen=True, eq=False)
class PosePoint:
    """What the terms say at one pose."""

    posed: Posed
    terms: Sequence[Term]
    floor: float

    @property
    def cost(self) -> float:
        return self.equations.cost

    @cached_property
    def equations(self) -> Equations:
        return total_equations(self.terms, self.posed)

    def step(self, damping: float) -> Array | None:
        return damped_step(self.equations.A, self.equations.b, damping, self.floor)


@dataclass(frozen=True, eq=False)
class OnePose(Problem[Pose, PosePoint]):
    """The pose that agrees best with all terms.

    floor: damped besides the diagonal, so that what nothing observes stays where it is.
    """

    skeleton: Skeleton
    terms: Sequence[Term]
    floor: float = 0.0

    def at(self, state: Pose, count: int) -> PosePoint:
        return PosePoint(Posed.of(self.skeleton, state), self.terms, self.floor)

    def moved(self, state: Pose, step: Array) -> Pose:
        return moved(self.skeleton, state, step)
