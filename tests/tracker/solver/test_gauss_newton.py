"""Squares that are weighed anew with every step: every step is taken, and the end says why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.solver.gauss_newton import GAUSS_NEWTON, gauss_newton
from keypose.tracker.solver.least_squares import Criteria
from keypose.tracker.solver.robust import GemanMcClure

Floats = NDArray[np.float64]

X = np.linspace(-1, 1, 60)
TRUE = np.array([0.5, -0.3])
Y = np.exp(TRUE[0] * X) + TRUE[1] + np.where(np.arange(60) % 3, 0.0, 4.0)
"""A third of these are wrong by 4."""
WIDTHS = (20.0, 4.0, 1.0, 0.2, 0.2, 0.2, 0.2, 0.2)


def _step(state: Floats, count: int) -> Floats:
    """Of exp(a x) + b, the kernel narrower from step to step."""
    J = np.stack([X * np.exp(state[0] * X), np.ones_like(X)], axis=1)
    left = Y - np.exp(state[0] * X) - state[1]
    weight = GemanMcClure(WIDTHS[min(count, len(WIDTHS) - 1)]).weight(np.abs(left))
    return np.asarray(np.linalg.solve((J.T * weight) @ J, (J.T * weight) @ left))


def _moved(state: Floats, step: Floats) -> Floats:
    return state + step


FREE = replace(GAUSS_NEWTON, most_steps=40, settled=1e-10)


def test_a_kernel_that_narrows_finds_what_most_agree_on() -> None:
    found = gauss_newton(_step, _moved, np.zeros(2), replace(FREE, least_steps=len(WIDTHS)))
    assert found.end == "settled"
    np.testing.assert_allclose(found.state, TRUE, atol=5e-3)
    plain = gauss_newton(lambda s, count: _step(s, 0), _moved, np.zeros(2), FREE)
    assert abs(plain.state[1] - TRUE[1]) > 1  # what all agree on least badly


@pytest.mark.parametrize(
    ("criteria", "steps", "end"),
    [
        (replace(FREE, most_steps=0), 0, "steps"),
        (replace(FREE, most_steps=3), 3, "steps"),
        (replace(FREE, settled=1e9), 1, "settled"),
        (replace(FREE, settled=1e9, least_steps=4), 4, "settled"),
    ],
    ids=["none allowed", "three allowed", "settled at once", "not settled before the fourth"],
)
def test_it_takes_as_many_steps_as_it_is_told(criteria: Criteria, steps: int, end: str) -> None:
    found = gauss_newton(_step, _moved, np.zeros(2), criteria)
    assert (found.steps, found.end) == (steps, end)


def test_no_step_is_longer_than_allowed() -> None:
    short = replace(FREE, most_steps=1, longest_step=0.01)
    found = gauss_newton(_step, _moved, np.zeros(2), short)
    assert np.abs(found.state).max() == pytest.approx(0.01)


def _singular(state: Floats, count: int) -> Floats:
    return np.asarray(np.linalg.solve(np.zeros((2, 2)), np.ones(2)))


@pytest.mark.parametrize(
    "step",
    [_singular, lambda s, count: None, lambda s, count: np.full(2, np.nan)],
    ids=["singular", "none", "not a number"],
)
def test_equations_without_a_solution_end_it_where_it_is(step: object) -> None:
    found = gauss_newton(step, _moved, np.ones(2), FREE)  # type: ignore[arg-type]
    assert found.end == "unsolvable"
    assert (found.state == 1).all()
