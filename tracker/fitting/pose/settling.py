"""A pose settled between a hand's, which is good to a few degrees, and what a picture shows.

Gauss–Newton from coarse to fine on the differences to known textures and on the outline, held to
the hand's pose. In the end only those directions of motion count that the picture tells better than
the hand does: along all others the pose is exactly the hand's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tracker.body.joint_limits import Limits
from tracker.body.pose import Pose, moved
from tracker.fitting.pose.likeness import Likeness
from tracker.fitting.pose.outline import Colours, Outline, edge_equations
from tracker.geometry.rotations import Array
from tracker.solver.least_squares import (
    UNDAMPED,
    Criteria,
    Problem,
    damped_step,
    least_squares,
)
from tracker.solver.posed import Posed
from tracker.solver.terms import Equations, JointLimits, PosePrior
from tracker.tracking.scene import Scene
from tracker.video.pyramid import LEVELS

HAND_TURN_RAD, HAND_SHIFT_M = np.radians(3.0), 0.015
"""How well a person poses: standard deviations of a joint angle and of the hips."""
LIMIT_SIGMA_RAD = np.radians(2.0)
SOLVES = (10, 8, 8)
"""Solves at most at each level of the pyramid, finest first."""
ROUGH = 4
"""Of the finest ones, the first few still allow the pose to be far off."""
REACH_M = (0.03, 0.055, 0.1)
"""How far from an edge the picture's own is sought, at each level."""
LOOK_AGAIN, LEARN_AGAIN = 3, 3
"""Solves after which visibility and colours are found anew."""
CRITERIA = Criteria(longest_step=0.1, settled=5e-4, rejects=False, damping=UNDAMPED)
TELLS = 1.0
"""Information of the picture, as a share of the hand's, above which a direction is decided."""


@dataclass(frozen=True, eq=False)
class Settled:
    """A pose, and the information (D, D) that the picture holds about it."""

    pose: Pose
    information: Array


@dataclass(frozen=True, eq=False)
class Hand:
    """A pose as a person set it, and how surely: precision (D,) is 1/σ² of each motion."""

    scene: Scene
    pose: Pose
    limits: Limits

    @cached_property
    def precision(self) -> Array:
        return self.scene.precision(HAND_TURN_RAD, HAND_SHIFT_M)

    @cached_property
    def prior(self) -> PosePrior:
        """The pose as the hand set it."""
        return PosePrior.of(self.pose, self.precision, backward=False)

    def away(self, pose: Pose) -> Array:
        """(D,) the tracked part of the motion from the hand's pose to another."""
        return self.prior.away(Posed.of(self.scene.skeleton, pose))

    @cached_property
    def joint_limits(self) -> JointLimits:
        """No angle further past its limits than the hand set it."""
        set_so, _ = self.limits.excess(self.pose.Rs_parent_part)
        return JointLimits(self.limits, LIMIT_SIGMA_RAD, set_so)


class _Outlined:
    """The outline's say on a pose, its colours learnt anew every few solves."""

    def __init__(self, outline: Outline) -> None:
        self._outline = outline
        self._colours: Colours | None = None

    def equations(self, pose: Pose, level: int, solve: int) -> Equations:
        shown = self._outline.draw(pose)
        if self._colours is None or solve % LEARN_AGAIN == 0:
            self._colours = self._outline.colours(shown)
        edges = self._outline.edges(shown, self._colours, REACH_M[level])
        return Equations(*edge_equations(self._outline, pose, edges))


@dataclass(frozen=True, eq=False)
class _Picture(Problem[Pose, "_Look"]):
    """What a picture and the hand say of a pose, at one level of the pyramid."""

    hand: Hand
    likeness: Likeness | None
    outlined: _Outlined | None
    level: int

    def at(self, state: Pose, count: int) -> _Look:
        return _Look(self, state, count)

    def moved(self, state: Pose, step: Array) -> Pose:
        return moved(self.hand.scene.skeleton, state, step)

    def equations(self, pose: Pose, solve: int, fine: bool) -> Equations:
        """Of textures and outline, without the hand."""
        told = Equations.none(self.hand.scene.skeleton.dof_count)
        if self.likeness is not None:
            if solve % LOOK_AGAIN == 0:
                self.likeness.look(pose)
            told = Equations(*self.likeness.equations(pose, self.level, fine))
        if self.outlined is not None:
            told = told + self.outlined.equations(pose, self.level, solve)
        return told


@dataclass(frozen=True, eq=False)
class _Look:
    """A pose on the way, after some solves. Costs are not asked: colours, visibility and noise
    are learnt anew on the way, so that those of two poses do not compare."""

    picture: _Picture
    pose: Pose
    solve: int
    cost = np.nan

    @cached_property
    def told(self) -> Equations:
        return self.picture.equations(self.pose, self.solve, self._fine)

    @property
    def _fine(self) -> bool:
        return self.picture.level == 0 and self.solve >= ROUGH

    def step(self, damping: float) -> Array | None:
        return _step(self.picture.hand, self.pose, self.told, only_told=self._fine)


def settle(
    hand: Hand,
    start: Pose,
    likeness: Likeness | None,
    outline: Outline | None,
    cancelled: Callable[[], bool],
    coarsest: int = LEVELS - 1,
) -> Settled:
    """The pose nearest to what textures and outline show and to the hand's, from a start.

    coarsest: the level of the pyramid to begin at.
    """
    outlined = None if outline is None else _Outlined(outline)
    told = Equations.none(hand.scene.skeleton.dof_count)
    pose = start
    for level in range(coarsest, -1, -1):
        if likeness is not None:
            likeness.begin(level)
        criteria = replace(CRITERIA, most_steps=SOLVES[level])
        found = least_squares(_Picture(hand, likeness, outlined, level), pose, criteria, cancelled)
        if found.solved is None or found.end in ("cancelled", "unsolvable"):
            return Settled(hand.pose, np.zeros_like(told.A))
        pose, told = found.state, found.solved.told
    return Settled(pose, told.A)


def _step(hand: Hand, pose: Pose, told: Equations, only_told: bool) -> Array:
    """The next motion; with `only_told`, along the directions that the picture decides.

    In units of the hand's own uncertainty the directions are the eigenvectors of what the picture
    tells; along the others the motion leads straight back to the hand's pose.
    """
    posed = Posed.of(hand.scene.skeleton, pose)
    told = told + hand.joint_limits.equations(posed)
    if not only_told:
        whole = told + hand.prior.equations(posed)
        return damped_step(whole.A, whole.b, 0.0)
    sigma, away = hand.precision**-0.5, hand.prior.away(posed)
    values, V = np.linalg.eigh(told.A * sigma * sigma[:, None])
    y = V.T @ (away / sigma)
    g = V.T @ (told.b * sigma)
    along = np.where(values >= TELLS, -(g + y) / (values + 1.0), -y)
    return np.asarray(sigma * (V @ along))


def decided_share(hand: Hand, settled: Settled) -> Array:
    """(P,) share of each part's own motions that the picture decides; 0 where none is tracked."""
    skeleton = hand.scene.skeleton
    sigma = hand.precision**-0.5
    values, V = np.linalg.eigh(settled.information * sigma * sigma[:, None])
    share = np.where(values >= TELLS, values / (values + 1.0), 0.0)
    by_dof = (V**2 * share).sum(axis=1)
    total = np.bincount(skeleton.dof_part, weights=by_dof, minlength=skeleton.part_count)
    count = np.bincount(skeleton.dof_part, minlength=skeleton.part_count)
    return np.asarray(total / np.maximum(count, 1))
