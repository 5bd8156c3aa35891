"""Describe a shape's surface as a triangle mesh and as lines; its numbers are metres."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, FiniteFloat

from keypose.tracker.geometry.rotations import Array, frozen

Size: TypeAlias = Annotated[FiniteFloat, Field(ge=1e-6, le=100)]
Length: TypeAlias = Annotated[FiniteFloat, Field(ge=-100, le=100)]
Point: TypeAlias = tuple[Length, Length, Length]


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed triangle mesh, counter-clockwise seen from outside (right-handed).

    vertices: (V, 3) metres.
    faces:    (F, 3) vertex indices.
    sides:    (F,) the side that a face belongs to: smooth within one, creased between two.
    """

    vertices: Array
    faces: NDArray[np.int64]
    sides: NDArray[np.int64]

    @classmethod
    def convex(cls, vertices: Array, faces: NDArray[np.int64], sides: NDArray[np.int64]) -> Mesh:
        """The mesh of a convex solid, every face turned so that its normal points outward."""
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        outside = np.einsum("fi,fi->f", np.cross(b - a, c - a), (a + b + c) / 3 - vertices.mean(0))
        turned = np.where((outside < 0)[:, None], faces[:, ::-1], faces).astype(np.int64)
        sides = np.array(sides, dtype=np.int64)
        turned.setflags(write=False)
        sides.setflags(write=False)
        return cls(frozen(vertices), turned, sides)


SIDES = 24
"""Sides of the polygon that stands for a round cross-section."""

_TURN = np.arange(SIDES) * (2 * np.pi / SIDES)


@dataclass(frozen=True, eq=False)
class Wireframe:
    """The lines of a solid, from which every view picks what it shows.

    creases: (N, 2, 3) the ends of the edges at which the surface is not smooth.
    rings:   (R, SIDES, 3) points around a round side, from one end of it to the other; neighbours
             in the list bound a strip of that side, and where such a strip turns from the viewer
             its outline runs. None of them where nothing is round.
    """

    creases: Array
    rings: Array

    @classmethod
    def straight(cls, creases: Array) -> Wireframe:
        """The lines of a solid with edges and no round side."""
        return cls(frozen(creases), frozen(np.zeros((0, SIDES, 3))))

    @classmethod
    def rimmed(cls, rings: Array) -> Wireframe:
        """The lines of a round side whose first and last ring are rims."""
        rims = rings[[0, -1]]
        creases = np.stack([rims, np.roll(rims, -1, axis=1)], axis=2)
        return cls(frozen(creases.reshape(-1, 2, 3)), frozen(rings))


def ring(y: float, radius_x: float, radius_z: float) -> Array:
    """(SIDES, 3) points of an ellipse about the y axis, at height y."""
    return np.column_stack([radius_x * np.cos(_TURN), np.full(SIDES, y), radius_z * np.sin(_TURN)])
