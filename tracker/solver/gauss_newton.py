"""Gauss–Newton on squares that are weighed anew at every state: the one loop, every step taken.

Weights that follow the residuals, whose kernel may narrow from step to step, make a cost that is
another at every state. So no two costs compare, and no step is rejected.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Generic

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.least_squares import (
    Criteria,
    Damping,
    Problem,
    Solution,
    State,
    least_squares,
)

GAUSS_NEWTON = Criteria(rejects=False, damping=Damping(first=0.0, easier=1.0))
"""What every use has in common; how many steps, and when it is settled, is for each to say."""


@dataclass(frozen=True, eq=False)
class Weighed:
    """A state whose equations are made when its step is asked for."""

    solve: Callable[[], Array | None]

    @property
    def cost(self) -> float:
        return np.nan

    def step(self, damping: float) -> Array | None:
        try:
            return self.solve()
        except np.linalg.LinAlgError:
            return None


@dataclass(frozen=True, eq=False)
class _Reweighted(Problem[State, Weighed], Generic[State]):
    """What `gauss_newton` is told."""

    step: Callable[[State, int], Array | None]
    step_on: Callable[[State, Array], State]

    def at(self, state: State, count: int) -> Weighed:
        return Weighed(partial(self.step, state, count))

    def moved(self, state: State, step: Array) -> State:
        return self.step_on(state, step)


def gauss_newton(
    step: Callable[[State, int], Array | None],
    moved: Callable[[State, Array], State],
    start: State,
    criteria: Criteria,
) -> Solution[State, Weighed]:
    """Step from a start until the criteria, made of `GAUSS_NEWTON`, say stop.

    Args:
        step: at a state, after so many others; None, or numpy's LinAlgError, where the equations
            have no solution, which ends it as "unsolvable".
        moved: a state after a step.
        start: the first state.
        criteria: how many steps, how long, and when they are settled.
    """
    return least_squares(_Reweighted(step, moved), start, criteria)
