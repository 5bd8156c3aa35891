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

    def flats(self) -> list[tuple[Array, Array]]:
        """The flat sides: the vertices (N, 3) of each, and its outward normal (3,)."""
        corners = self.vertices[self.faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        members = [np.flatnonzero(self.sides == side) for side in np.unique(self.sides)]
        return [
            (self.vertices[np.unique(self.faces[faces])], normals[faces[0]])
            for faces in members
            if np.allclose(normals[faces], normals[faces[0]], atol=FLAT)
        ]


SIDES = 24
"""Sides of the polygon that stands for a round cross-section."""

WIRES = 8
"""Lines along a round side. Lines cost most where the browser has no graphics card."""

TINY = 1e-30
"""A length to divide by in the place of none."""

FLAT = 1e-6
"""By how much the unit normals of a flat side may differ, as rounding makes them."""

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

    def along(self) -> tuple[Array, Array]:
        """Lines (N, 2, 3) along the round side, and the outward normal (N, 3) of the surface under
        each; zeros under a line without a length, where two rings are one."""
        every = SIDES // WIRES
        lines = np.stack([self.rings[:-1], self.rings[1:]], axis=2)
        across = np.roll(self.rings, -1, axis=1) - np.roll(self.rings, 1, axis=1)
        normals = np.cross(across[:-1] + across[1:], lines[:, :, 1] - lines[:, :, 0])
        middle = lines.mean(axis=(1, 2), keepdims=True)[:, :, 0]
        inward = np.einsum("rsi,rsi->rs", normals, lines.mean(axis=2) - middle) < 0
        normals[inward] *= -1
        normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), TINY)
        return lines[:, ::every].reshape(-1, 2, 3), normals[:, ::every].reshape(-1, 3)


def ring(y: float, radius_x: float, radius_z: float) -> Array:
    """(SIDES, 3) points of an ellipse about the y axis, at height y."""
    return np.column_stack([radius_x * np.cos(_TURN), np.full(SIDES, y), radius_z * np.sin(_TURN)])
