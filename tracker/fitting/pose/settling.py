"""A pose settled between a hand's, which is good to a few degrees, and what a picture shows.

Gauss–Newton from coarse to fine on the differences to known textures and on the outline, held to
the hand's pose. In the end only those directions of motion count that the picture tells better than
the hand does: along all others the pose is exactly the hand's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tracker.body.joint_limits import Limits
from tracker.body.pose import Pose, moved
from tracker.body.skeleton import Skeleton
from tracker.fitting.pose.likeness import Likeness
from tracker.fitting.pose.outline import Colours, Outline, edge_equations
from tracker.geometry.rotations import Array, log_rotation, transpose
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
LONGEST_STEP, AT_REST = 0.1, 5e-4
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

    @property
    def precision(self) -> Array:
        return self.scene.precision(HAND_TURN_RAD, HAND_SHIFT_M)

    def away(self, pose: Pose) -> Array:
        """(D,) the motion from the hand's pose to another."""
        return motion_between(self.scene.skeleton, self.pose, pose)

    def limit_equations(self, pose: Pose) -> tuple[Array, Array]:
        """A (D, D) and b (D,) of the angles further past their limits than the hand set them."""
        skeleton = self.scene.skeleton
        outside, slopes = self.limits.excess(pose.Rs_parent_part)
        set_so, _ = self.limits.excess(self.pose.Rs_parent_part)
        outside -= np.clip(outside, np.minimum(set_so, 0.0), np.maximum(set_so, 0.0))
        turns = np.flatnonzero(skeleton.dof_turns == 1)
        J = np.zeros((skeleton.part_count, 3, skeleton.dof_count))
        parts, axes = skeleton.dof_part[turns], skeleton.dof_axis[turns]
        J[parts, :, turns] = slopes[parts, :, axes]
        over = outside != 0
        J, r = J[over] / LIMIT_SIGMA_RAD, outside[over] / LIMIT_SIGMA_RAD
        return J.T @ J, J.T @ r


def motion_between(skeleton: Skeleton, start: Pose, end: Pose) -> Array:
    """(D,) the tracked part of the motion from one pose to another, in the parts' own frames."""
    turn = log_rotation(transpose(start.Rs_parent_part) @ end.Rs_parent_part)
    shift = start.Rs_parent_part[0].T @ (end.p_camera_root - start.p_camera_root)
    part, axis = skeleton.dof_part, skeleton.dof_axis
    return np.where(skeleton.dof_turns == 1, turn[part, axis], shift[axis])


class _Outlined:
    """The outline's say on a pose, its colours learnt anew every few solves."""

    def __init__(self, outline: Outline) -> None:
        self._outline = outline
        self._colours: Colours | None = None

    def equations(self, pose: Pose, level: int, solve: int) -> tuple[Array, Array]:
        """A (D, D) and b (D,)."""
        shown = self._outline.drawn(pose)
        if self._colours is None or solve % LEARN_AGAIN == 0:
            self._colours = self._outline.colours(shown)
        edges = self._outline.edges(shown, self._colours, REACH_M[level])
        return edge_equations(self._outline, pose, edges)


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
    pose, dofs = start, hand.scene.skeleton.dof_count
    told = np.zeros((dofs, dofs))
    for level in range(coarsest, -1, -1):
        if likeness is not None:
            likeness.begin(level)
        for solve in range(SOLVES[level]):
            if cancelled():
                return Settled(hand.pose, np.zeros((dofs, dofs)))
            fine = level == 0 and solve >= ROUGH
            told, b = np.zeros((dofs, dofs)), np.zeros(dofs)
            if likeness is not None:
                if solve % LOOK_AGAIN == 0:
                    likeness.look(pose)
                told, b = likeness.equations(pose, level, fine)
            if outlined is not None:
                more, gradient = outlined.equations(pose, level, solve)
                told, b = told + more, b + gradient
            step = _step(hand, pose, told, b, only_told=fine)
            largest = float(np.abs(step).max(initial=0.0))
            if not np.isfinite(largest):
                return Settled(hand.pose, np.zeros((dofs, dofs)))
            pose = moved(
                hand.scene.skeleton, pose, step * min(1.0, LONGEST_STEP / max(largest, 1e-12))
            )
            if largest < AT_REST:
                break
    return Settled(pose, told)


def _step(hand: Hand, pose: Pose, told: Array, b: Array, only_told: bool) -> Array:
    """The next motion; with `only_told`, along the directions that the picture decides.

    In units of the hand's own uncertainty the directions are the eigenvectors of what the picture
    tells; along the others the motion leads straight back to the hand's pose.
    """
    sigma, away = hand.precision**-0.5, hand.away(pose)
    limits, past = hand.limit_equations(pose)
    if not only_told:
        A = told + limits + np.diag(hand.precision)
        return np.asarray(-np.linalg.solve(A, b + past + hand.precision * away))
    values, V = np.linalg.eigh((told + limits) * sigma * sigma[:, None])
    y = V.T @ (away / sigma)
    g = V.T @ ((b + past) * sigma)
    along = np.where(values >= TELLS, -(g + y) / (values + 1.0), -y)
    return np.asarray(sigma * (V @ along))


def decided(hand: Hand, settled: Settled) -> Array:
    """(P,) share of each part's own motions that the picture decides; 0 where none is tracked."""
    skeleton = hand.scene.skeleton
    sigma = hand.precision**-0.5
    values, V = np.linalg.eigh(settled.information * sigma * sigma[:, None])
    share = np.where(values >= TELLS, values / (values + 1.0), 0.0)
    by_dof = (V**2 * share).sum(axis=1)
    total = np.bincount(skeleton.dof_part, weights=by_dof, minlength=skeleton.part_count)
    count = np.bincount(skeleton.dof_part, minlength=skeleton.part_count)
    return np.asarray(total / np.maximum(count, 1))
