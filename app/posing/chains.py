"""A limb of many parts: damped least squares, every joint turning as little as it can."""

from __future__ import annotations

import math

import numpy as np

from keypose.app.posing.limb_chain import LimbChain
from keypose.app.posing.moving import Aim
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.reach_limit import within_reach
from keypose.app.posing.two_bones import Reached
from keypose.app.posing.vectors import any_across, cross, length, smooth_step, unit
from keypose.tracker.geometry.rotations import Array, exp_rotation

_ROUNDS = 60
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
        way = place - self.centre
        nearest, farthest = self._range_m()
        return self._at(self.centre + min(max(length(way), nearest), farthest) * unit(way))

    def _range_m(self) -> tuple[float, float]:
        """The least and the largest distance from the first joint to the end."""
        sizes = np.sqrt((self.levers() ** 2).sum(axis=1))
        return max(0.0, float(2 * sizes.max() - sizes.sum())), float(sizes.sum())

    def _at(self, place: Array) -> Reached:
        """The chain with its end at a place within reach."""
        levers, (_, farthest) = self.levers(), self._range_m()
        turns = self._solved(levers, self._folded(levers, farthest, place), place)
        return Reached(self._rotations(turns), self.centre, farthest)

    def _folded(self, levers: Array, farthest: float, place: Array) -> Array:
        """(K, 3, 3) turns to begin with: a zigzag where a straight chain is to become shorter."""
        stretched = length(self.end - self.centre) / farthest
        share = smooth_step((stretched - _STRETCHED) / (1 - _STRETCHED))
        shorter = min(length(place - self.centre) / farthest, 1.0)
        angle = share * math.acos(shorter)
        R = self.context.R_camera_part(self.parts[0])
        side = cross(unit(levers[0]), R[:, 0])
        axis = (
            unit(cross(unit(levers[0]), side))
            if length(side) > 0.1
            else any_across(unit(levers[0]))
        )
        signs = np.where(np.arange(len(levers)) % 2 == 0, 1.0, -1.0)
        return exp_rotation(signs[:, None] * angle * axis)

    def _solved(self, levers: Array, turns: Array, place: Array) -> Array:
        """(K, 3, 3) how each part has turned in the camera frame when the end is at the place."""
        for _ in range(_ROUNDS):
            placed = np.einsum("kij,kj->ki", turns, levers)
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
        found = {}
        for part, by in zip(self.parts, turns, strict=True):
            R_camera_part = by @ context.R_camera_part(part)
            found[part] = context.allowed(part, R_parent.T @ R_camera_part)
            R_parent = R_camera_part
        return found


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
