"""Sizes of single parts, by name and in centimetres; children's joints go with the surface."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from pydantic import ValidationError

from app.posing.words import kind_of
from tracker.body import scaling
from tracker.body.body import Body, Part, Point
from tracker.body.shapes import Box, Cylinder, Frustum, Shape
from tracker.errors import BodyError, one_sentence

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
_BOX_LABELS = {
    "hand": {"width": "Thickness", "depth": "Width"},
    "foot": {"length": "Height", "depth": "Length"},
}
_BOX_AXES = {"width": 0, "length": 1, "depth": 2}


@dataclass(frozen=True)
class Size:
    """One size of a part, centimetres; min and max are what a slider should span.

    Keys: length; radius, start_radius, end_radius of round parts; start_width, start_depth,
    end_width, end_depth, whole, of parts that are not round; width, depth of boxes.
    """

    key: str
    label: str
    cm: float
    min: float
    max: float


def part_sizes(body: Body, part: str) -> tuple[Size, ...]:
    """All sizes of a part."""
    found = body.parts[body.index(part)]
    values = _values(found.shape)
    return tuple(
        Size(key, _label(kind_of(part), found.shape, key), 100 * metres, *_span(100 * metres))
        for key, metres in values.items()
    )


def with_size(body: Body, part: str, key: str, cm: float, *, linked: bool = True) -> Body:
    """The body with one size of a part changed, on both sides if linked.

    What hangs on the part and its landmarks go with the surface: a longer thigh carries the shin
    along, broader shoulders the arms.
    """
    shape = body.parts[body.index(part)].shape
    values = _values(shape)
    if key not in values:
        raise BodyError(f"Part {part!r} has no size {key!r}; its sizes are {', '.join(values)}.")
    _demand_between("size", cm, SMALLEST_CM, LARGEST_CM)
    changed = _with_value(shape, key, cm / 100)
    names = {part, body.mirror_of(part)} if linked else {part}

    def change(given: Part) -> Part:
        update: dict[str, object] = {}
        if given.name in names:
            here = given.shape if given.name != part else shape
            new = changed if given.name == part else _with_value(here, key, cm / 100)
            carry = _carrier(here, new)
            update = {"shape": new, "landmarks": {k: carry(p) for k, p in given.landmarks.items()}}
        if given.parent in names:
            parent = body.parts[body.index(given.parent)].shape
            update["joint_m"] = _carrier(parent, _with_value(parent, key, cm / 100))(given.joint_m)
        return given.model_copy(update=update) if update else given

    return _validated(body, tuple(map(change, body.parts)))


def with_joint(
    body: Body, part: str, joint_cm: tuple[float, float, float], *, linked: bool = True
) -> Body:
    """The part hung elsewhere on its parent, centimetres in the parent's frame.

    The other side follows, mirrored, if linked.
    """
    for value in joint_cm:
        _demand_between("joint's place", value, -LARGEST_CM, LARGEST_CM)
    x, y, z = (value / 100 for value in joint_cm)
    return scaling.joint_moved(body, part, (x, y, z), linked=linked)


def with_height(body: Body, cm: float) -> Body:
    """The whole body scaled to a height in the rest pose."""
    _demand_between("height", cm, LOWEST_CM, HIGHEST_CM)
    return scaling.with_height(body, cm / 100)


def _demand_between(what: str, cm: float, low: float, high: float) -> None:
    if not (math.isfinite(cm) and low <= cm <= high):
        raise BodyError(f"The {what} must lie between {low:g} and {high:g} cm.")


def _span(cm: float) -> tuple[float, float]:
    """What a slider spans: steady while the size changes a little."""
    high = next((step for step in _LADDER if step >= 1.6 * cm), LARGEST_CM)
    return max(SMALLEST_CM, high / 100), high


def _label(kind: str, shape: Shape, key: str) -> str:
    if isinstance(shape, Box):
        return _BOX_LABELS.get(kind, {}).get(key, key.capitalize())
    if key in ("length", "radius"):
        return key.capitalize()
    start, end = _ENDS.get(kind, ("joint", "end"))
    place = start if key.startswith("start") else end
    kind_of_size = key.split("_")[1]
    return f"At {place}" if kind_of_size == "radius" else f"{kind_of_size.capitalize()} at {place}"


def _values(shape: Shape) -> dict[str, float]:
    """Every size in metres, by key."""
    if isinstance(shape, Box):
        spans = [high - low for low, high in zip(shape.low_m, shape.high_m, strict=True)]
        return {key: spans[_BOX_AXES[key]] for key in ("length", "width", "depth")}
    length = {"length": abs(shape.end_m - shape.start_m)}
    if isinstance(shape, Cylinder):
        return {**length, "radius": shape.radius_m}
    start, end = shape.start_radii_m, shape.end_radii_m
    if start[0] == start[1] and end[0] == end[1]:
        return {**length, "start_radius": start[0], "end_radius": end[0]}
    return {
        **length,
        "start_width": 2 * start[0],
        "start_depth": 2 * start[1],
        "end_width": 2 * end[0],
        "end_depth": 2 * end[1],
    }


def _with_value(shape: Shape, key: str, metres: float) -> Shape:
    """The shape with one size exchanged; the part's joint keeps its share of the length."""
    ratio = metres / _values(shape)[key]
    if isinstance(shape, Box):
        k = _BOX_AXES[key]
        low, high = list(shape.low_m), list(shape.high_m)
        low[k], high[k] = low[k] * ratio, high[k] * ratio
        return shape.model_copy(update={"low_m": tuple(low), "high_m": tuple(high)})
    if key == "length":
        update = {"start_m": shape.start_m * ratio, "end_m": shape.end_m * ratio}
        return shape.model_copy(update=update)
    if isinstance(shape, Cylinder):
        return shape.model_copy(update={"radius_m": metres})
    return shape.model_copy(update=_radii(shape, key, metres))


def _radii(shape: Frustum, key: str, metres: float) -> dict[str, tuple[float, float]]:
    end, what = key.split("_")
    field = f"{end}_radii_m"
    x, z = getattr(shape, field)
    new = {"radius": (metres, metres), "width": (metres / 2, z), "depth": (x, metres / 2)}[what]
    return {field: new}


def _carrier(before: Shape, after: Shape) -> Callable[[Point], Point]:
    """How a point in a part goes along with its surface."""

    def carried(point: Point) -> Point:
        x, y, z = point
        along = _length(after) / _length(before)
        wide = [_half(after, y * along, k) / _half(before, y, k) for k in (0, 1)]
        return x * wide[0], y * along, z * wide[1]

    return carried


def _length(shape: Shape) -> float:
    return _values(shape)["length"]


def _half(shape: Shape, y: float, k: int) -> float:
    """Half the width (k = 0, along x) or depth (1, along z) at a height of the part."""
    if isinstance(shape, Box):
        return (shape.high_m[2 * k] - shape.low_m[2 * k]) / 2
    if isinstance(shape, Cylinder):
        return shape.radius_m
    share = (y - shape.start_m) / (shape.end_m - shape.start_m)
    share = min(max(share, 0.0), 1.0)
    return (1 - share) * shape.start_radii_m[k] + share * shape.end_radii_m[k]


def _validated(body: Body, parts: tuple[Part, ...]) -> Body:
    # model_copy does not validate, so the whole body is read again: sizes have bounds.
    try:
        return Body.model_validate({**body.model_dump(), "parts": [p.model_dump() for p in parts]})
    except ValidationError as error:
        raise BodyError(f"This size is not possible: {one_sentence(error)}") from None
