"""A solid's surface as triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array, frozen


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
