"""The solid shapes a part may have, in the part's own frame. Lengths in metres.

One file a shape, which holds all that the program asks of it (`Solid`). Another shape is one more
file, and its name in `Shape`.
"""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Field

from tracker.body.shapes.box import Box
from tracker.body.shapes.cylinder import Cylinder
from tracker.body.shapes.frustum import Frustum
from tracker.body.shapes.mesh import Mesh
from tracker.body.shapes.numbers import Length, Point, Size
from tracker.body.shapes.solid import ShapeSize, Solid
from tracker.body.shapes.wireframe import SIDES, Wireframe

Shape: TypeAlias = Annotated[Cylinder | Frustum | Box, Field(discriminator="kind")]

__all__ = [
    "SIDES",
    "Box",
    "Cylinder",
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
