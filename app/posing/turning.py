"""A part turned about its joint: by a ring, or by its own surface."""

from __future__ import annotations

import math

import numpy as np

from keypose.app.posing.angles import continued
from keypose.app.posing.gesture import AxesFrame, Axis, Gesture, GestureContext, Posed, Readout
from keypose.app.posing.labels import axis_labels, degrees_text
from keypose.app.posing.limits import TURN, JointRange, furthest_share
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.vectors import across, any_across, cross, turn, unit
from keypose.tracker.geometry.rotations import Array, exp_rotation

STEP = math.radians(5.0)
"""The steps that snapping takes."""

EDGE_ON = 0.25
"""Cosine between a ring's axis and the line of sight under which the ring is nearly a line."""

EDGE_RADIUS_M = 0.15
"""A drag of this length along a ring seen from its edge is one radian."""


def rotate_by_ring(
    context: GestureContext,
    view: PointerView,
    gesture: Gesture,
    part: int,
    axis: Axis,
    axes_frame: AxesFrame,
    angle_before: float | None,
) -> Posed:
    """The part turned about one of the axes of its frame, its parent's or the view's."""
    R = _axes(context, view, part, axes_frame)
    direction = np.array(R[:, "xyz".index(axis)])
    angle = pointer_angle(view, context.joint(part), direction, gesture)
    return _turned(context, gesture, part, axis, direction, angle, angle_before)


def rotate_by_surface(
    context: GestureContext,
    view: PointerView,
    gesture: Gesture,
    part: int,
    axes_frame: AxesFrame,
    angle_before: float | None,
) -> Posed:
    """The part turned as the pointer goes round its joint; about one axis where one is held."""
    if gesture.axis is not None:
        return rotate_by_ring(context, view, gesture, part, gesture.axis, axes_frame, angle_before)
    away = view.ray_through(context.joint(part))
    angle = pointer_angle(view, context.joint(part), away, gesture)
    return _turned(context, gesture, part, None, away, angle, angle_before)


def _axes(context: GestureContext, view: PointerView, part: int, frame: AxesFrame) -> Array:
    """(3, 3) the axes in the camera frame, as columns."""
    if frame == "view":
        return view.R_view_camera.T
    return context.R_camera_parent(part) if frame == "parent" else context.R_camera_part(part)


def pointer_angle(view: PointerView, centre: Array, axis: Array, gesture: Gesture) -> float:
    """Radians about the axis that the pointer went round the centre, within ±pi.

    The pointer is taken to lie in the ring's plane. A ring seen nearly from its edge is followed
    along its near side instead. Both are measured with the scale of the view at the centre, as if
    the ring were small beside its distance, so they hold anywhere in the view.
    """
    middle, slope = view.project(centre), view.slope(centre)
    start, end = (np.array(at) - middle for at in (gesture.from_, gesture.at))
    away = view.ray_through(centre)
    if abs(float(axis @ away)) < EDGE_ON:
        return _along_edge(slope, away, axis, end - start)
    e1 = any_across(axis)
    e2 = cross(axis, e1)
    in_plane = np.linalg.inv(slope @ np.column_stack([e1, e2]))
    (a, b), (c, d) = (in_plane @ start).tolist(), (in_plane @ end).tolist()
    return math.atan2(a * d - b * c, a * c + b * d)


def _along_edge(slope: Array, away: Array, axis: Array, moved: Array) -> float:
    """Radians for the pointer moved (2,) along the near side of a ring seen from its edge."""
    tangent = slope @ cross(axis, unit(across(-away, axis)))
    return float(moved @ tangent) / float(tangent @ tangent) / EDGE_RADIUS_M


def _turned(
    context: GestureContext,
    gesture: Gesture,
    part: int,
    axis: Axis | None,
    direction: Array,
    angle: float,
    angle_before: float | None,
) -> Posed:
    if angle_before is not None:
        angle += TURN * round((angle_before - angle) / TURN)
    wanted = round(angle / STEP) * STEP if gesture.snap else angle
    R_parent = context.R_camera_parent(part)
    in_parent = R_parent.T @ direction
    R_before = context.pose.Rs_parent_part[part]
    stopped = furthest(R_before, in_parent, wanted, context.joint_range(part))
    pose = context.turned({part: turn(in_parent, stopped) @ R_before})
    name = context.skeleton.body.names[part]
    label, value, change = _words(context, part, axis, pose.Rs_parent_part[part], stopped)
    return Posed(pose, None, Readout(label, value, change, name, axis, stopped))


def furthest(rotation: Array, axis: Array, angle: float, allowed: JointRange | None) -> float:
    """How far a rotation can be turned about an axis on the way to an angle, inside its
    limits.
    """
    if allowed is None or angle == 0.0:
        return angle
    if abs(angle) > TURN:  # what does not stop one turn stops none
        once = math.copysign(TURN, angle)
        stopped = furthest(rotation, axis, once, allowed)
        return angle if stopped == once else stopped

    def on_the_way(shares: Array) -> Array:
        return exp_rotation(np.outer(shares * angle, axis)) @ rotation

    return angle * furthest_share(on_the_way, angle, allowed)


def _words(
    context: GestureContext, part: int, axis: Axis | None, R_after: Array, angle: float
) -> tuple[str, str, str]:
    """What to show: the angle's value where one of a part's angles alone has changed, else
    the turn."""
    words = axis_labels(context.skeleton.body, context.skeleton.body.names[part])
    change = degrees_text(math.degrees(angle), sign=True)
    own = context.skeleton.body.parts[part]
    if axis is not None and own.parent is None:
        return words[axis], f"{change}°", ""
    before = context.angles(part)
    after = continued(own, R_after, before)
    moved = np.abs(after - before) > math.radians(0.05)
    if axis is not None:
        k = "xyz".index(axis)
        if not moved[[i for i in range(3) if i != k]].any():
            return words[axis], f"{degrees_text(math.degrees(after[k]))}°", change
        return words[axis], f"{change}°", ""
    return "Turn", f"{change}°", ""
