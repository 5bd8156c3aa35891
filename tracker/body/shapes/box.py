"""A box."""

from __future__ import annotations

from typing import Literal, Self

import numpy as np
from pydantic import model_validator

from keypose.tracker.body.shapes.geometry import Length, Mesh, Point, Wireframe
from keypose.tracker.body.shapes.solid import ShapeSize, Solid, distance_from_excess
from keypose.tracker.geometry.rotations import Array

_AXES = {"length": 1, "width": 0, "depth": 2}

_CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
_EDGES = np.array([(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit])
_FACES = np.array([
    *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)),
    *((2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
])  # fmt: skip


class CorneredSolid(Solid):
    """A solid that fills the space between two opposite corners, from side to side along the
    part's axes."""

    low_m: tuple[Length, Length, Length]
    high_m: tuple[Length, Length, Length]

    @model_validator(mode="after")
    def _has_a_volume(self) -> Self:
        for axis, low, high in zip("xyz", self.low_m, self.high_m, strict=True):
            if high - low < 1e-6:
                raise ValueError(f"high_m must be larger than low_m along {axis}")
        return self

    @classmethod
    def like(cls, solid: Solid) -> Self:
        ends = np.array([solid.half_widths(y) for y in solid.span_y])
        half = np.array([ends[:, 0].mean(), solid.length_m / 2, ends[:, 1].mean()])
        low, high = solid.centre - half, solid.centre + half
        return cls.model_validate({"low_m": low.tolist(), "high_m": high.tolist()})

    @property
    def centre(self) -> Point:
        (x0, y0, z0), (x1, y1, z1) = self.low_m, self.high_m
        return ((x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2)

    @property
    def far_end(self) -> Point:
        """The middle of the side that is farthest from the joint."""
        low, high = np.array(self.low_m), np.array(self.high_m)
        reach = np.where(np.abs(high) >= np.abs(low), high, low)
        longest = int(np.argmax(np.abs(reach)))
        end = (low + high) / 2
        end[longest] = reach[longest]
        x, y, z = (float(value) for value in end)
        return (x, y, z)

    @property
    def length_m(self) -> float:
        return self.high_m[1] - self.low_m[1]

    @property
    def width_m(self) -> float:
        return (self.high_m[0] - self.low_m[0] + self.high_m[2] - self.low_m[2]) / 2

    def half_widths(self, y: float) -> tuple[float, float]:
        return (self.high_m[0] - self.low_m[0]) / 2, (self.high_m[2] - self.low_m[2]) / 2

    def sizes(self) -> tuple[ShapeSize, ...]:
        return tuple(
            ShapeSize(key, self.high_m[k] - self.low_m[k], self._handle(k))
            for key, k in _AXES.items()
        )

    def with_size(self, key: str, metres: float) -> Self:
        k = _AXES[key]
        low, high = list(self.low_m), list(self.high_m)
        ratio = metres / (high[k] - low[k])
        low[k], high[k] = low[k] * ratio, high[k] * ratio
        return self.model_copy(update={"low_m": tuple(low), "high_m": tuple(high)})

    def scaled(self, along: float, across: float) -> Self:
        low, high = ((x * across, y * along, z * across) for x, y, z in (self.low_m, self.high_m))
        return self.model_copy(update={"low_m": low, "high_m": high})

    def _handle(self, k: int) -> Point:
        """The middle of a side; of depth, of the one that reaches farther from the joint."""
        x, y, z = self.centre
        if k == 0:
            return (self.high_m[0], y, z)
        if k == 1:
            return (x, self.high_m[1], z)
        return (x, y, self.low_m[2] if -self.low_m[2] > self.high_m[2] else self.high_m[2])


class Box(CorneredSolid):
    """A box between two opposite corners, its edges along the part's axes."""

    kind: Literal["box"] = "box"

    def mesh(self) -> Mesh:
        return Mesh.convex(self._corners(0.0), _FACES, np.arange(len(_FACES)) // 2)

    def wireframe(self, lift_m: float = 0.0) -> Wireframe:
        return Wireframe.straight(self._corners(lift_m)[_EDGES])

    def distance(self, p_part: Array) -> Array:
        low, high = np.array(self.low_m), np.array(self.high_m)
        return distance_from_excess(np.maximum(low - p_part, p_part - high))

    def corners(self) -> Array:
        """All eight, x slowest and z fastest."""
        return self.mesh().vertices

    def marks(self) -> Array:
        """Its corners."""
        return self.corners()

    def _corners(self, lift_m: float) -> Array:
        low, high = np.array(self.low_m) - lift_m, np.array(self.high_m) + lift_m
        return np.asarray(low + _CORNERS * (high - low))
