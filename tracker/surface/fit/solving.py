"""The pose at which two surfaces lie on each other: Levenberg–Marquardt.  SURFACE §4.2

Points are paired anew at every pose that is tried, and a pose that does not lower the energy is
rejected. What the surface does not show, such as the turn of a round limb about its own length,
stays as it was: a weak prior at the pose the step started from. How far the observed surface
stands out from the body's is solved with the pose.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from keypose.tracker.body.pose import Pose, moved
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.least_squares import (
    Criteria,
    Damping,
    Problem,
    damped_step,
    least_squares,
)
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.terms import total_equations
from keypose.tracker.surface.fit.model import PosedSurface, SurfaceModel
from keypose.tracker.surface.fit.options import Options
from keypose.tracker.surface.fit.paired import PairDistances
from keypose.tracker.surface.fit.pairing import Observed, Pairs, pairs_of
from keypose.tracker.surface.fit.rotation_observability import turns_seen

STIFFNESS = 3e-6
"""Of the weak pull, per radian² and per (surface size)²: a step turns a part by a tenth of a radian
or so, beside a few hundred points that agree to half a hundredth of the size."""
CRITERIA = Criteria(longest_step=0.3, settled=2e-5, damping=Damping(easier=5.0, most=0.99e6))
"""Radians that a part turns in one solve; and, of the surface's size, what a solve moves points on
the average at the end."""


@dataclass(frozen=True, eq=False)
class Fit:
    """The outcome of one step.

    energy:      SURFACE (4) at the best offset, with the pull and the limits, metres².
    information: (D, D) of the free degrees of freedom with the offset marginalised, without the
                 pull; metres² per unit².
    """

    pose: Pose
    energy: float
    information: Array
    pairs: Pairs
    posed: PosedSurface


@dataclass(frozen=True, eq=False)
class _Iterate:
    """A pose that was tried. cost is half the energy, slope (D,) its gradient, both with the pull
    and the limits; information (D, D) is without the pull, stiffness (D, D) is that."""

    pose: Pose
    cost: float
    information: Array
    slope: Array
    stiffness: Array
    pairs: Pairs
    posed: PosedSurface

    def step(self, damping: float) -> Array | None:
        normal = self.information + self.stiffness
        return damped_step(normal, self.slope, damping, 1e-9 * np.diag(normal).max())


def fit_pose(model: SurfaceModel, observed: Observed, start: Pose, options: Options) -> Fit:
    """The pose near `start` whose surface lies on the observed one.  SURFACE (4)"""
    skeleton = model.skeleton
    stiffness = options.stiff * STIFFNESS * model.size_m**2 * np.diag(skeleton.dof_turns == 1)
    if options.stiff > 0:
        stiffness = stiffness + _unseen_stiffness(model)
    criteria = replace(CRITERIA, most_solves=options.solves)
    start_state = start, np.zeros(skeleton.dof_count)
    last = least_squares(_Step(model, observed, stiffness, options), start_state, criteria).here
    return Fit(last.pose, 2 * last.cost, last.information, last.pairs, last.posed)


@dataclass(frozen=True, eq=False)
class _Step(Problem[tuple[Pose, Array], _Iterate]):
    """A step's problem. Its states: a pose, and the sum (D,) of all motions that led to it."""

    model: SurfaceModel
    observed: Observed
    stiffness: Array
    options: Options

    def at(self, state: tuple[Pose, Array], count: int) -> _Iterate:
        return _evaluate(self.model, self.observed, *state, self.stiffness, self.options)

    def moved(self, state: tuple[Pose, Array], step: Array) -> tuple[Pose, Array]:
        return moved(self.model.skeleton, state[0], step), state[1] + step

    def travel(self, here: _Iterate, there: _Iterate, step: Array) -> float:
        """What points move on the average, over the surface's size."""
        away = np.linalg.norm(there.posed.p - here.posed.p, axis=1).mean()
        return float(away / self.model.size_m)


def _unseen_stiffness(model: SurfaceModel) -> Array:
    """(D, D) the pull on turns that the surface cannot show."""
    skeleton = model.skeleton
    turns = turns_seen(model, np.ones(len(model.own)))
    stiffness = np.zeros((skeleton.dof_count, skeleton.dof_count))
    for part, block in enumerate(turns.stiffness()):
        its = np.flatnonzero((skeleton.dof_part == part) & (skeleton.dof_turns == 1))
        stiffness[np.ix_(its, its)] = block
    return stiffness


def _evaluate(
    model: SurfaceModel,
    observed: Observed,
    pose: Pose,
    away: Array,
    stiffness: Array,
    options: Options,
) -> _Iterate:
    """Pair at a pose, and set up the normal equations there."""
    at = Posed.of(model.skeleton, pose)
    posed = model.posed(at.Ts_camera_part)
    pairs = pairs_of(model, posed, observed, options)
    offset = options.offset and options.plane == 1.0
    apart = PairDistances(model, pairs, at, posed, float(options.plane), offset)
    equations = total_equations([apart, model.limit_term], at)
    cost = equations.cost + 0.5 * float(away @ stiffness @ away)
    slope = equations.b + stiffness @ away
    return _Iterate(pose, cost, equations.A, slope, stiffness, pairs, posed)
