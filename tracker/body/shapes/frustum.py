"""A cone cut off at both ends."""

from __future__ import annotations

from typing import Literal, Self

import numpy as np

from keypose.tracker.body.shapes.geometry import Point, Size
from keypose.tracker.body.shapes.round import Radii, RoundSolid
from keypose.tracker.body.shapes.solid import ShapeSize, Solid


class Frustum(RoundSolid):
    """A cone cut off at both ends, with elliptic cross-sections (a chest is not round).

    The half-axes are given along the part's x and z, at y = start_m and at y = end_m.
    """

    kind: Literal["frustum"] = "frustum"
    start_radii_m: tuple[Size, Size]
    end_radii_m: tuple[Size, Size]

    @property
    def ends(self) -> tuple[Radii, Radii]:
        return self.start_radii_m, self.end_radii_m

    @property
    def width_m(self) -> float:
        return 2 * float(np.mean([*self.start_radii_m, *self.end_radii_m]))

    def half_widths(self, y: float) -> tuple[float, float]:
        share = (y - self.start_m) / (self.end_m - self.start_m)
        share = min(max(share, 0.0), 1.0)
        (x0, z0), (x1, z1) = self.ends
        return (1 - share) * x0 + share * x1, (1 - share) * z0 + share * z1

    @classmethod
    def like(cls, solid: Solid) -> Self:
        start, end = solid.span_y
        radii = {"start_radii_m": solid.half_widths(start), "end_radii_m": solid.half_widths(end)}
        return cls.model_validate({"start_m": start, "end_m": end, **radii})

    def sizes(self) -> tuple[ShapeSize, ...]:
        length = ShapeSize("length", self.length_m, (0.0, self.end_m, 0.0))
        ends = (("start", self.start_m, *self.ends[0]), ("end", self.end_m, *self.ends[1]))
        if all(x == z for x, z in self.ends):
            return (length, *(ShapeSize(f"{n}_radius", x, (0.0, y, 0.0)) for n, y, x, _ in ends))
        shape_sizes = [length]
        for name, y, x, z in ends:
            shape_sizes.append(ShapeSize(f"{name}_width", 2 * x, (x, y, 0.0)))
            shape_sizes.append(ShapeSize(f"{name}_depth", 2 * z, (0.0, y, -z)))
        return tuple(shape_sizes)

    def with_size(self, key: str, metres: float) -> Self:
        if key == "length":
            return self.longer(metres / self.length_m)
        end, dimension = key.split("_")
        x, z = self.start_radii_m if end == "start" else self.end_radii_m
        half = metres / 2
        new = {"radius": (metres, metres), "width": (half, z), "depth": (x, half)}[dimension]
        return self.model_copy(update={f"{end}_radii_m": new})

    def scaled(self, along: float, across: float) -> Self:
        start, end = ((x * across, z * across) for x, z in self.ends)
        update = {"start_radii_m": start, "end_radii_m": end}
        return self.longer(along).model_copy(update=update)

    def face_points(self) -> dict[str, Point]:
        (x0, z0), (x1, z1) = self.ends
        return self._face((x0 + x1) / 2, (z0 + z1) / 2)
