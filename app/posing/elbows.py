"""The joint between two bones dragged itself: an elbow or a knee.

Where the end is held, the joint can only go round the line from shoulder to hand: `Swivel`.
Otherwise, `Elbow`: the upper limb swings so that the joint comes under the pointer. The end stays
where it is as far as the bones allow: the lower limb keeps pointing at that place, the upper one
turning about itself so that the hinge can. Near the places where this would be a sudden turn of
the limb about itself (a joint dragged straight through, or to the wrong side) less and less of it
is done. `seen_limbs.py` uses it for limbs whose joints stay where they are seen.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from keypose.app.posing.moving import Aim
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.swinging import Swing, on_sphere
from keypose.app.posing.turning import furthest
from keypose.app.posing.two_bones import Reached, TwoBones
from keypose.app.posing.untwisting import twist_range, untwisted
from keypose.app.posing.vectors import (
    across,
    cross,
    length,
    signed_angle,
    smooth_step,
    turn,
    unit,
    wrapped,
)
from keypose.tracker.geometry.rotations import Array

FULL = math.radians(100.0)
"""Up to this angle a turn is made whole; beyond, less, until half a circle makes none."""

CLEAR = 0.6
"""Share of the lower bone's length from which on the end lies well to one side of the limb. A limb
that is nearly straight is swung as a whole instead."""


EDGE_ON = 0.25
"""Cosine between a circle's axis and the line of sight under which it is nearly a line."""


@dataclass(frozen=True, eq=False)
class Swivel:
    """A limb that is turned about the line from its first joint to its end, which both stay.

    The middle joint goes round its circle to where the pointer is, seen from the circle's centre.
    There and beyond a quarter of the circle less and less of it is done, so that nothing jumps.
    """

    limb: TwoBones

    def reach(self, view: PointerView, goal: Aim) -> Reached:
        """The limb with its middle joint turned toward the goal."""
        limb, context = self.limb, self.limb.context
        joint = context.joint(limb.lower)
        axis = unit(limb.end - limb.centre)
        spoke = across(joint - limb.centre, axis)
        foot, radius = joint - spoke, length(spoke)
        wanted = self._wanted(view, goal, foot, spoke, axis)
        clear = smooth_step(length(wanted) / (CLEAR * radius)) if radius > 0 else 0.0
        angle = clear * softened(signed_angle(spoke, wanted, axis)) if clear > 0 else 0.0
        return Reached(
            {limb.upper: self._turned(axis, angle, length(wanted - spoke))}, foot, radius
        )

    def _turned(self, axis: Array, angle: float, drawn_m: float) -> Array:
        """The upper part's rotation in its parent's frame, as far on the way as it may twist."""
        limb, context = self.limb, self.limb.context
        in_parent = context.R_camera_parent(limb.upper).T @ axis
        R = untwisted(
            context, limb.upper, context.pose.Rs_parent_part[limb.upper], in_parent, drawn_m
        )
        allowed = twist_range(context, limb.upper, drawn_m)
        return np.asarray(turn(in_parent, furthest(R, in_parent, angle, allowed)) @ R)

    def _wanted(
        self, view: PointerView, goal: Aim, foot: Array, spoke: Array, axis: Array
    ) -> Array:
        """(3,) from the circle's centre to the goal, in the circle's plane."""
        if goal.line is not None:
            return across(goal.p_camera - foot, axis)
        origin, ray = view.ray(goal.at)
        if abs(float(ray @ axis)) > EDGE_ON:
            return across(origin - foot - float((origin - foot) @ axis) / (ray @ axis) * ray, axis)
        return self._along_edge(view.at_depth(goal.at, foot + spoke) - foot, spoke, axis, ray)

    def _along_edge(self, offset: Array, spoke: Array, axis: Array, ray: Array) -> Array:
        """(3,) on a circle seen from its edge: as far along it, on the side, near or far, it is."""
        along = unit(cross(axis, ray))
        inward = cross(along, axis)
        radius = length(spoke)
        moved = min(max(float(offset @ along), -radius), radius)
        depth = math.copysign(math.sqrt(radius**2 - moved**2), float(spoke @ inward))
        return np.asarray(moved * along + depth * inward)


@dataclass(frozen=True, eq=False)
class Elbow:
    """A limb whose middle joint is dragged; `limb` is all that is known of it.

    clear: share of the lower bone's length, see `CLEAR`.
    """

    limb: TwoBones
    clear: float = CLEAR

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
        return self.bent(place, limb.end)

    def bent(self, place: Array, end: Array) -> Reached:
        """The limb with its middle joint at a place (3,) on the sphere about its first joint, and
        its lower bone pointing at `end` (3,), as far as the hinge allows; camera frame."""
        limb, context = self.limb, self.limb.context
        axis = unit(place - limb.centre)
        R_swung = self._swung(axis)
        twist = self._facing(R_swung, place, end)
        twist -= self._facing(context.R_camera_part(limb.upper), self.joint, limb.end)
        to_parent = context.R_camera_parent(limb.upper).T
        drawn_m = max(length(place - self.joint), length(end - limb.end))
        R_parent_upper = untwisted(
            context, limb.upper, to_parent @ turn(axis, twist) @ R_swung, to_parent @ axis, drawn_m
        )
        by = self._hinge_turn(to_parent.T @ R_parent_upper, end)
        rotations = {
            limb.upper: R_parent_upper,
            limb.lower: turn(limb.hinge.axis, by) @ context.pose.Rs_parent_part[limb.lower],
        }
        return Reached(rotations, limb.centre, length(self.joint - limb.centre))

    def _swung(self, direction: Array) -> Array:
        limb = self.limb
        R_before = limb.context.R_camera_part(limb.upper)
        start = unit(self.joint - limb.centre)
        resting = limb.context.resting_direction(limb.upper, limb.hinge.upper)
        return np.asarray(Swing.of(start, resting).to(direction) @ R_before)

    def _facing(self, R_upper: Array, joint: Array, end: Array) -> float:
        """The softened angle from where the hinge bends the lower limb to the end's place."""
        limb = self.limb
        axis = unit(joint - limb.centre)
        wanted = across(end - joint, axis)
        clear = smooth_step(length(wanted) / (self.clear * length(limb.hinge.lower)))
        if clear == 0.0:
            return 0.0
        bends_to = across(R_upper @ self.natural(), axis)
        return clear * softened(signed_angle(bends_to, wanted, axis))

    def natural(self) -> Array:
        """(3,) across the upper limb, in its frame: to where its hinge bends the lower limb."""
        hinge = self.limb.hinge
        now = across(hinge.lower, unit(hinge.upper))
        bent_well = length(now) > math.sin(math.radians(3.0)) * length(hinge.lower)
        return unit(now) if bent_well else hinge.side * cross(hinge.axis, unit(hinge.upper))

    def _hinge_turn(self, R_upper: Array, end: Array) -> float:
        """How far the hinge turns for the lower limb to point at the end's place."""
        limb, hinge = self.limb, self.limb.hinge
        joint = limb.centre + R_upper @ hinge.upper
        wanted = across(R_upper.T @ (end - joint), hinge.axis)
        clear = smooth_step(length(wanted) / (self.clear * length(hinge.lower)))
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
