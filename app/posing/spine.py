"""The head dragged: neck and chest follow, each by its share."""

from __future__ import annotations

import math

import numpy as np

from keypose.app.posing.limb_chain import LimbChain
from keypose.app.posing.moving import Aim
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.swinging import Swing, on_sphere
from keypose.app.posing.two_bones import Reached
from keypose.app.posing.vectors import cross, length, unit
from keypose.tracker.geometry.rotations import Array, exp_rotation

FALL = 0.45
"""Each part turns against the one below it by this share of what that one turns."""

MOST = math.radians(200.0)
"""The head turns no further than this, all in all."""

_ROUNDS = 12
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
        levers = self.levers()
        shares = _shares(len(self.parts))
        resting = self._resting()
        vector, end = np.zeros(3), self.end
        worth = _worth(levers, shares)
        for _ in range(_ROUNDS):
            radius = length(end - self.centre)
            place = on_sphere(view, goal, self.centre, radius, self.end, resting)
            off = _turn_vector(unit(end - self.centre), unit(place - self.centre))
            if length(off) < 1e-11:
                break
            vector = _capped(vector + off / worth)
            turns = exp_rotation(shares[:, None] * vector)
            end = self.centre + np.einsum("kij,kj->i", turns, levers)
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


def _worth(levers: Array, shares: Array) -> float:
    """By how much the direction to the end turns when the last part turns by 1."""
    sizes = np.sqrt((levers**2).sum(axis=1))
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
