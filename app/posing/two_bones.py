"""Bend two bones and a hinge in closed form: shoulder, elbow and hand, or hip, knee and foot."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from keypose.app.posing.gesture import GestureContext
from keypose.app.posing.limits import box_of
from keypose.app.posing.moving import Aim
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.swinging import Swing, in_level, keeps_level
from keypose.app.posing.untwisting import EASED_M, untwisted
from keypose.app.posing.vectors import (
    across,
    any_across,
    cross,
    length,
    signed_angle,
    smooth_step,
    turn,
    unit,
    wrapped,
)
from keypose.tracker.body.body import Part
from keypose.tracker.geometry.rotations import Array


def within_reach(
    view: PointerView,
    goal: Aim,
    centre: Array,
    nearest_m: float,
    farthest_m: float,
    p_before: Array,
) -> Array:
    """(3,) the goal, or the nearest place to it whose distance from the centre can be.

    A drag in the plane of the view keeps its depth while it can. Where it cannot, the place stays
    under the pointer and its depth gives way; past the outline of what can be reached it sticks to
    that. A drag along a line stays on the line while it can.
    """
    away = length(goal.p_camera - centre)
    if nearest_m <= away <= farthest_m:
        return goal.p_camera
    radius = farthest_m if away > farthest_m else nearest_m
    if goal.line is not None:
        p_goal = _on_line(goal.line, goal.p_camera, p_before, centre, radius)
    else:
        if away < nearest_m:
            return _pushed_out(view, goal, centre, radius)
        if keeps_level(view, p_before - centre, radius):
            return in_level(view, goal, centre, radius, p_before)
        p_goal = _under_pointer(view, goal, centre, radius)
    return np.asarray(centre + radius * unit(p_goal - centre))


def _under_pointer(view: PointerView, goal: Aim, centre: Array, radius: float) -> Array:
    """(3,) where the line of sight meets the sphere, on the side, near or far, of the goal."""
    origin, ray = view.ray(goal.at)
    foot = origin + float((centre - origin) @ ray) * ray
    gap = length(foot - centre)
    if gap >= radius:
        return np.asarray(foot)
    sign = math.copysign(1.0, float((goal.p_camera - centre) @ ray))
    return np.asarray(foot + sign * math.sqrt(radius**2 - gap**2) * ray)


def _pushed_out(view: PointerView, goal: Aim, centre: Array, radius: float) -> Array:
    """(3,) the goal pushed straight nearer or farther, whichever it is of the centre, until it
    leaves the sphere around it."""
    offset = goal.p_camera - centre
    height = float(offset @ view.away)
    beside = offset - height * view.away
    depth = math.sqrt(radius**2 - float(beside @ beside))
    return np.asarray(centre + beside + math.copysign(depth, height) * view.away)


def _on_line(direction: Array, place: Array, before: Array, centre: Array, radius: float) -> Array:
    """(3,) the nearest of the two points in which the line cuts the sphere, seen from `place`.

    Inside an inner sphere it is the one on the side where the drag began.
    """
    foot = place + float((centre - place) @ direction) * direction
    gap = length(foot - centre)
    if gap >= radius:
        return np.asarray(foot)
    inside = length(place - centre) < radius
    offset = (before if inside else place) - foot
    sign = math.copysign(1.0, float(offset @ direction))
    return np.asarray(foot + sign * math.sqrt(radius**2 - gap**2) * direction)


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
        """The distance from the upper joint to the far end, metres."""
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


@dataclass(frozen=True, eq=False)
class Reached:
    """What a limb's solution is.

    rotations: (3, 3) of the parts that turn, in their parents' frames, by part.
    centre, radius_m: the sphere that the end cannot leave.
    """

    rotations: dict[int, Array]
    centre: Array
    radius_m: float


@dataclass(frozen=True, eq=False)
class TwoBones:
    """A limb of an upper and a lower part; tip (3,) is its end in the lower part's frame."""

    context: GestureContext
    upper: int
    lower: int
    tip: Array
    hinge: Hinge

    @classmethod
    def of(cls, context: GestureContext, upper: int, lower: int, tip: Array) -> TwoBones:
        return cls(context, upper, lower, tip, Hinge.of(context, lower, tip))

    @property
    def centre(self) -> Array:
        """(3,) shoulder or hip, in the camera frame."""
        return self.context.joint(self.upper)

    @property
    def end(self) -> Array:
        """(3,) hand or foot before the drag, in the camera frame."""
        return self.context.placed(self.lower, self.tip)

    def reach(self, view: PointerView, goal: Aim) -> Reached:
        """The limb with its end at the goal, or as near as it can come.

        The hinge alone sets the distance; then the whole limb is swung there, and the plane in
        which it is bent goes along without turning about the limb. The hinge keeps its limits; the
        upper joint is led by the middle of its range but not held, or the end could not follow;
        where its part would be twisted too far, the whole limb turns about the line to its end.
        """
        hinge = self.hinge
        place = within_reach(view, goal, self.centre, hinge.nearest_m, hinge.farthest_m, self.end)
        return self._at(place, length(goal.p_camera - self.end))

    def toward(self, place: Array) -> Reached:
        """The limb with its end at a place (3,) in the camera frame, or straight toward it."""
        hinge, offset = self.hinge, place - self.centre
        away = min(max(length(offset), hinge.nearest_m), hinge.farthest_m)
        return self._at(self.centre + away * unit(offset), length(place - self.end))

    def _at(self, place: Array, drawn_m: float) -> Reached:
        """The limb with its end at a place within reach. drawn_m: how far that was drawn."""
        hinge, context = self.hinge, self.context
        bend = self._eased(hinge.bend_for(length(place - self.centre)), drawn_m)
        lower = turn(hinge.axis, bend - hinge.bend)
        direction = unit(place - self.centre)
        to_parent = context.R_camera_parent(self.upper).T
        R_upper = to_parent @ self._swung(lower, direction)
        rotations = {
            self.upper: untwisted(context, self.upper, R_upper, to_parent @ direction, drawn_m),
            self.lower: lower @ context.pose.Rs_parent_part[self.lower],
        }
        return Reached(rotations, self.centre, hinge.farthest_m)

    def _eased(self, bend: float, drawn_m: float) -> float:
        """Where the pose is bent the wrong way, it stays so at first: nothing jumps."""
        hinge = self.hinge
        if hinge.bend * hinge.side >= 0:
            return bend
        share = 1.0 - smooth_step(drawn_m / EASED_M)
        return bend + share * (hinge.bend - hinge.side * abs(hinge.bend))

    def _swung(self, lower: Array, direction: Array) -> Array:
        """(3, 3) R_camera_upper that points the limb, its hinge turned by `lower`, to there.

        `lower` (3, 3) is a turn in the upper part's frame.
        """
        hinge = self.hinge
        R_before = self.context.R_camera_part(self.upper)
        before, after = hinge.upper + hinge.lower, hinge.upper + lower @ hinge.lower
        # Bending turns the line from joint to end inside the limb; it is turned back in its plane.
        back = 0.0
        if length(across(after, hinge.axis)) > 1e-9 and length(across(before, hinge.axis)) > 1e-9:
            back = signed_angle(after, before, hinge.axis)
        R_flat = R_before @ turn(hinge.axis, back)
        swing = self.swing
        return np.asarray(swing.to(direction, unit(R_flat @ after)) @ R_flat)

    @property
    def swing(self) -> Swing:
        """How the limb as a whole is swung."""
        start = unit(self.end - self.centre)
        rest = self.context.skeleton.joints[self.lower] + self.tip
        resting = self.context.resting_direction(self.upper, rest)
        normal = self.context.R_camera_part(self.upper) @ self.hinge.axis
        return Swing.of(start, resting, cross(normal, start))
