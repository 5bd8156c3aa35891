"""A round cylinder."""

from __future__ import annotations

from typing import Literal, Self

from keypose.tracker.body.shapes.numbers import Size
from keypose.tracker.body.shapes.round import Radii, RoundSolid
from keypose.tracker.body.shapes.solid import ShapeSize, Solid


class Cylinder(RoundSolid):
    """A round cylinder from y = start_m to y = end_m."""

    kind: Literal["cylinder"] = "cylinder"
    radius_m: Size

    @property
    def ends(self) -> tuple[Radii, Radii]:
        return (self.radius_m, self.radius_m), (self.radius_m, self.radius_m)

    @property
    def width_m(self) -> float:
        return 2 * self.radius_m

    def half_widths(self, y: float) -> tuple[float, float]:
        return self.radius_m, self.radius_m

    @classmethod
    def like(cls, other: Solid) -> Self:
        start, end = other.span_y
        return cls(start_m=start, end_m=end, radius_m=other.width_m / 2)

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
