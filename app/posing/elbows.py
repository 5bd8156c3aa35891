"""The joint between two bones dragged itself: an elbow or a knee.

The upper limb swings so that the joint comes under the pointer. The end stays where it is as far
as the bones allow: the lower limb keeps pointing at that place, the upper one turning about itself
so that the hinge can. Near the places where this would be a sudden turn of the limb about itself
(a joint dragged straight through, or to the wrong side) less and less of it is done.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.posing.moving import Aim
from app.posing.pointer_view import PointerView
from app.posing.swinging import Swing, on_sphere
from app.posing.two_bones import Reached, TwoBones
from app.posing.vectors import across, cross, length, signed_angle, smooth_step, turn, unit, wrapped
from tracker.geometry.rotations import Array

FULL = math.radians(100.0)
"""Up to this angle a turn is made whole; beyond, less, until half a circle makes none."""

CLEAR = 0.6
"""Share of the lower bone's length from which on the end lies well to one side of the limb. A limb
that is nearly straight is swung as a whole instead."""


@dataclass(frozen=True, eq=False)
class Elbow:
    """A limb whose middle joint is dragged; `limb` is all that is known of it."""

    limb: TwoBones

    @property
    def joint(self) -> Array:
        """(3,) the elbow before the drag, in the camera frame."""
        return self.limb.context.joint(self.limb.lower)

    def reach(self, view: PointerView, goal: Aim) -> Reached:
        """The limb with its middle joint at the goal, as far as the upper bone reaches."""
        limb, context = self.limb, self.limb.context
        radius = length(self.joint - limb.centre)
        resting = context.resting_direction(limb.upper, limb.hinge.upper)
        place = on_sphere(view, goal, limb.centre, radius, self.joint, resting)
        R_swung = self._swung(unit(place - limb.centre), resting)
        axis = unit(place - limb.centre)
        R_upper = turn(axis, self._twist(R_swung, place)) @ R_swung
        by = self._hinge_turn(R_upper)
        rotations = {
            limb.upper: context.R_camera_parent(limb.upper).T @ R_upper,
            limb.lower: turn(limb.hinge.axis, by) @ context.pose.Rs_parent_part[limb.lower],
        }
        return Reached(rotations, limb.centre, radius)

    def _swung(self, direction: Array, resting: Array) -> Array:
        limb = self.limb
        R_before = limb.context.R_camera_part(limb.upper)
        start = unit(self.joint - limb.centre)
        return np.asarray(Swing.of(start, resting).to(direction) @ R_before)

    def _twist(self, R_upper: Array, joint: Array) -> float:
        """How far the upper limb turns about itself for the hinge to face the end's old place."""
        limb = self.limb
        R_before = limb.context.R_camera_part(limb.upper)
        return self._facing(R_upper, joint) - self._facing(R_before, self.joint)

    def _facing(self, R_upper: Array, joint: Array) -> float:
        """The softened angle from where the hinge bends the lower limb to the end's old place."""
        limb = self.limb
        axis = unit(joint - limb.centre)
        wanted = across(limb.end - joint, axis)
        clear = smooth_step(length(wanted) / (CLEAR * length(limb.hinge.lower)))
        if clear == 0.0:
            return 0.0
        bends_to = across(R_upper @ self._natural(), axis)
        return clear * softened(signed_angle(bends_to, wanted, axis))

    def _natural(self) -> Array:
        """(3,) across the upper limb, in its frame: to where its hinge bends the lower limb."""
        hinge = self.limb.hinge
        now = across(hinge.lower, unit(hinge.upper))
        bent_well = length(now) > math.sin(math.radians(3.0)) * length(hinge.lower)
        return unit(now) if bent_well else hinge.side * cross(hinge.axis, unit(hinge.upper))

    def _hinge_turn(self, R_upper: Array) -> float:
        """How far the hinge turns for the lower limb to point at the end's old place."""
        limb, hinge = self.limb, self.limb.hinge
        joint = limb.centre + R_upper @ hinge.upper
        wanted = across(R_upper.T @ (limb.end - joint), hinge.axis)
        clear = smooth_step(length(wanted) / (CLEAR * length(hinge.lower)))
        if clear == 0.0:
            return 0.0
        by = clear * softened(signed_angle(hinge.lower, wanted, hinge.axis))
        bend = hinge.side * (hinge.bend + by)
        low = min(hinge.least, hinge.side * hinge.bend)
        high = max(hinge.most, hinge.side * hinge.bend)
        return hinge.side * min(max(bend, low), high) - hinge.bend


def softened(angle: float) -> float:
    """The angle itself up to FULL, then falling to 0 at half a circle, so that nothing jumps."""
    angle = wrapped(angle)
    if abs(angle) <= FULL:
        return angle
    return math.copysign(FULL * (math.pi - abs(angle)) / (math.pi - FULL), angle)
