"""The joint between two bones, as the one turn that elbows and knees have."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from keypose.app.posing.gesture_context import GestureContext
from keypose.app.posing.limits import box_of
from keypose.app.posing.vectors import across, any_across, cross, length, unit, wrapped
from keypose.tracker.body.body import Part
from keypose.tracker.geometry.rotations import Array

NARROW = math.radians(40.0)
"""A range this small, of both y and z, makes a joint a hinge about x."""

STRAIGHT = 1e-3
"""Radians of bend under which a pose does not show which way the joint bends."""


@dataclass(frozen=True, eq=False)
class Hinge:
    """Two bones whose far end's distance depends on one angle.

    Everything is in the upper bone's frame; `bend` is the angle from where the limb is longest,
    positive about the axis.

    upper:  (3,) from the upper joint to the hinge.
    lower:  (3,) from the hinge to the far end, as the limb is bent now.
    axis:   (3,) unit vector.
    bend:   the bend now.
    side:   1 or −1, the sign of the bends that a drag may give.
    least, most: the smallest and largest bend to that side.
    """

    upper: Array
    lower: Array
    axis: Array
    bend: float
    side: float
    least: float
    most: float

    @classmethod
    def of(cls, context: GestureContext, part: int, p_part_tip: Array) -> Hinge:
        """The joint of a part, whose bone ends at p_part_tip in the part's frame."""
        R = context.pose.Rs_parent_part[part]
        upper = context.skeleton.joints[part]
        lower = R @ p_part_tip
        axis = _axis(context.skeleton.body.parts[part], R, upper, lower)
        cosine = float(across(upper, axis) @ across(lower, axis))
        sine = float(cross(upper, lower) @ axis)
        bend = math.atan2(sine, cosine)
        low, high, natural = _range(context, part, axis, R, bend)
        is_clear = abs(bend) >= STRAIGHT and not context.limits_on
        side = math.copysign(1.0, bend) if is_clear else natural
        ends = sorted((side * low, side * high))
        return cls(upper, lower, axis, bend, side, max(ends[0], 0.0), max(ends[1], 0.0))

    @property
    def _lever(self) -> tuple[float, float]:
        """c, a of distance² = c + a cos(bend)."""
        along = float(self.upper @ self.axis) * float(self.lower @ self.axis)
        fixed = float(self.upper @ self.upper) + float(self.lower @ self.lower) + 2 * along
        arms = length(across(self.upper, self.axis)) * length(across(self.lower, self.axis))
        return fixed, 2 * arms

    def distance(self, bend: float) -> float:
        """From the upper joint to the far end, metres."""
        fixed, arms = self._lever
        return math.sqrt(max(fixed + arms * math.cos(bend), 0.0))

    @property
    def farthest_m(self) -> float:
        return self.distance(self.least)

    @property
    def nearest_m(self) -> float:
        return self.distance(self.most)

    def bend_for(self, distance: float) -> float:
        """The bend, on the side that is allowed, that gives this distance or the nearest to it."""
        fixed, arms = self._lever
        cosine = (distance**2 - fixed) / arms if arms > 1e-12 else 1.0
        bend = math.acos(min(max(cosine, -1.0), 1.0))
        return self.side * min(max(bend, self.least), self.most)


def _axis(part: Part, R: Array, upper: Array, lower: Array) -> Array:
    """The hinge's axis in the parent's frame: the part's own one that it is made for.

    A joint that is no hinge is bent in the plane in which it is bent now.
    """
    own = _own_axis(part)
    if own is not None and length(across(unit(lower), R[:, own])) > 0.3:
        return np.array(R[:, own])
    normal = cross(upper, lower)
    if length(normal) > math.sin(math.radians(3.0)) * length(upper) * length(lower):
        return unit(normal)
    flat = across(R[:, 0], unit(upper))
    return unit(flat) if length(flat) > 0.1 else any_across(unit(upper))


def _own_axis(part: Part) -> int | None:
    box = box_of(part)
    if box is not None and (box[1:, 1] - box[1:, 0]).min() <= NARROW:
        return 0
    turns = [dof for dof in part.tracked if dof[0] == "r"]
    return "xyz".index(turns[0][1]) if len(turns) == 1 else None


def _range(
    context: GestureContext, part: int, axis: Array, R: Array, bend: float
) -> tuple[float, float, float]:
    """Lowest and highest bend, and the sign of the natural ones."""
    box = box_of(context.skeleton.body.parts[part])
    is_x = float(axis @ R[:, 0]) > 1 - 1e-9
    if box is None or not is_x or not np.isfinite(box[0]).all():
        sign = math.copysign(1.0, bend) if abs(bend) > STRAIGHT else -1.0
        return -math.pi, math.pi, sign
    offset = bend - float(context.angles(part)[0])  # from the part's angle about x to the bend
    low, high = (float(end) for end in box[0] + offset)
    natural = math.copysign(1.0, wrapped((low + high) / 2))
    counted = context.joint_range(part)
    if counted is None:
        return -math.pi, math.pi, natural
    low, high = (float(end) for end in counted.box[0] + offset)
    return low, high, natural
