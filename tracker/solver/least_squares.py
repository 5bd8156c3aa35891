"""The one loop of damped least squares: Levenberg–Marquardt, and Gauss–Newton as a case of it.

What is minimised is a `Problem`: what is known at a state, and how a state moves. When to stop, how
far to step and how to damp are data, `Criteria`. The problem decides what a state is (a pose, the
poses of a segment, poses with sizes) and how its equations are solved (dense, banded, an arrow).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Literal, Protocol, TypeAlias, TypeVar

import numpy as np

from keypose.tracker.geometry.rotations import Array

End: TypeAlias = Literal["settled", "no gain", "steps", "cancelled", "unsolvable"]


@dataclass(frozen=True)
class Damping:
    """How damping changes: times `harder` after a step that is rejected, divided by `easier` after
    one that is taken, never below `least`. Above `most`, and where it cannot grow, the descent
    ends."""

    first: float = 1e-3
    harder: float = 10.0
    easier: float = 10.0
    least: float = 0.0
    most: float = 1e16


@dataclass(frozen=True)
class Criteria:
    """How to descend, and when to stop.

    most_steps:  steps taken at most.  most_solves: solves at most, with those rejected.
    least_steps: steps before which none counts as settled, as while a kernel narrows.
    most_tries:  solves at most for one step.
    longest_step: a longer one is shortened to it; length is the largest component.
    settled:     a step that travels less is the last one (see `Problem.travel`).
    negligible:  a shorter step is not taken any more.
    gain, gain_floor: a step that lowers the cost by less than gain · (cost + gain_floor) is the
        last one.
    rejects:     a step that does not lower the cost is not taken. Otherwise costs are not computed.
    """

    most_steps: float = np.inf
    most_solves: float = np.inf
    least_steps: int = 0
    most_tries: float = np.inf
    longest_step: float = np.inf
    settled: float = 0.0
    negligible: float = 0.0
    gain: float = 0.0
    gain_floor: float = 0.0
    damping: Damping = Damping()
    rejects: bool = True


QUICK = Criteria(
    most_steps=12, longest_step=0.3, settled=1e-3, gain=1e-3,
    damping=Damping(first=1e-4, least=1e-7, most=1e6),
)  # fmt: skip
"""From near by: one pass of several, or the last solve of a motion that is nearly right."""
USUAL = Criteria(
    most_steps=25, longest_step=0.3, settled=1e-3, gain=1e-3,
    damping=Damping(first=1e-3, least=1e-6, most=1e6),
)  # fmt: skip
"""From afar, where no pass follows."""
EXACT = Criteria(
    most_steps=120,
    longest_step=0.3,
    settled=1e-9,
    damping=Damping(first=1e-6, least=1e-12, most=1e6),
)
"""To the last digits, where what is found has to be met."""
JOINTS = Criteria(
    most_steps=120,
    longest_step=0.5,
    negligible=1e-6,
    gain=1e-5,
    gain_floor=1.0,
    damping=Damping(least=1e-9, most=1e10),
)
"""From anywhere, along what joints hardly decide: a step that gains little ends it, however far."""
UNJUDGED = Criteria(
    longest_step=0.3, settled=2e-4, rejects=False, damping=Damping(first=1e-4, easier=1.0)
)
"""Where a picture is looked at anew with every step, so that no two costs compare."""


class Linearized(Protocol):
    """What is known at a state. Where costs are cheap and equations dear, the latter are best
    computed with the first step: a state that is rejected needs none."""

    @property
    def cost(self) -> float:
        """Half the sum of squares; infinite where a state cannot be."""

    def step(self, damping: float) -> Array | None:
        """The damped step downhill; None where the equations have no solution."""


State = TypeVar("State")
Point = TypeVar("Point", bound=Linearized)


class Problem(Protocol[State, Point]):
    """A problem of least squares: what is minimised."""

    def at(self, state: State, count: int) -> Point:
        """What is known at a state, the `count`th from 0."""

    def moved(self, state: State, step: Array) -> State:
        """The state after a step."""

    def travel(self, here: Point, there: Point, step: Array) -> float:
        """How far a step leads."""
        return largest(step)


@dataclass(frozen=True, eq=False)
class Solution(Generic[State, Point]):
    """Where the descent ended.

    here:   what is known there.  solved, damping: the last point whose equations were solved, and
            how they were damped; None where none were.
    steps, solves: how many were taken, and how many solves that took.
    """

    state: State
    here: Point
    solved: Point | None
    damping: float
    steps: int
    solves: int
    end: End

    @property
    def cost(self) -> float:
        return self.here.cost

    @property
    def converged(self) -> bool:
        """Whether it came to rest there."""
        return self.end in ("settled", "no gain")


def least_squares(
    problem: Problem[State, Point],
    start: State,
    criteria: Criteria,
    cancelled: Callable[[], bool] | None = None,
) -> Solution[State, Point]:
    """Step downhill from a start until the criteria say stop."""
    descent = _Descent(problem, start, criteria)
    while descent.end is None:
        descent.advance(cancelled)
    return Solution(
        descent.state,
        descent.here,
        descent.solved,
        descent.damped,
        descent.steps,
        descent.solves,
        descent.end,
    )


class _Descent(Generic[State, Point]):
    """The loop's own state."""

    def __init__(self, problem: Problem[State, Point], start: State, criteria: Criteria) -> None:
        self.problem, self.criteria = problem, criteria
        self.state, self.here = start, problem.at(start, 0)
        self.solved: Point | None = None
        self.damping = self.damped = criteria.damping.first
        self.steps = self.solves = self.tries = 0
        hopeless = criteria.rejects and not np.isfinite(self.here.cost)
        self.end: End | None = "unsolvable" if hopeless else None

    def advance(self, cancelled: Callable[[], bool] | None) -> None:
        """One solve, and the step it leads to."""
        how = self.criteria
        if self.steps >= how.most_steps or self.solves >= how.most_solves:
            self.end = "steps"
        elif cancelled is not None and cancelled():
            self.end = "cancelled"
        elif (step := self._step()) is None:
            self._reject("unsolvable")
        elif how.negligible and largest(step) < how.negligible:
            self.end = "settled"
        else:
            self._try(step)

    def _step(self) -> Array | None:
        self.solved = None  # whose equations may go before others are made
        step = self.here.step(self.damping)
        self.solved, self.damped = self.here, self.damping
        self.solves, self.tries = self.solves + 1, self.tries + 1
        if step is None or not np.isfinite(length := largest(step)):
            return None
        return step * min(1.0, self.criteria.longest_step / max(length, 1e-12))

    def _try(self, step: Array) -> None:
        state = self.problem.moved(self.state, step)
        there = self.problem.at(state, self.solves)
        if self.criteria.rejects and not there.cost < self.here.cost:
            self._reject("no gain")
            return
        here, self.state, self.here = self.here, state, there
        self.steps, self.tries = self.steps + 1, 0
        damping = self.criteria.damping
        self.damping = max(self.damping / damping.easier, damping.least)
        self.end = self._reason_to_stop(here, step)

    def _reason_to_stop(self, before: Point, step: Array) -> End | None:
        """Why the step just taken is the last one; None where it is not."""
        how = self.criteria
        is_early = self.steps < how.least_steps
        if how.settled and not is_early and self._travel(before, step) < how.settled:
            return "settled"
        if how.gain and before.cost - self.here.cost < how.gain * (self.here.cost + how.gain_floor):
            return "no gain"
        return None

    def _travel(self, before: Point, step: Array) -> float:
        return self.problem.travel(before, self.here, step)

    def _reject(self, end: End) -> None:
        """Damp harder, or end with the reason `end` where that is not allowed."""
        how, before = self.criteria, self.damping
        self.damping *= how.damping.harder
        harder = before < self.damping <= how.damping.most
        if not how.rejects or not harder or self.tries >= how.most_tries:
            self.end = end


def largest(step: Array) -> float:
    """The largest component of a step."""
    return float(np.abs(step).max(initial=0.0))


def damped_step(A: Array, b: Array, damping: float, floor: Array | float = 0.0) -> Array:
    """The step −(A + damping · (diag A + floor))⁻¹ b of dense equations A (D, D), b (D,)."""
    if damping:
        A = A.copy()
        on = np.einsum("dd->d", A)
        on += damping * (on + floor)
    return np.asarray(-np.linalg.solve(A, b), np.float64)
