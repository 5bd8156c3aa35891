"""The solid shapes a part may have, in the part's own frame: cylinder, frustum, box.

Round shapes stand along the part's y axis. Lengths in metres.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, model_validator

from tracker.geometry.rotations import Array, frozen

Size: TypeAlias = Annotated[FiniteFloat, Field(ge=1e-6, le=100)]
Length: TypeAlias = Annotated[FiniteFloat, Field(ge=-100, le=100)]

SIDES = 24
"""Sides of the polygon that stands for a round cross-section."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed triangle mesh, counter-clockwise seen from outside (right-handed).

    vertices: (V, 3) metres.  faces: (F, 3) vertex indices.
    """

    vertices: Array
    faces: NDArray[np.int64]


class _Frozen(BaseModel):
    model_config = ConfigDict(frozen=True, extra="allow")


class Cylinder(_Frozen):
    """A round cylinder from y = start_m to y = end_m."""

    kind: Literal["cylinder"] = "cylinder"
    start_m: Length = 0.0
    end_m: Length
    radius_m: Size

    @model_validator(mode="after")
    def _has_a_length(self) -> Self:
        _demand_length(self.start_m, self.end_m)
        return self

    def mesh(self) -> Mesh:
        radii = (self.radius_m, self.radius_m)
        return _frustum_mesh(self.start_m, self.end_m, radii, radii)

    def marks(self) -> Array:
        """Points (N, 3) by which a motion of the shape can be told."""
        radii = (self.radius_m, self.radius_m)
        return _frustum_marks(self.start_m, self.end_m, radii, radii)


class Frustum(_Frozen):
    """A cone cut off at both ends, with elliptic cross-sections (a chest is not round).

    The half-axes are given along the part's x and z, at y = start_m and at y = end_m.
    """

    kind: Literal["frustum"] = "frustum"
    start_m: Length = 0.0
    end_m: Length
    start_radii_m: tuple[Size, Size]
    end_radii_m: tuple[Size, Size]

    @model_validator(mode="after")
    def _has_a_length(self) -> Self:
        _demand_length(self.start_m, self.end_m)
        return self

    def mesh(self) -> Mesh:
        return _frustum_mesh(self.start_m, self.end_m, self.start_radii_m, self.end_radii_m)

    def marks(self) -> Array:
        """Points (N, 3) by which a motion of the shape can be told."""
        return _frustum_marks(self.start_m, self.end_m, self.start_radii_m, self.end_radii_m)


class Box(_Frozen):
    """A box between two opposite corners, its edges along the part's axes."""

    kind: Literal["box"] = "box"
    low_m: tuple[Length, Length, Length]
    high_m: tuple[Length, Length, Length]

    @model_validator(mode="after")
    def _has_a_volume(self) -> Self:
        for axis, low, high in zip("xyz", self.low_m, self.high_m, strict=True):
            if high - low < 1e-6:
                raise ValueError(f"high_m must be larger than low_m along {axis}")
        return self

    def mesh(self) -> Mesh:
        corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
        low, high = np.array(self.low_m), np.array(self.high_m)
        return _outward(low + np.array(corners) * (high - low), np.array(_BOX_FACES))

    def marks(self) -> Array:
        """Points (N, 3) by which a motion of the shape can be told: its corners."""
        return self.mesh().vertices


Shape: TypeAlias = Annotated[Cylinder | Frustum | Box, Field(discriminator="kind")]

_BOX_FACES = [
    *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)),
    *((2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
]


def _demand_length(start: float, end: float) -> None:
    if abs(end - start) < 1e-6:
        raise ValueError("end_m must differ from start_m")


def _frustum_mesh(
    start: float, end: float, start_radii: tuple[float, float], end_radii: tuple[float, float]
) -> Mesh:
    turn = np.arange(SIDES) * (2 * np.pi / SIDES)
    rings = [
        np.column_stack([rx * np.cos(turn), np.full(SIDES, y), rz * np.sin(turn)])
        for y, (rx, rz) in ((start, start_radii), (end, end_radii))
    ]
    vertices = np.vstack([*rings, [[0.0, start, 0.0], [0.0, end, 0.0]]])
    faces = []
    for i in range(SIDES):
        k = (i + 1) % SIDES
        faces += [(i, k, SIDES + i), (k, SIDES + k, SIDES + i)]
        faces += [(2 * SIDES, k, i), (2 * SIDES + 1, SIDES + i, SIDES + k)]
    return _outward(vertices, np.array(faces))


def _frustum_marks(
    start: float, end: float, start_radii: tuple[float, float], end_radii: tuple[float, float]
) -> Array:
    """The middles of both ends; of a shape as wide as it is long also the rims.

    A rim of a slender limb would also tell its turn about its own length, which no picture shows.
    """
    ends = ((start, start_radii), (end, end_radii))
    marks = [(0.0, y, 0.0) for y, _ in ends]
    if 2 * max(*start_radii, *end_radii) >= abs(end - start):
        for y, (rx, rz) in ends:
            marks += [(rx, y, 0.0), (-rx, y, 0.0), (0.0, y, rz), (0.0, y, -rz)]
    return frozen(marks)


def _outward(vertices: Array, faces: NDArray[np.int64]) -> Mesh:
    """Turn every face so that its normal points away from the (convex) shape's middle."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    outside = np.einsum("fi,fi->f", np.cross(b - a, c - a), (a + b + c) / 3 - vertices.mean(0))
    turned = np.where((outside < 0)[:, None], faces[:, ::-1], faces).astype(np.int64)
    turned.setflags(write=False)
    return Mesh(frozen(vertices), turned)
