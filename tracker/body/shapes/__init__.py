"""Define the solid shapes a part may have, in the part's own frame.

Lengths in metres.

Each shape is one file with everything the program needs of it (`Solid`). A new shape is a new file,
plus its name in `Shape`, from which session files and the page know it.
"""

from __future__ import annotations

from typing import Annotated, TypeAlias, get_args

from pydantic import Field

from keypose.tracker.body.shapes.box import Box
from keypose.tracker.body.shapes.capsule import Capsule
from keypose.tracker.body.shapes.disc import Disc
from keypose.tracker.body.shapes.frustum import Frustum
from keypose.tracker.body.shapes.geometry import SIDES, Length, Mesh, Point, Size, Wireframe
from keypose.tracker.body.shapes.round import Cylinder
from keypose.tracker.body.shapes.solid import ShapeSize, Solid

Shape: TypeAlias = Annotated[Cylinder | Capsule | Frustum | Box | Disc, Field(discriminator="kind")]

KINDS: dict[str, type[Shape]] = {
    solid.model_fields["kind"].default: solid for solid in get_args(get_args(Shape)[0])
}
"""The shapes by what files call them."""

__all__ = [
    "KINDS",
    "SIDES",
    "Box",
    "Capsule",
    "Cylinder",
    "Disc",
    "Frustum",
    "Length",
    "Mesh",
    "Point",
    "Shape",
    "ShapeSize",
    "Size",
    "Solid",
    "Wireframe",
]
