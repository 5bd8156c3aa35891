"""Shapes and sizes of single parts, in centimetres; children's joints go with the surface."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from keypose.app.posing.labels import kind_of
from keypose.tracker.body import modify
from keypose.tracker.body.body import Body, Part, Point
from keypose.tracker.body.modify import with_parts
from keypose.tracker.body.shapes import KINDS, Shape
from keypose.tracker.errors import BodyError

SizeRole: TypeAlias = Literal["length", "width", "other"]

SMALLEST_CM = 0.2
LARGEST_CM = 1000.0
LOWEST_CM, HIGHEST_CM = 1.0, 10_000.0

_LADDER = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, LARGEST_CM)

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

    def change(given: Part) -> Part:
        if given.name not in names or given.shape.kind == kind:
            return given
        return given.model_copy(update={"shape": KINDS[kind].like(given.shape)})

    return with_parts(body, map(change, body.parts))


def with_size(body: Body, part: str, key: str, cm: float, *, linked: bool = True) -> Body:
    """The body with one size of a part changed, on both sides if linked.

    What hangs on the part and its landmarks go with the surface: a longer thigh carries the shin
    along, broader shoulders the arms.
    """
    names = {part, body.mirror_of(part)} if linked else {part}
    for name in (part, *sorted(names - {part})):
        known = [size.key for size in body.parts[body.index(name)].shape.sizes()]
        if key not in known:
            raise BodyError(f"Part {name!r} has no size {key!r}; its sizes are {', '.join(known)}.")
    _require_between("size", cm, SMALLEST_CM, LARGEST_CM)

    def change(given: Part) -> Part:
        update: dict[str, object] = {}
        if given.name in names:
            new = given.shape.with_size(key, _metres(key, cm))
            carry = _carrier(given.shape, new)
            update = {"shape": new, "landmarks": {k: carry(p) for k, p in given.landmarks.items()}}
        if given.parent in names:
            parent = body.parts[body.index(given.parent)].shape
            update["joint_m"] = _carrier(parent, parent.with_size(key, _metres(key, cm)))(
                given.joint_m
            )
        return given.model_copy(update=update) if update else given

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


def _require_between(what: str, cm: float, low: float, high: float) -> None:
    if not (math.isfinite(cm) and low <= cm <= high):
        raise BodyError(f"The {what} must lie between {low:g} and {high:g} cm.")


def _span(cm: float) -> tuple[float, float]:
    """What a slider spans: steady while the size changes a little."""
    high = next((step for step in _LADDER if step >= 1.6 * cm), LARGEST_CM)
    return max(SMALLEST_CM, high / 100), high


def _role(kind: str, key: str, keys: Sequence[str]) -> SizeRole:
    roles = _ROLES_OF_AXES.get(kind, _ROLES) if "depth" in keys else _ROLES
    return roles.get(key.rpartition("_")[2], "other")


def _labels(kind: str, keys: Sequence[str]) -> Iterator[str]:
    own = _LABELS_OF_AXES.get(kind, {}) if "depth" in keys else {}
    for key in keys:
        end, _, what = key.rpartition("_")
        if not end:
            yield own.get(key, "Width" if what == "radius" else key.capitalize())
            continue
        place = _ENDS.get(kind, ("joint", "end"))[end == "end"]
        yield f"{'Width' if what == 'radius' else what.capitalize()} at {place}"


def _carrier(before: Shape, after: Shape) -> Callable[[Point], Point]:
    """How a point in a part goes along with its surface."""

    def carried(point: Point) -> Point:
        x, y, z = point
        along = after.length_m / before.length_m
        halves = zip(after.half_widths(y * along), before.half_widths(y), strict=True)
        wide, deep = (new / old for new, old in halves)
        return x * wide, y * along, z * deep

    return carried
