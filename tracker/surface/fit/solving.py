"""The pose at which two surfaces lie on each other: Levenberg–Marquardt.  SURFACE §4.2

Points are paired anew at every pose that is tried, and a pose that does not lower the energy is
rejected. What the surface does not show, such as the turn of a round limb about its own length,
stays as it was: a weak pull to the pose the step began from holds it. How far the observed surface
stands out from the body's is found beside the pose.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tracker.body.pose import Pose, moved, pose_transforms, twists
from tracker.geometry.rotations import Array
from tracker.kernels.surface import pull
from tracker.surface.fit.bounding import bounds_at
from tracker.surface.fit.certainty import turns_seen
from tracker.surface.fit.model import PosedSurface, SurfaceModel
from tracker.surface.fit.options import Options
from tracker.surface.fit.pairing import Observed, Pairs, pairs_of
from tracker.surface.fit.swelling import SWELLINGS, normal_equations

STIFFNESS = 3e-6
"""Of the weak pull, per radian² and per (surface size)²: a step turns a part by a tenth of a radian
or so, beside a few hundred points that agree to half a hundredth of the size."""
LARGEST_TURN = 0.3
"""Radians that a part turns in one solve."""
SETTLED_SHARE = 2e-5
"""Of the surface's size: what a solve moves points, on the average, once all is gained."""
FIRST_DAMPING, HARDER, EASIER, HARDEST = 1e-3, 10.0, 0.2, 1e6


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
    """A pose that was tried."""

    pose: Pose
    away: Array
    energy: float
    information: Array
    slope: Array
    pairs: Pairs
    posed: PosedSurface


def fit_pose(model: SurfaceModel, observed: Observed, start: Pose, options: Options) -> Fit:
    """The pose near `start` whose surface lies on the observed one.  SURFACE (4)"""
    skeleton = model.skeleton
    stiffness = options.stiff * STIFFNESS * model.size_m**2 * np.diag(skeleton.dof_turns == 1)
    if options.stiff > 0:
        stiffness = stiffness + _holding(model)
    look = _look(model, observed, start, np.zeros(skeleton.dof_count), stiffness, options)
    damping, settled, tried = FIRST_DAMPING, False, 0
    while tried < options.solves and not settled and damping < HARDEST:
        tried += 1
        motion = _motion(look, stiffness, damping)
        away = look.away + motion
        pose = moved(skeleton, look.pose, motion)
        other = _look(model, observed, pose, away, stiffness, options)
        if other.energy < look.energy:
            step = np.linalg.norm(other.posed.p - look.posed.p, axis=1).mean()
            settled = bool(step < SETTLED_SHARE * model.size_m)
            look, damping = other, damping * EASIER
        else:
            damping *= HARDER
    return Fit(look.pose, look.energy, look.information, look.pairs, look.posed)


def _motion(look: _Look, stiffness: Array, damping: float) -> Array:
    """The step of one damped solve."""
    normal = look.information + stiffness
    scale = np.diag(normal) + 1e-9 * np.diag(normal).max()
    motion = -np.linalg.solve(normal + np.diag(damping * scale), look.slope)
    return np.asarray(motion * min(1.0, LARGEST_TURN / max(np.abs(motion).max(), 1e-12)))


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
    bounds = bounds_at(model, pose)
    energy = seen.energy + float(away @ stiffness @ away) + bounds.energy
    slope = seen.slope + stiffness @ away + bounds.slope
    return _Look(pose, away, energy, seen.information + bounds.information, slope, pairs, posed)


def _jacobians(model: SurfaceModel, Ts_camera_part: Array) -> Array:
    """(G, 12, D): twists of both parts of every group, for a change of each degree of freedom."""
    skeleton = model.skeleton
    all_twists = twists(skeleton, Ts_camera_part)
    carried = skeleton.below[model.pairs][:, :, skeleton.dof_part]  # (G, 2, D)
    of_parts = carried[:, :, None, :] * all_twists.T[None, None]
    return np.asarray(of_parts.reshape(len(model.pairs), 12, skeleton.dof_count))
