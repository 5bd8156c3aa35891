"""The pose at which two surfaces lie on each other: Levenberg–Marquardt.  SURFACE §4.2

Points are paired anew at every pose that is tried, and a pose that does not lower the energy is
rejected. What the surface does not show, such as the turn of a round limb about its own length,
stays as it was: a weak pull to the pose the step began from holds it. How far the observed surface
stands out from the body's is found beside the pose.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tracker.body.pose import Pose, moved, pose_transforms, twists
from tracker.geometry.rotations import Array
from tracker.kernels.surface import pull
from tracker.solver.least_squares import (
    Criteria,
    Damping,
    Problem,
    damped_step,
    least_squares,
)
from tracker.solver.posed import Posed
from tracker.surface.fit.model import PosedSurface, SurfaceModel
from tracker.surface.fit.normal_offset import SWELLINGS, normal_equations
from tracker.surface.fit.options import Options
from tracker.surface.fit.pairing import Observed, Pairs, pairs_of
from tracker.surface.fit.rotation_observability import turns_seen

STIFFNESS = 3e-6
"""Of the weak pull, per radian² and per (surface size)²: a step turns a part by a tenth of a radian
or so, beside a few hundred points that agree to half a hundredth of the size."""
CRITERIA = Criteria(longest_step=0.3, settled=2e-5, damping=Damping(easier=5.0, most=0.99e6))
"""Radians that a part turns in one solve; and, of the surface's size, what a solve moves points on
the average once all is gained."""


@dataclass(frozen=True, eq=False)
class Fit:
    """The outcome of one step.

    energy:      SURFACE (4) at the best swelling, with the pull and the limits, metres².
    information: (D, D) of the free degrees of freedom beside any swelling, without the pull;
                 metres² per unit².
    """

    pose: Pose
    energy: float
    information: Array
    pairs: Pairs
    posed: PosedSurface


@dataclass(frozen=True, eq=False)
class _Look:
    """A pose that was tried. slope (D,) is half the energy's, with the pull and the limits;
    information (D, D) is without the pull, stiffness (D, D) is that."""

    pose: Pose
    energy: float
    information: Array
    slope: Array
    stiffness: Array
    pairs: Pairs
    posed: PosedSurface

    @property
    def cost(self) -> float:
        return self.energy

    def step(self, damping: float) -> Array | None:
        normal = self.information + self.stiffness
        return damped_step(normal, self.slope, damping, 1e-9 * np.diag(normal).max())


def fit_pose(model: SurfaceModel, observed: Observed, start: Pose, options: Options) -> Fit:
    """The pose near `start` whose surface lies on the observed one.  SURFACE (4)"""
    skeleton = model.skeleton
    stiffness = options.stiff * STIFFNESS * model.size_m**2 * np.diag(skeleton.dof_turns == 1)
    if options.stiff > 0:
        stiffness = stiffness + _holding(model)
    criteria = replace(CRITERIA, most_solves=options.solves)
    begun = start, np.zeros(skeleton.dof_count)
    look = least_squares(_Step(model, observed, stiffness, options), begun, criteria).here
    return Fit(look.pose, look.energy, look.information, look.pairs, look.posed)


@dataclass(frozen=True, eq=False)
class _Step(Problem[tuple[Pose, Array], _Look]):
    """A step's problem. Its states: a pose, and the sum (D,) of all motions that led to it."""

    model: SurfaceModel
    observed: Observed
    stiffness: Array
    options: Options

    def at(self, state: tuple[Pose, Array], count: int) -> _Look:
        return _look(self.model, self.observed, *state, self.stiffness, self.options)

    def moved(self, state: tuple[Pose, Array], step: Array) -> tuple[Pose, Array]:
        return moved(self.model.skeleton, state[0], step), state[1] + step

    def travel(self, here: _Look, there: _Look, step: Array) -> float:
        """What points move on the average, over the surface's size."""
        away = np.linalg.norm(there.posed.p - here.posed.p, axis=1).mean()
        return float(away / self.model.size_m)


def _holding(model: SurfaceModel) -> Array:
    """(D, D) the pull on turns that the surface cannot show."""
    skeleton = model.skeleton
    turns = turns_seen(model, np.ones(len(model.own)))
    stiffness = np.zeros((skeleton.dof_count, skeleton.dof_count))
    for part, block in enumerate(turns.holding()):
        its = np.flatnonzero((skeleton.dof_part == part) & (skeleton.dof_turns == 1))
        stiffness[np.ix_(its, its)] = block
    return stiffness


def _look(
    model: SurfaceModel,
    observed: Observed,
    pose: Pose,
    away: Array,
    stiffness: Array,
    options: Options,
) -> _Look:
    """Pair at a pose, and lay out the normal equations there."""
    Ts = pose_transforms(model.skeleton, pose)
    posed = model.posed(Ts)
    pairs = pairs_of(model, posed, observed, options)
    size = SWELLINGS + 12
    A, b = np.empty((len(model.pairs), size, size)), np.empty((len(model.pairs), size))
    energy = pull(
        posed.p_each, model.shares, model.groups, pairs.model, pairs.target, pairs.normals,
        pairs.weights, posed.normals, float(options.plane), A, b,
    )  # fmt: skip
    swell = options.swell and options.plane == 1.0
    seen = normal_equations(A, b, _jacobians(model, Ts), energy, swell)
    bounds = model.limit_term.equations(Posed.of(model.skeleton, pose))
    energy = seen.energy + float(away @ stiffness @ away) + 2 * bounds.cost
    slope = seen.slope + stiffness @ away + bounds.b
    information = seen.information + bounds.A
    return _Look(pose, energy, information, slope, stiffness, pairs, posed)


def _jacobians(model: SurfaceModel, Ts_camera_part: Array) -> Array:
    """(G, 12, D): twists of both parts of every group, for a change of each degree of freedom."""
    skeleton = model.skeleton
    all_twists = twists(skeleton, Ts_camera_part)
    carried = skeleton.below[model.pairs][:, :, skeleton.dof_part]  # (G, 2, D)
    of_parts = carried[:, :, None, :] * all_twists.T[None, None]
    return np.asarray(of_parts.reshape(len(model.pairs), 12, skeleton.dof_count))
