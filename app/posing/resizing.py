"""Resize shapes and single parts, by numbers or by dragging on the picture."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from keypose.app.posing.gesture import Gesture, GestureContext, Posed, Readout, SizeHandle
from keypose.app.posing.labels import number_text, part_label
from keypose.app.posing.moving import STEP_M, aim
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.vectors import length
from keypose.tracker.body import modify
from keypose.tracker.body.body import Body, Part, Point
from keypose.tracker.body.limb_groups import kind_of
from keypose.tracker.body.modify import with_parts
from keypose.tracker.body.shapes import KINDS, Shape
from keypose.tracker.errors import BodyError
from keypose.tracker.geometry.rotations import Array

SizeRole: TypeAlias = Literal["length", "width", "other"]

SMALLEST_CM = 0.2
LARGEST_CM = 1000.0
LOWEST_CM = 1.0
HIGHEST_CM = 10_000.0
"""Of a size, and of a body's height."""

_SLIDER_ENDS_CM = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, LARGEST_CM)

_ENDS = {
    "upper_arm": ("shoulder", "elbow"),
    "forearm": ("elbow", "wrist"),
    "thigh": ("hip", "knee"),
    "shin": ("knee", "ankle"),
    "waist": ("hips", "waist"),
    "chest": ("waist", "shoulders"),
    "head": ("chin", "crown"),
}
_LABELS_OF_AXES = {
    "clavicle": {"length": "Height", "width": "Length"},
    "hand": {"width": "Depth", "depth": "Width"},
    "foot": {"length": "Height", "depth": "Length"},
}
"""Of parts that have one size along each of their axes."""
_ROLES: Mapping[str, SizeRole] = {"length": "length", "width": "width", "radius": "width"}
_ROLES_OF_AXES: Mapping[str, Mapping[str, SizeRole]] = {
    "clavicle": {"width": "length", "depth": "width"},
    "hand": {"length": "length", "depth": "width"},
    "foot": {"depth": "length", "width": "width"},
}


@dataclass(frozen=True)
class Size:
    """One size of a part, centimetres; min and max are what a slider should span.

    key: the shape's own.  at_m: where its handle is, metres in the part's frame.
    role: what it says of the part, "other" for what is neither its length nor across it.
    """

    key: str
    label: str
    cm: float
    min: float
    max: float
    at_m: Point
    role: SizeRole


def part_sizes(body: Body, part: str) -> tuple[Size, ...]:
    """All sizes of a part."""
    sizes = body.parts[body.index(part)].shape.sizes()
    keys = [size.key for size in sizes]
    return tuple(
        Size(
            size.key,
            label,
            across_cm(size.key, size.metres),
            *_span(across_cm(size.key, size.metres)),
            size.p_part,
            _role(kind_of(part), size.key, keys),
        )
        for size, label in zip(sizes, _labels(kind_of(part), keys), strict=True)
    )


def across_cm(key: str, metres: float) -> float:
    """A shape's size in centimetres: a radius as how far the part is across, like any width."""
    return (200 if key.endswith("radius") else 100) * metres


def _metres(key: str, cm: float) -> float:
    """The shape's own size."""
    return cm / (200 if key.endswith("radius") else 100)


def with_shape(body: Body, part: str, kind: str, *, linked: bool = True) -> Body:
    """The body with a part of another shape, on both sides if linked.

    It is about as long and as wide as the one before; joints and landmarks stay.
    """
    if kind not in KINDS:
        raise BodyError(f"There is no shape {kind!r}; the shapes are {', '.join(KINDS)}.")
    names = {part, body.mirror_of(part)} if linked else {part}

    def change(part_before: Part) -> Part:
        if part_before.name not in names or part_before.shape.kind == kind:
            return part_before
        return part_before.model_copy(update={"shape": KINDS[kind].like(part_before.shape)})

    return with_parts(body, map(change, body.parts))


def with_size(body: Body, part: str, key: str, cm: float, *, linked: bool = True) -> Body:
    """The body with one size of a part changed, on both sides if linked.

    What hangs on the part and its landmarks go with the surface: a longer thigh carries the shin
    along, broader shoulders the arms.
    """
    names = {part, body.mirror_of(part)} if linked else {part}
    for name in (part, *sorted(names - {part})):
        keys = [size.key for size in body.parts[body.index(name)].shape.sizes()]
        if key not in keys:
            raise BodyError(f"Part {name!r} has no size {key!r}; its sizes are {', '.join(keys)}.")
    _require_between("size", cm, SMALLEST_CM, LARGEST_CM)

    def change(part_before: Part) -> Part:
        update: dict[str, object] = {}
        if part_before.name in names:
            new = part_before.shape.with_size(key, _metres(key, cm))
            carry = _carrier(part_before.shape, new)
            update = {
                "shape": new,
                "landmarks": {k: carry(p) for k, p in part_before.landmarks.items()},
            }
        if part_before.parent in names:
            parent = body.parts[body.index(part_before.parent)].shape
            update["joint_m"] = _carrier(parent, parent.with_size(key, _metres(key, cm)))(
                part_before.joint_m
            )
        return part_before.model_copy(update=update) if update else part_before

    return with_parts(body, tuple(map(change, body.parts)))


