"""A round cylinder."""

from __future__ import annotations

from typing import Literal, Self

from keypose.tracker.body.shapes.numbers import Size
from keypose.tracker.body.shapes.round import OneRadius, Radii, RoundSolid
from keypose.tracker.body.shapes.solid import Solid


class Cylinder(OneRadius, RoundSolid):
    """A round cylinder from y = start_m to y = end_m."""

    kind: Literal["cylinder"] = "cylinder"
    radius_m: Size

    @property
    def ends(self) -> tuple[Radii, Radii]:
        return (self.radius_m, self.radius_m), (self.radius_m, self.radius_m)

    @classmethod
    def like(cls, other: Solid) -> Self:
        start, end = other.span_y
        return cls(start_m=start, end_m=end, radius_m=other.width_m / 2)
