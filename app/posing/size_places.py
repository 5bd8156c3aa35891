"""Where the handles of a part's sizes stand on it."""

from __future__ import annotations

from tracker.body.body import Point
from tracker.body.shapes import Box, Cylinder, Shape
from tracker.errors import BodyError


def size_place(shape: Shape, key: str) -> Point:
    """The point of a size's handle, metres in the part's frame, on the part's surface.

    A radius is the same all around, so its point is the one on the part's line that it is
    measured from. Keys are those of `part_sizes`.
    """
    if isinstance(shape, Box):
        return _on_box(shape, key)
    ends = {"start": shape.start_m, "end": shape.end_m}
    side, _, what = key.rpartition("_")
    y = ends.get(side, (shape.start_m + shape.end_m) / 2)
    if what == "length":
        return (0.0, shape.end_m, 0.0)
    if what == "radius":
        return (0.0, y, 0.0)
    if isinstance(shape, Cylinder):
        raise BodyError(f"A cylinder has no size {key!r}.")
    x, z = shape.start_radii_m if side == "start" else shape.end_radii_m
    return (x, y, 0.0) if what == "width" else (0.0, y, -z)


def _on_box(box: Box, key: str) -> Point:
    """The middle of the face that stands farther from the joint."""
    middle = [(low + high) / 2 for low, high in zip(box.low_m, box.high_m, strict=True)]
    k = {"width": 0, "length": 1, "depth": 2}[key]
    far = box.high_m[k]
    if k == 2 and -box.low_m[k] > far:
        far = box.low_m[k]
    middle[k] = far
    return (middle[0], middle[1], middle[2])
