"""Shapes of revolution about the y axis, and those with flat ends: the cylinder among them."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Literal, Self, TypeAlias

import numpy as np
from pydantic import model_validator

from keypose.tracker.body.shapes.geometry import SIDES, Length, Mesh, Point, Size, Wireframe, ring
from keypose.tracker.body.shapes.solid import ShapeSize, Solid, distance_from_excess
from keypose.tracker.geometry.rotations import Array, frozen

Radii: TypeAlias = tuple[float, float]
"""Half-axes of a cross-section along x and z."""


class UprightSolid(Solid):
    """A solid about the y axis from y = start_m to y = end_m."""

    start_m: Length = 0.0
    end_m: Length

    @model_validator(mode="after")
    def _has_a_length(self) -> Self:
        if abs(self.end_m - self.start_m) < 1e-6:
            raise ValueError("end_m must differ from start_m")
        return self

    @property
    def centre(self) -> Point:
        return (0.0, (self.start_m + self.end_m) / 2, 0.0)

    @property
    def far_end(self) -> Point:
        return (0.0, max(self.start_m, self.end_m, key=abs), 0.0)

    @property
    def length_m(self) -> float:
        return abs(self.end_m - self.start_m)

    @property
    def span_y(self) -> tuple[float, float]:
        return self.start_m, self.end_m

    def longer(self, ratio: float) -> Self:
        """Times a ratio along y, unvalidated."""
        update = {"start_m": self.start_m * ratio, "end_m": self.end_m * ratio}
        return self.model_copy(update=update)

    def _face(self, rx: float, rz: float) -> dict[str, Point]:
        """The points of a face on a head with these half-axes."""

        def at(share: float, x: float, z: float) -> Point:
            return (x * rx, self.start_m + share * (self.end_m - self.start_m), -z * rz)

        face = {"nose": at(0.4, 0.0, 1.15)}
        for side, sign in (("left", 1.0), ("right", -1.0)):
            face[f"{side}_eye"] = at(0.55, 0.45 * sign, 0.9)
            face[f"{side}_ear"] = at(0.5, sign, 0.0)
        return face


class OneRadius(UprightSolid):
    """A length and a radius, equally thick all along. A subclass declares the radius itself: that
    keeps the order of its fields in files."""

    if TYPE_CHECKING:
        radius_m: float

    @property
    def width_m(self) -> float:
        return 2 * self.radius_m

    def half_widths(self, y: float) -> tuple[float, float]:
        return self.radius_m, self.radius_m

    def sizes(self) -> tuple[ShapeSize, ...]:
        return (
            ShapeSize("length", self.length_m, (0.0, self.end_m, 0.0)),
            ShapeSize("radius", self.radius_m, self.centre),
        )

    def with_size(self, key: str, metres: float) -> Self:
        if key == "length":
            return self.longer(metres / self.length_m)
        return self.model_copy(update={"radius_m": metres})

    def scaled(self, along: float, across: float) -> Self:
        return self.longer(along).model_copy(update={"radius_m": self.radius_m * across})


class RoundSolid(UprightSolid):
    """A solid with elliptic cross-sections and flat ends."""

    @property
    @abstractmethod
    def ends(self) -> tuple[Radii, Radii]:
        """The cross-sections at the start and at the end."""

    def mesh(self) -> Mesh:
        start, end = self.ends
        middles = [[0.0, self.start_m, 0.0], [0.0, self.end_m, 0.0]]
        rings = [ring(self.start_m, *start), ring(self.end_m, *end)]
        faces, sides = [], []
        for i in range(SIDES):
            k = (i + 1) % SIDES
            faces += [(i, k, SIDES + i), (k, SIDES + k, SIDES + i)]
            faces += [(2 * SIDES, k, i), (2 * SIDES + 1, SIDES + i, SIDES + k)]
            sides += [0, 0, 1, 2]
        return Mesh.convex(np.vstack([*rings, middles]), np.array(faces), np.array(sides))

    def wireframe(self, lift_m: float = 0.0) -> Wireframe:
        lift_y = np.sign(self.start_m - self.end_m) * lift_m
        ys = (self.start_m + lift_y, self.end_m - lift_y)
        rings = [ring(y, x + lift_m, z + lift_m) for y, (x, z) in zip(ys, self.ends, strict=True)]
        return Wireframe.rimmed(np.stack(rings))

    def distance(self, p_part: Array) -> Array:
        """(N,) metres from points (N, 3) to the surface, negative inside; of an ellipse to first
        order."""
        radii = np.array(self.ends)
        lowest, highest = sorted((self.start_m, self.end_m))
        along = np.clip((p_part[:, 1] - self.start_m) / (self.end_m - self.start_m), 0.0, 1.0)
        here = radii[0] + along[:, None] * (radii[1] - radii[0])
        reach = np.linalg.norm(p_part[:, [0, 2]] / here, axis=1)
        side = (reach - 1.0) * here.mean(axis=1)
        beyond = np.maximum(lowest - p_part[:, 1], p_part[:, 1] - highest)
        return distance_from_excess(np.stack([side, beyond], axis=1))

    def marks(self) -> Array:
        """The middles of both ends; of a shape as wide as it is long also the rims.

        The rim of a slender limb would also move when it turns about its own length, which no
        picture shows.
        """
        start, end = self.ends
        marks = [(0.0, self.start_m, 0.0), (0.0, self.end_m, 0.0)]
        if 2 * max(*start, *end) >= self.length_m:
            for y, (rx, rz) in ((self.start_m, start), (self.end_m, end)):
                marks += [(rx, y, 0.0), (-rx, y, 0.0), (0.0, y, rz), (0.0, y, -rz)]
        return frozen(marks)


class Cylinder(OneRadius, RoundSolid):
    """A round cylinder from y = start_m to y = end_m."""

    kind: Literal["cylinder"] = "cylinder"
    radius_m: Size

    @property
    def ends(self) -> tuple[Radii, Radii]:
        return (self.radius_m, self.radius_m), (self.radius_m, self.radius_m)

    @classmethod
    def like(cls, solid: Solid) -> Self:
        start, end = solid.span_y
        return cls(start_m=start, end_m=end, radius_m=solid.width_m / 2)