def with_joint(
    body: Body, part: str, joint_cm: tuple[float, float, float], *, linked: bool = True
) -> Body:
    """The part hung elsewhere on its parent, centimetres in the parent's frame.

    The other side follows, mirrored, if linked.
    """
    for value in joint_cm:
        _require_between("joint's place", value, -LARGEST_CM, LARGEST_CM)
    x, y, z = (value / 100 for value in joint_cm)
    return modify.joint_moved(body, part, (x, y, z), linked=linked)


def with_height(body: Body, cm: float) -> Body:
    """The whole body scaled to a height in the rest pose."""
    _require_between("height", cm, LOWEST_CM, HIGHEST_CM)
    return modify.with_height(body, cm / 100)


def _require_between(quantity: str, cm: float, low: float, high: float) -> None:
    if not (math.isfinite(cm) and low <= cm <= high):
        raise BodyError(f"The {quantity} must lie between {low:g} and {high:g} cm.")


def _span(cm: float) -> tuple[float, float]:
    """What a slider spans: steady while the size changes a little."""
    high = next((step for step in _SLIDER_ENDS_CM if step >= 1.6 * cm), LARGEST_CM)
    return max(SMALLEST_CM, high / 100), high


def _role(kind: str, key: str, keys: Sequence[str]) -> SizeRole:
    roles = _ROLES_OF_AXES.get(kind, _ROLES) if "depth" in keys else _ROLES
    return roles.get(key.rpartition("_")[2], "other")


def _labels(kind: str, keys: Sequence[str]) -> Iterator[str]:
    own = _LABELS_OF_AXES.get(kind, {}) if "depth" in keys else {}
    for key in keys:
        end, _, quantity = key.rpartition("_")
        if not end:
            yield own.get(key, "Width" if quantity == "radius" else key.capitalize())
            continue
        place = _ENDS.get(kind, ("joint", "end"))[end == "end"]
        yield f"{'Width' if quantity == 'radius' else quantity.capitalize()} at {place}"


def _carrier(before: Shape, after: Shape) -> Callable[[Point], Point]:
    """How a point in a part goes along with its surface."""

    def carried(point: Point) -> Point:
        x, y, z = point
        along = after.length_m / before.length_m
        halves = zip(after.half_widths(y * along), before.half_widths(y), strict=True)
        wide, deep = (new / old for new, old in halves)
        return x * wide, y * along, z * deep

    return carried


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
    metres = _way(context, view, gesture, part, key)
    if gesture.snap:
        metres = round(metres / STEP_M) * STEP_M
    body = context.skeleton.body
    size = next(size for size in part_sizes(body, handle.part) if size.key == key)
    cm = min(max(size.cm + 100 * metres * _worth(key), SMALLEST_CM), LARGEST_CM)
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
    keys = [size.key for size in part_sizes(body, handle.part)]
    if handle.key in keys:
        return handle.key
    end = "start" if handle.side == "joint" else "end"
    meant = [f"{end}_{handle.key}", *([f"{end}_width"] if handle.key == "radius" else [])]
    for key in meant:
        if key in keys:
            return key
    raise BodyError(
        f"Part {handle.part!r} has no size {handle.key!r}; its sizes are {', '.join(keys)}."
    )


def _worth(key: str) -> float:
    """How much a size grows for every metre that its surface is pulled outward: what is measured
    across grows at both sides."""
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
    """Metres that the pointer pulled along an axis.

    axis, pulled (2,): as they are seen, the axis for a metre along it.
    """
    units_per_metre = 1.0 / view.metres_per_unit(joint)
    shown_length = length(axis) / units_per_metre
    if shown_length < _SEEN:  # then upward makes it longer
        return -float(pulled[1]) / units_per_metre
    return float(pulled @ axis) / float(axis @ axis)


def _outward(slope: Array, T: Array, pulled: Array, gesture: Gesture, view: PointerView) -> float:
    """Metres at right angles to the part's line, away from it on the side of the pointer."""
    axis = slope @ T[:3, 1]
    units_per_metre = 1.0 / view.metres_per_unit(T[:3, 3])
    begun = np.array(gesture.from_) - view.project(T[:3, 3])
    if length(axis) < _SEEN * units_per_metre:
        normal = begun if length(begun) > 0 else np.array([1.0, 0.0])
    else:
        normal = np.array([-axis[1], axis[0]])
        normal = normal if float(normal @ begun) >= 0 else -normal
    return float(pulled @ normal) / length(normal) / units_per_metre


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
