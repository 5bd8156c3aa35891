"""The one loop: what it takes, what it rejects, when it stops, and that it says why."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.solver.least_squares import (
    Criteria,
    Damping,
    Problem,
    Solution,
    damped_step,
    least_squares,
)

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Point:
    r: Floats
    J: Floats

    @property
    def cost(self) -> float:
        return 0.5 * float(self.r @ self.r)

    def step(self, damping: float) -> Floats | None:
        return damped_step(self.J.T @ self.J, self.J.T @ self.r, damping, 1.0)


@dataclass(frozen=True, eq=False)
class Curve(Problem[Floats, Point]):
    """Residuals of x (2,): Rosenbrock's valley unless others are given."""

    residuals: Callable[[Floats], Floats] = lambda x: np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]])

    def at(self, state: Floats, count: int) -> Point:
        columns = [
            (self.residuals(state + d) - self.residuals(state - d)) / 2e-6
            for d in 1e-6 * np.eye(len(state))
        ]
        return Point(self.residuals(state), np.stack(columns, axis=-1))

    def moved(self, state: Floats, step: Floats) -> Floats:
        return state + step


START = np.array([-1.2, 1.0])
UNDAMPED = Damping(first=0.0, easier=1.0)
USUAL = Criteria(most_steps=200, settled=1e-9, damping=Damping(most=1e10))


def _found(criteria: Criteria, curve: Curve | None = None) -> Solution[Floats, Point]:
    return least_squares(curve or Curve(), START, criteria)


def test_a_curved_valley_is_followed_to_its_lowest_point() -> None:
    found = _found(USUAL)
    assert np.allclose(found.state, 1.0, atol=1e-6)
    assert found.converged
    assert found.solves > found.steps  # some steps were rejected on the way
    assert found.cost == found.here.cost < 1e-12


def test_no_step_is_longer_than_allowed() -> None:
    found = _found(replace(USUAL, most_steps=3, longest_step=0.01))
    assert np.abs(found.state - START).max() <= 0.03 + 1e-12
    assert found.end == "steps"
    assert not found.converged


def test_it_stops_where_no_step_gains_and_says_so() -> None:
    found = _found(replace(USUAL, settled=0.0, gain=0.5))
    assert found.end == "no gain"
    assert found.converged


def test_short_steps_are_not_taken() -> None:
    found = _found(replace(USUAL, settled=0.0, negligible=1e3))
    assert np.array_equal(found.state, START)
    assert found.end == "settled"


def test_the_solves_are_counted_with_those_rejected() -> None:
    found = _found(replace(USUAL, most_solves=4))
    assert found.solves == 4
    assert found.end == "steps"


def test_a_step_that_makes_things_worse_is_not_taken() -> None:
    """Only the start can be."""
    curve = Curve(lambda x: x if np.array_equal(x, START) else np.full(2, 1e3) * x)
    few = replace(USUAL, damping=Damping(), most_tries=5)
    for criteria in (USUAL, few, Criteria(), Criteria(damping=UNDAMPED)):
        found = _found(criteria, curve)
        assert np.array_equal(found.state, START)
        assert found.end == "no gain"


def test_a_start_without_a_cost_is_no_start() -> None:
    class Infinite(Point):
        @property
        def cost(self) -> float:
            return np.inf

    class Nowhere(Curve):
        def at(self, state: Floats, count: int) -> Point:
            point = super().at(state, count)
            return Infinite(point.r, point.J)

    found = least_squares(Nowhere(), START, USUAL)
    assert found.end == "unsolvable"
    assert found.solved is None


def test_without_rejection_every_step_is_taken_and_no_cost_is_asked() -> None:
    class Blind(Point):
        @property
        def cost(self) -> float:
            raise AssertionError

    class Steps(Curve):
        def at(self, state: Floats, count: int) -> Point:
            point = super().at(state, count)
            return Blind(point.r, point.J)

    how = Criteria(most_steps=2, rejects=False, damping=UNDAMPED)
    found = least_squares(Steps(), START, how)  # Gauss–Newton leaps into this valley's end
    assert np.allclose(found.state, 1.0, atol=1e-5)
    assert found.steps == found.solves == 2


@pytest.mark.parametrize("rejects", [True, False])
def test_equations_without_a_solution_end_it(rejects: bool) -> None:
    class Unsolvable(Point):
        def step(self, damping: float) -> Floats | None:
            return None

    class Nowhere(Curve):
        def at(self, state: Floats, count: int) -> Point:
            point = super().at(state, count)
            return Unsolvable(point.r, point.J)

    found = least_squares(Nowhere(), START, replace(USUAL, rejects=rejects))
    assert found.end == "unsolvable"
    assert not found.converged
    assert np.array_equal(found.state, START)


def test_it_can_be_cancelled_between_two_solves() -> None:
    asked = iter([False, False, True])
    found = least_squares(Curve(), START, USUAL, lambda: next(asked))
    assert found.end == "cancelled"
    assert found.solves == 2
