"""What every shape provides."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Self

import numpy as np
from pydantic import BaseModel, ConfigDict

from keypose.tracker.body.shapes.geometry import Mesh, Point, Wireframe
from keypose.tracker.geometry.rotations import Array


@dataclass(frozen=True)
class ShapeSize:
    """One size of a shape, and where its handle is.

    key: "length" is along the part's y axis, and every shape has it; "radius", and "width" and
        "depth" along x and z, may say at which end: "start_radius", "end_width".
    p_part: of a radius, which is the same all around, the point that it is measured from.
    """

    key: str
    metres: float
    p_part: Point


class Solid(BaseModel, ABC):
    """A convex solid in its part's frame, whose origin is the joint: plain numbers, frozen.

    A subclass declares its `kind` and its numbers, and implements the methods below.
    """

    model_config = ConfigDict(frozen=True, extra="allow")

    kind: str

    @classmethod
    @abstractmethod
    def like(cls, other: Solid) -> Self:
        """A solid of this kind in the place of another: as long, and as wide on average."""

    @abstractmethod
    def mesh(self) -> Mesh:
        """The surface as triangles."""

    @abstractmethod
    def wireframe(self, lift_m: float = 0.0) -> Wireframe:
        """The surface as lines, `lift_m` off it."""

    @abstractmethod
    def distance(self, p_part: Array) -> Array:
        """(N,) metres from points (N, 3) to the surface, negative inside."""

    @abstractmethod
    def marks(self) -> Array:
        """Points (N, 3) by which motions of the shape are compared."""

    def corners(self) -> Array | None:
        """(8, 3) of a box, x slowest and z fastest; None of what is round."""
        return None

    @property
    @abstractmethod
    def centre(self) -> Point:
        """The middle of the solid."""

    @property
    @abstractmethod
    def far_end(self) -> Point:
        """Where the solid ends on the side away from the joint."""

    @property
    @abstractmethod
    def length_m(self) -> float:
        """How long it is, along y."""

    @property
    def span_y(self) -> tuple[float, float]:
        """Where along y it starts and ends: it ends on the side away from the joint."""
        y, half = self.centre[1], self.length_m / 2
        return (y - half, y + half) if y >= 0 else (y + half, y - half)

    @property
    @abstractmethod
    def width_m(self) -> float:
        """How wide it is on average, across y."""

    @abstractmethod
    def half_widths(self, y: float) -> tuple[float, float]:
        """Half the width and half the depth of its sides at a height, by which attached parts move
        when it is resized. Above 0 everywhere, also beyond its ends."""

    @abstractmethod
    def sizes(self) -> tuple[ShapeSize, ...]:
        """The sizes that a person may change, length first."""

    @abstractmethod
    def with_size(self, key: str, metres: float) -> Self:
        """One of `sizes` exchanged, unvalidated; the joint keeps its share of the length."""

    @abstractmethod
    def scaled(self, along: float, across: float) -> Self:
        """Times one ratio along y and another across it, unvalidated."""

    def face_points(self) -> dict[str, Point]:
        """Nose, eyes and ears, where the shape can be a head; it looks toward −z at rest."""
        return {}


def distance_from_excess(beyond: Array) -> Array:
    """(N,) metres from how far points are beyond each of M pairs of sides (N, M)."""
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    return np.asarray(outside + np.minimum(beyond.max(axis=1), 0.0))
