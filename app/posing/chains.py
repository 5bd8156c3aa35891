"""Bend limbs of many parts, and the spine, so that the end comes under the pointer."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from keypose.app.posing.gesture import GestureContext
from keypose.app.posing.moving import Aim
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.swinging import Swing, on_sphere
from keypose.app.posing.two_bones import Reached, within_reach
from keypose.app.posing.vectors import any_across, cross, length, smooth_step, unit
from keypose.tracker.geometry.rotations import Array, exp_rotation


@dataclass(frozen=True, eq=False)
class LimbChain:
    """Parts that follow one another; tip (3,) is their end in the last part's frame."""

    context: GestureContext
    parts: tuple[int, ...]
    tip: Array

    @property
    def centre(self) -> Array:
        """(3,) the first joint, in the camera frame."""
        return self.context.joint(self.parts[0])

    @property
    def end(self) -> Array:
        """(3,) the tip before the drag, in the camera frame."""
        return self.context.placed(self.parts[-1], self.tip)

    def lever_arms(self) -> Array:
        """(K, 3) from each part's joint to the next one's, at last to the tip, camera frame."""
        points = [self.context.joint(part) for part in self.parts]
        return np.diff(np.stack([*points, self.end]), axis=0)


_LIMB_ROUNDS = 60
_LARGEST_TURN = 0.35
"""Radians that a joint may turn in one round."""

_STRETCHED = 0.9
"""Share of its length from which on a chain is so straight that a side to fold to must be given."""


class Chain(LimbChain):
    """A chain of parts that folds as little as it must."""

    def reach(self, view: PointerView, goal: Aim) -> Reached:
        """The chain with its end at the goal, or as near as it can come."""
        return self._at(within_reach(view, goal, self.centre, *self._range_m(), self.end))

    def toward(self, place: Array) -> Reached:
        """The chain with its end at a place (3,) in the camera frame, or straight toward it."""
        offset = place - self.centre
        nearest, farthest = self._range_m()
        return self._at(self.centre + min(max(length(offset), nearest), farthest) * unit(offset))

    def _range_m(self) -> tuple[float, float]:
        """The least and the largest distance from the first joint to the end."""
        sizes = np.sqrt((self.lever_arms() ** 2).sum(axis=1))
        return max(0.0, float(2 * sizes.max() - sizes.sum())), float(sizes.sum())

    def _at(self, place: Array) -> Reached:
        """The chain with its end at a place within reach."""
        lever_arms, (_, farthest) = self.lever_arms(), self._range_m()
        turns = self._solved(lever_arms, self._folded(lever_arms, farthest, place), place)
        return Reached(self._rotations(turns), self.centre, farthest)

    def _folded(self, lever_arms: Array, farthest: float, place: Array) -> Array:
        """(K, 3, 3) turns to begin with: a zigzag where a straight chain is to become shorter."""
        stretched = length(self.end - self.centre) / farthest
        share = smooth_step((stretched - _STRETCHED) / (1 - _STRETCHED))
        shorter = min(length(place - self.centre) / farthest, 1.0)
        angle = share * math.acos(shorter)
        R = self.context.R_camera_part(self.parts[0])
        side = cross(unit(lever_arms[0]), R[:, 0])
        axis = (
            unit(cross(unit(lever_arms[0]), side))
            if length(side) > 0.1
            else any_across(unit(lever_arms[0]))
        )
        signs = np.where(np.arange(len(lever_arms)) % 2 == 0, 1.0, -1.0)
        return exp_rotation(signs[:, None] * angle * axis)

    def _solved(self, lever_arms: Array, turns: Array, place: Array) -> Array:
        """(K, 3, 3) how each part has turned in the camera frame when the end is at the place."""
        for _ in range(_LIMB_ROUNDS):
            placed = np.einsum("kij,kj->ki", turns, lever_arms)
            joints = np.concatenate([np.zeros((1, 3)), np.cumsum(placed, axis=0)])
            miss = place - self.centre - joints[-1]
            if length(miss) < 1e-10:
                break
            steps = _least_turns(joints[-1] - joints[:-1], miss)
            turns = exp_rotation(np.cumsum(steps, axis=0)) @ turns
        return turns

    def _rotations(self, turns: Array) -> dict[int, Array]:
        """Rotations in the parents' frames, inside their limits."""
        context = self.context
        R_parent = context.R_camera_parent(self.parts[0])
        rotations = {}
        for part, by in zip(self.parts, turns, strict=True):
            R_camera_part = by @ context.R_camera_part(part)
            rotations[part] = context.allowed(part, R_parent.T @ R_camera_part)
            R_parent = R_camera_part
        return rotations


