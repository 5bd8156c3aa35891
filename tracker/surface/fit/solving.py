"""Solve for the pose at which paired surfaces lie on each other, and which turns they show.

A hull is thicker than what it holds; by how much depends on where the cameras stand and on what
hides what. So is that of t_0, whose surface moves with the body, but by another amount. All round a
limb such a difference pushes nothing, but where one side of it is in contact or unreliable
the rest pushes alone, and a tapering limb slides. So the body's surface may stand out along its
normals n by nᵀ Q n, with one symmetric Q for all of a step: by as much on opposite sides, since
what differs there is a motion.

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
from keypose.tracker.kernels.surface import pull
from keypose.tracker.solver.least_squares import (
    Criteria,
    Damping,
    Problem,
    damped_step,
    least_squares,
)
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.terms import Equations, total_equations
from keypose.tracker.surface.fit.model import PosedSurface, SurfaceModel
from keypose.tracker.surface.fit.options import Options
from keypose.tracker.surface.fit.pairing import Pairs, TargetSurface, pairs_of

WANDER = 0.15
"""Radians by which normals of an observed surface are off, about."""
UNSEEN = 0.5
"""Certainty below which a turn is not observed."""


@dataclass(frozen=True, eq=False)
class Turns:
    """The turns of every part about three axes of its own, those shown least first.

    certainty: (P, 3) 0 to 1.
    axes:      (P, 3, 3) column k times a turn of the part, squared, is the mean square by which the
               k-th of them moves the body's surface, metres².
    """

    certainty: Array
    axes: Array

    def stiffness(self) -> Array:
        """(P, 3, 3) a pull on every part that holds the turns which are not seen."""
        unseen = (self.certainty < UNSEEN).astype(np.float64)
        return np.asarray(np.einsum("pik,pk,pjk->pij", self.axes, unseen, self.axes))


def turns_seen(model: SurfaceModel, weights: Array) -> Turns:
    """What the surface shows of every turn where its points count by weights (V,), 0 to 1.

    What moves along the surface is not seen to move. So a turn is as certain as the motion across
    the surface is large beside all motion, and beside what normals wander.
    """
    count, total = model.skeleton.part_count, len(weights)
    certainty, axes = np.zeros((count, 3)), np.zeros((count, 3, 3))
    least = 1e-9 * model.size_m**2 * np.eye(3)
    for part in range(count):
        own = model.own == part
        p, n = model.p_part[own, 0], model.n_part[own, 0]
        second = p.T @ p
        levers = np.trace(second) * np.eye(3) - second
        turned = np.cross(p, n)
        across = turned.T @ (weights[own, None] * turned)
        whole = np.linalg.cholesky(levers / total + least)
        share = np.linalg.solve(whole, np.linalg.solve(whole, across / total).T)
        ratio, directions = np.linalg.eigh((share + share.T) / 2)
        ratio = np.maximum(ratio, 0.0)
        certainty[part] = ratio / (ratio + WANDER**2)
        axes[part] = whole @ directions
    return Turns(certainty, axes)


OFFSET_TERMS = 6
"""Numbers that make up Q, first in the rows that pairs are summed to."""
EVENNESS = 0.07
"""Prior of no offset: so many pairs without one, as a share of all."""


@dataclass(frozen=True, eq=False)
class NormalEquations:
    """energy: metres².  information (D, D) and slope (D,): of half of it."""

    energy: float
    information: Array
    slope: Array


def normal_equations(A: Array, b: Array, J: Array, energy: float, offset: bool) -> NormalEquations:
    """Make the equations of the free degrees of freedom from the sums of `pull`.

    A (G, 18, 18), b (G, 18), energy: those sums, of weights that sum to 2.  J: (G, 12, D) of the
    groups' twists.  offset: Q is marginalised, the energy that at the best Q; otherwise Q is 0.
    """
    moving = slice(OFFSET_TERMS, None)
    information = np.einsum("gid,gij,gje->de", J, A[:, moving, moving], J, optimize=True)
    slope = np.einsum("gid,gi->d", J, b[:, moving])
    if not offset:
        return NormalEquations(energy, information, slope)
    own = A[:, :OFFSET_TERMS, :OFFSET_TERMS].sum(axis=0) + 2 * EVENNESS * np.eye(OFFSET_TERMS)
    push = b[:, :OFFSET_TERMS].sum(axis=0)
    shared = np.einsum("gki,gid->kd", A[:, :OFFSET_TERMS, moving], J)
    solved = np.linalg.solve(own, np.column_stack([shared, push]))
    return NormalEquations(
        energy - float(push @ solved[:, -1]),
        information - shared.T @ solved[:, :-1],
        slope - shared.T @ solved[:, -1],
    )


@dataclass(frozen=True, eq=False)
class PairDistances:
    """Points of a model's surface on the points that they were paired with, metres.

    paired_at, surface: the pose at which they were paired, and the model's surface there; along its
        normals the surface may stand out.
    plane: 1 along the observed normals, 0 in all directions.  offset: whether it may stand out.
    """

    model: SurfaceModel
    pairs: Pairs
    paired_at: Posed
    surface: PosedSurface
    plane: float
    offset: bool

    def cost(self, posed: Posed) -> float:
        """Half of the energy, at the best offset."""
        return self.equations(posed).cost

    def equations(self, posed: Posed) -> Equations:
        """Make the equations with the offset marginalised."""
        model, pairs, size = self.model, self.pairs, OFFSET_TERMS + 12
        A, b = np.empty((len(model.pairs), size, size)), np.empty((len(model.pairs), size))
        at = self.surface if posed is self.paired_at else model.posed(posed.Ts_camera_part)
        energy = pull(
            at.p_each,
            model.shares,
            model.groups,
            pairs.model,
            pairs.target,
            pairs.normals,
            pairs.weights,
            self.surface.normals,
            self.plane,
            A,
            b,
        )
        marginal = normal_equations(A, b, self._twists(posed), energy, self.offset)
        return Equations(marginal.information, marginal.slope, 0.5 * marginal.energy)

    def _twists(self, posed: Posed) -> Array:
        """(G, 12, D): those of both parts of every group, for a change of each dof."""
        skeleton, groups = posed.skeleton, self.model.pairs
        carried = skeleton.below[groups][:, :, skeleton.dof_part]  # (G, 2, D)
        of_parts = carried[:, :, None, :] * posed.twists.T[None, None]
        return np.asarray(of_parts.reshape(len(groups), 12, skeleton.dof_count))


STIFFNESS = 3e-6
"""Of the weak pull, per radian² and per (surface size)²: a step turns a part by a tenth of a radian
or so, beside a few hundred points that agree to half a hundredth of the size."""
CRITERIA = Criteria(longest_step=0.3, settled=2e-5, damping=Damping(easier=5.0, most=0.99e6))
"""Radians that a part turns in one solve; and, of the surface's size, what a solve moves points on
the average at the end."""


@dataclass(frozen=True, eq=False)
class SurfaceRegistration:
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


def fit_pose(
    model: SurfaceModel, observed: TargetSurface, start: Pose, options: Options
) -> SurfaceRegistration:
    """The pose near `start` whose surface lies on the observed one.  SURFACE (4)"""
    skeleton = model.skeleton
    stiffness = options.stiff * STIFFNESS * model.size_m**2 * np.diag(skeleton.dof_turns == 1)
    if options.stiff > 0:
        stiffness = stiffness + _unseen_stiffness(model)
    criteria = replace(CRITERIA, most_solves=options.solves)
    start_state = start, np.zeros(skeleton.dof_count)
    last = least_squares(_Step(model, observed, stiffness, options), start_state, criteria).here
    return SurfaceRegistration(last.pose, 2 * last.cost, last.information, last.pairs, last.posed)


@dataclass(frozen=True, eq=False)
class _Step(Problem[tuple[Pose, Array], _Iterate]):
    """A step's problem. Its states: a pose, and the sum (D,) of all motions that led to it."""

    model: SurfaceModel
    observed: TargetSurface
    stiffness: Array
    options: Options

    def at(self, state: tuple[Pose, Array], count: int) -> _Iterate:
        return _linearized(self.model, self.observed, *state, self.stiffness, self.options)

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


def _linearized(
    model: SurfaceModel,
    observed: TargetSurface,
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
