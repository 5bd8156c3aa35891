"""Sizes dragged on the picture: an end cap is a length, a rim a radius, a cross a joint."""

from __future__ import annotations

import numpy as np

from keypose.app.posing.gesture import Gesture, Posed, Readout, SizeHandle
from keypose.app.posing.gesture_context import GestureContext
from keypose.app.posing.labels import number_text, part_label
from keypose.app.posing.moving import STEP_M, aim
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.resizing import LARGEST_CM, SMALLEST_CM, part_sizes, with_joint, with_size
from keypose.app.posing.vectors import length
from keypose.tracker.errors import BodyError
from keypose.tracker.geometry.rotations import Array

_SEEN = 0.2
"""Share of its length under which an axis, seen end on, is too short to be dragged along."""


def resize_by_drag(
    context: GestureContext, view: PointerView, gesture: Gesture, handle: SizeHandle, linked: bool
) -> Posed:
    """The body with a size changed by as much as the pointer went; the pose stays."""
    part = context.skeleton.body.index(handle.part)
    if handle.key == "joint":
        return _joint_moved(context, view, gesture, part, linked)
    key = _key(context, handle)
    way = _way(context, view, gesture, part, key)
    if gesture.snap:
        way = round(way / STEP_M) * STEP_M
    body = context.skeleton.body
    size = next(size for size in part_sizes(body, handle.part) if size.key == key)
    cm = min(max(size.cm + 100 * way * _worth(key), SMALLEST_CM), LARGEST_CM)
    changed = with_size(body, handle.part, key, cm, linked=linked)
    readout = Readout(
        label=size.label,
        value=f"{number_text(cm, 1)} cm",
        change=number_text(cm - size.cm, 1, sign=True),
        part=handle.part,
    )
    return Posed(context.pose, changed, readout)


def _key(context: GestureContext, handle: SizeHandle) -> str:
    """The size that is meant; "radius" of a tapered part is the one at the handle's side."""
    body = context.skeleton.body
    known = [size.key for size in part_sizes(body, handle.part)]
    if handle.key in known:
        return handle.key
    end = "start" if handle.side == "joint" else "end"
    meant = [f"{end}_{handle.key}", *([f"{end}_width"] if handle.key == "radius" else [])]
    for key in meant:
        if key in known:
            return key
    raise BodyError(
        f"Part {handle.part!r} has no size {handle.key!r}; its sizes are {', '.join(known)}."
    )


def _worth(key: str) -> float:
    """Whole widths grow at both sides when one is dragged."""
    return 2.0 if key.endswith(("width", "depth", "radius")) else 1.0


def _way(
    context: GestureContext, view: PointerView, gesture: Gesture, part: int, key: str
) -> float:
    """Metres by which the pointer pulled the surface outward."""
    T = context.Ts_camera_part[part]
    shape = context.skeleton.body.parts[part].shape
    joint = T[:3, 3]
    slope = view.slope(joint)
    pulled = np.array([gesture.at[k] - gesture.from_[k] for k in range(2)])
    if key == "length":
        _, end, _ = next(size.p_part for size in shape.sizes() if size.key == "length")
        sign = -1.0 if end < 0 else 1.0
        # The joint keeps its share of the length, so the end moves by less than all of it.
        share = max(abs(end) / shape.length_m, 0.1)
        return _along(slope @ (sign * T[:3, 1]), pulled, view, joint) / share
    return _outward(slope, T, pulled, gesture, view)


def _along(axis: Array, pulled: Array, view: PointerView, joint: Array) -> float:
    """Metres along an axis, given as it is seen: units of the view for a metre."""
    unit_of_view = 1.0 / view.metres_per_unit(joint)
    seen = length(axis) / unit_of_view
    if seen < _SEEN:
        return -float(pulled[1]) / unit_of_view
    return float(pulled @ axis) / float(axis @ axis)


def _outward(slope: Array, T: Array, pulled: Array, gesture: Gesture, view: PointerView) -> float:
    """Metres at right angles to the part's line, away from it on the side of the pointer."""
    axis = slope @ T[:3, 1]
    unit_of_view = 1.0 / view.metres_per_unit(T[:3, 3])
    begun = np.array(gesture.from_) - view.project(T[:3, 3])
    if length(axis) < _SEEN * unit_of_view:
        normal = begun if length(begun) > 0 else np.array([1.0, 0.0])
    else:
        normal = np.array([-axis[1], axis[0]])
        normal = normal if float(normal @ begun) >= 0 else -normal
    return float(pulled @ normal) / length(normal) / unit_of_view


def _joint_moved(
    context: GestureContext, view: PointerView, gesture: Gesture, part: int, linked: bool
) -> Posed:
    """The part's joint dragged in the plane of the view."""
    name = _name(context, part)
    joint = context.joint(part)
    goal = aim(view, joint, gesture)
    R_parent = context.R_camera_parent(part)
    place = context.skeleton.joints[part] + R_parent.T @ (goal.p_camera - joint)
    x, y, z = (min(max(100 * float(v), -LARGEST_CM), LARGEST_CM) for v in place)
    body = with_joint(context.skeleton.body, name, (x, y, z), linked=linked)
    readout = Readout(
        label=f"{part_label(name)}, joint",
        value=f"{number_text(x, 1)}, {number_text(y, 1)}, {number_text(z, 1)} cm",
        part=name,
    )
    return Posed(context.pose, body, readout)


def _name(context: GestureContext, part: int) -> str:
    return context.skeleton.body.names[part]
