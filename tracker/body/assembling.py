"""Parts added to a body, taken from it, and renamed."""

from __future__ import annotations

from keypose.tracker.body.body import ROTATIONS, Body, Part
from keypose.tracker.body.shapes import Cylinder
from keypose.tracker.errors import BodyError

THINNER = 0.7
"""Width of a new part over that of the part it hangs on."""


def with_new_part(body: Body, parent: str, name: str) -> Body:
    """The body with one more part: a cylinder in line with its parent, from the parent's far end
    on, as long and thinner. It turns in every way, and so it is tracked.

    BodyError where there is no such parent, or the name is taken.
    """
    _require_new(body, name)
    given = body.parts[body.index(parent)]
    start, end = given.shape.span_y
    shape = Cylinder(
        start_m=0.0,
        end_m=end - start,
        radius_m=THINNER * given.shape.width_m / 2,
    )
    new = Part(name=name, parent=parent, joint_m=(0.0, end, 0.0), shape=shape, tracked=ROTATIONS)
    return body.replaced((*body.parts, new))


def without_part(body: Body, name: str) -> Body:
    """The body without a part and all that hangs on it.

    BodyError where there is no such part, and where none would be left.
    """
    gone = {body.parts[body.index(name)].name}
    for part in body.parts:
        if part.parent in gone:
            gone.add(part.name)
    left = tuple(part for part in body.parts if part.name not in gone)
    if not left:
        raise BodyError("A body needs one part at least.")
    pairs = tuple(pair for pair in body.mirror_pairs if not gone & set(pair))
    return Body(**{**dict(body), "parts": left, "mirror_pairs": pairs})


def with_renamed_part(body: Body, old: str, new: str) -> Body:
    """The body with another name of a part; BodyError where there is none, or the name is taken."""
    body.index(old)
    _require_new(body, new)

    def named(name: str | None) -> str | None:
        return new if name == old else name

    parts = [
        part.model_copy(update={"name": named(part.name), "parent": named(part.parent)})
        for part in body.parts
    ]
    pairs = [[named(name) for name in pair] for pair in body.mirror_pairs]
    return Body.model_validate({**dict(body), "parts": parts, "mirror_pairs": pairs})


def _require_new(body: Body, name: str) -> None:
    if name in body.names:
        raise BodyError(f"There is a part {name!r} already; every part needs a name of its own.")
