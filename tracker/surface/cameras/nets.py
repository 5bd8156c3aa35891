"""From a field of depths on a grid to the triangles where it is zero.

Surface nets: the dual of marching cubes, a vertex in every cell that the surface passes through and
a quad about every edge of the grid that it crosses. Its triangles are of nearly one size, which is
what surface fitting wants, and it needs no tables of cases.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.mesh import SurfaceMesh

CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
_EDGES = [
    (a, b) for a in range(8) for b in range(a, 8) if np.abs(CORNERS[a] - CORNERS[b]).sum() == 1
]


@dataclass(frozen=True, eq=False)
class Field:
    """How deep the points of a grid lie within a thing, metres; negative outside.

    depths: (I, J, K) float32, at p_origin + voxel_m · (i, j, k).
    """

    p_origin: Array
    voxel_m: float
    depths: NDArray[np.float32]


def surface_of(field: Field) -> SurfaceMesh:
    """The triangles where the depth is zero, outward; closed where the grid's rim is outside."""
    inside = field.depths > 0
    cells = _mixed_cells(inside)
    vertices = field.p_origin + field.voxel_m * _vertices(field.depths, cells)
    quads = np.concatenate([_quads(inside, axis) for axis in range(3)])
    keys = np.ravel_multi_index(tuple(cells.T), inside.shape)
    corners = np.searchsorted(
        keys, np.ravel_multi_index(tuple(np.moveaxis(quads, -1, 0)), inside.shape)
    )
    return SurfaceMesh(vertices, _triangles(vertices, corners))


def _mixed_cells(inside: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(M, 3) the cells with corners on both sides, in the order of their places in memory."""
    count = np.zeros(tuple(n - 1 for n in inside.shape), np.uint8)
    for x, y, z in CORNERS:
        count += inside[_cell_corner(x), _cell_corner(y), _cell_corner(z)]
    return np.argwhere((count > 0) & (count < 8))


def _cell_corner(by: int) -> slice:
    return slice(1, None) if by else slice(None, -1)


def _vertices(depths: NDArray[np.float32], cells: NDArray[np.int64]) -> Array:
    """(M, 3) the middle of the places where the surface crosses a cell's edges, in voxels."""
    at = cells[:, None] + CORNERS
    values = depths[at[..., 0], at[..., 1], at[..., 2]].astype(np.float64)
    total, count = np.zeros((len(cells), 3)), np.zeros(len(cells))
    for a, b in _EDGES:
        crossed = (values[:, a] > 0) != (values[:, b] > 0)
        share = values[crossed, a] / (values[crossed, a] - values[crossed, b])
        total[crossed] += CORNERS[a] + share[:, None] * (CORNERS[b] - CORNERS[a])
        count[crossed] += 1
    return np.asarray(cells + total / count[:, None])


def _quads(inside: NDArray[np.bool_], axis: int) -> NDArray[np.int64]:
    """(Q, 4, 3) the cells about the edges along an axis that the surface crosses, outward."""
    low = np.moveaxis(inside, axis, 0)[:-1]
    high = np.moveaxis(inside, axis, 0)[1:]
    edges = np.argwhere((low != high)[:, 1:-1, 1:-1]) + np.array([0, 1, 1])
    leaving = low[tuple(edges.T)]  # outside lies ahead along the axis
    around = np.array([(0, -1, -1), (0, 0, -1), (0, 0, 0), (0, -1, 0)])
    quads = edges[:, None] + around
    quads = np.where(leaving[:, None, None], quads, quads[:, ::-1])
    # moveaxis by one keeps the handedness of x, y, z for axes 0 and 2 and turns it for axis 1.
    if axis == 1:
        quads = quads[:, ::-1]
    order = np.argsort([axis, *(other for other in range(3) if other != axis)])
    return np.asarray(quads[..., order])


def _triangles(vertices: Array, quads: NDArray[np.int64]) -> NDArray[np.int64]:
    """(2 Q, 3) each quad cut along its shorter diagonal."""
    a, b, c, d = (vertices[quads[:, k]] for k in range(4))
    along_first = ((a - c) ** 2).sum(axis=1) <= ((b - d) ** 2).sum(axis=1)
    first = quads[:, [0, 1, 2, 0, 2, 3]]
    second = quads[:, [0, 1, 3, 1, 2, 3]]
    return np.where(along_first[:, None], first, second).reshape(-1, 3)