def _least_turns(arms: Array, miss: Array) -> Array:
    """(K, 3) rotation vectors of all joints that move the end by `miss`, together the smallest.

    arms: (K, 3) from each joint to the end.  J Jᵀ of a turn w × arm is |arm|² I − arm armᵀ.
    """
    square = (arms**2).sum() * np.eye(3) - arms.T @ arms
    damping = 1e-9 * float(np.trace(square)) + 1e-3 * float(miss @ miss)
    pull = np.linalg.solve(square + damping * np.eye(3), miss)
    steps = np.cross(arms, pull)
    largest = float(np.sqrt((steps**2).sum(axis=1)).max())
    return np.asarray(steps * min(1.0, _LARGEST_TURN / max(largest, 1e-12)))


FALL = 0.45
"""Each part turns against the one below it by this share of what that one turns."""

MOST = math.radians(200.0)
"""The head turns no further than this, all in all."""

_SPINE_ROUNDS = 12
"""So few that nothing jumps: where the chain, bending, comes ever nearer to its own foot, another
bend far away solves the same, and the more rounds, the sooner a small move of the pointer changes
to it. What is left then is done by the lowest part."""


class Spine(LimbChain):
    """A chain of parts that bends evenly."""

    def reach(self, view: PointerView, goal: Aim) -> Reached:
        """Bend the chain about one axis so that its end comes under the pointer.

        How far the end is from the lowest joint follows from the bend; it is found together with
        it. What limits of the upper parts, or the rounds, leave undone, the lowest part does.
        """
        lever_arms = self.lever_arms()
        shares = _shares(len(self.parts))
        resting = self._resting()
        vector, end = np.zeros(3), self.end
        worth = _worth(lever_arms, shares)
        for _ in range(_SPINE_ROUNDS):
            radius = length(end - self.centre)
            place = on_sphere(view, goal, self.centre, radius, self.end, resting)
            off = _turn_vector(unit(end - self.centre), unit(place - self.centre))
            if length(off) < 1e-11:
                break
            vector = _capped(vector + off / worth)
            turns = exp_rotation(shares[:, None] * vector)
            end = self.centre + np.einsum("kij,kj->i", turns, lever_arms)
        return self._limited(shares, vector, view, goal, resting)

    def _resting(self) -> Array:
        rest = self.context.skeleton.joints[list(self.parts[1:])].sum(axis=0) + self.tip
        return self.context.resting_direction(self.parts[0], rest)

    def _limited(
        self, shares: Array, vector: Array, view: PointerView, goal: Aim, resting: Array
    ) -> Reached:
        context = self.context
        turns = exp_rotation(shares[:, None] * vector)
        rotations: dict[int, Array] = {}
        R_parent = context.R_camera_parent(self.parts[0])
        for part, by in zip(self.parts, turns, strict=True):
            R_camera_part = by @ context.R_camera_part(part)
            rotations[part] = context.allowed(part, R_parent.T @ R_camera_part)
            R_parent = R_camera_part
        rotations[self.parts[0]] = self._rest_done(rotations, view, goal, resting)
        end = self._end_of(rotations)
        return Reached(rotations, self.centre, length(end - self.centre))

    def _end_of(self, rotations: dict[int, Array]) -> Array:
        """(3,) the tip for rotations of all parts, camera frame."""
        R, place = self.context.R_camera_parent(self.parts[0]), self.centre
        joints = [*self.context.skeleton.joints[list(self.parts[1:])], self.tip]
        for part, joint in zip(self.parts, joints, strict=True):
            R = R @ rotations[part]
            place = place + R @ joint
        return np.asarray(place)

    def _rest_done(
        self, rotations: dict[int, Array], view: PointerView, goal: Aim, resting: Array
    ) -> Array:
        """The lowest part's rotation with what is missing added, as far as its limits go."""
        first = self.parts[0]
        end = self._end_of(rotations)
        radius = length(end - self.centre)
        place = on_sphere(view, goal, self.centre, radius, self.end, resting)
        start = unit(end - self.centre)
        R_parent = self.context.R_camera_parent(first)
        more = Swing.of(start, resting).to(unit(place - self.centre))
        return self.context.allowed(first, R_parent.T @ more @ R_parent @ rotations[first])


def _shares(count: int) -> Array:
    """(K,) how far each part turns in space, of what the last one turns: rising to 1."""
    own = FALL ** np.arange(count)
    return np.asarray(np.cumsum(own) / own.sum())


def _worth(lever_arms: Array, shares: Array) -> float:
    """By how much the direction to the end turns when the last part turns by 1."""
    sizes = np.sqrt((lever_arms**2).sum(axis=1))
    return float((sizes * shares).sum() / sizes.sum())


def _turn_vector(start: Array, end: Array) -> Array:
    """The rotation vector (3,) that takes one unit vector to another."""
    axis = cross(start, end)
    size = length(axis)
    angle = math.atan2(size, float(start @ end))
    return axis * (angle / size) if size > 1e-15 else np.zeros(3)


def _capped(vector: Array) -> Array:
    size = length(vector)
    return vector if size <= MOST else vector * (MOST / size)
