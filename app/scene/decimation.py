"""A surface with fewer triangles, for views that are small and often changed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array

GROWTH = 1.2
"""Of the cells, until there are few enough triangles."""
START = 1.6
"""A first guess of the cells: a triangle in every so much of a cell's area."""


@dataclass(frozen=True, eq=False)
class DecimatedMesh:
    """vertices: (W, 3) metres.  faces: (F, 3).  cell: (V,) the vertex each of before became."""

    vertices: Array
    faces: NDArray[np.int64]
    cell: NDArray[np.int64]

    def means(self, values: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Values (V, K) of the vertices before as those (W, K) of these."""
        columns = (_mean(self.cell, column, len(self.vertices)) for column in values.T)
        return np.rint(np.stack(list(columns), axis=1)).astype(np.uint8)


def decimate(vertices: Array, faces: NDArray[np.int64], most: int) -> DecimatedMesh:
    """At most so many triangles: vertices of one cell of a grid become one, in their middle."""
    if len(faces) <= most:
        return DecimatedMesh(vertices, faces, np.arange(len(vertices)))
    size = np.sqrt(START * 2 * _area(vertices, faces) / most)
    while True:
        made = _in_cells(vertices, faces, size)
        if len(made.faces) <= most:
            return made
        size *= GROWTH


def _in_cells(vertices: Array, faces: NDArray[np.int64], size: float) -> DecimatedMesh:
    places = np.floor((vertices - vertices.min(axis=0)) / size).astype(np.int64)
    across = places.max(axis=0) + 1
    number = (places[:, 0] * across[1] + places[:, 1]) * across[2] + places[:, 2]
    _, cell = np.unique(number, return_inverse=True)
    count = int(cell.max()) + 1
    middles = np.stack([_mean(cell, column, count) for column in vertices.T], axis=1)
    return DecimatedMesh(middles, _without_degenerate(cell[faces]), cell)


def _without_degenerate(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles whose corners are three, each once."""
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return faces[np.sort(first)]


def _mean(cell: NDArray[np.int64], values: NDArray[np.generic], count: int) -> Array:
    members = np.maximum(np.bincount(cell, minlength=count), 1)
    return np.asarray(np.bincount(cell, values, count) / members)


def _area(vertices: Array, faces: NDArray[np.int64]) -> float:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)
