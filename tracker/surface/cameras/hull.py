"""Make visual hulls: the largest thing that all silhouettes allow, as a mesh.

Surface nets: the dual of marching cubes, a vertex in every cell that the surface passes through and
a quad about every edge of the grid that it crosses. Its triangles are of nearly one size, which is
what surface fitting wants, and it needs no tables of cases.

A place outside a picture is neither in nor out for that view: it is unknown. More than half of
the views must show a place for it to belong to the hull.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse

from keypose.tracker.errors import SurfaceError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.carving import judge_cells, measure_cells
from keypose.tracker.surface.cameras.rig import Lenses, View, stack_pictures
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
    order = np.argsort([axis, *(other_axis for other_axis in range(3) if other_axis != axis)])
    return np.asarray(quads[..., order])


def _triangles(vertices: Array, quads: NDArray[np.int64]) -> NDArray[np.int64]:
    """(2 Q, 3) each quad cut along its shorter diagonal."""
    a, b, c, d = (vertices[quads[:, k]] for k in range(4))
    along_first = ((a - c) ** 2).sum(axis=1) <= ((b - d) ** 2).sum(axis=1)
    first = quads[:, [0, 1, 2, 0, 2, 3]]
    second = quads[:, [0, 1, 3, 1, 2, 3]]
    return np.where(along_first[:, None], first, second).reshape(-1, 3)


MOST_POINTS = 30_000_000
"""Of a grid: half a gigabyte, with all that is made on the way."""

CELL_COSTS = 32
"""Points that take as much memory as a cell at work."""

CELL = 8
"""Grid points along the side of the smallest cells that are judged as one."""

LIMIT_VOXELS = 3.0
"""Depths are exact up to this many voxels."""

SMOOTHING_VOXELS = 0.7
"""The pixels' steps in the silhouettes' outlines are finer than this."""

SMALLEST_PIECE = 0.02
"""Pieces of less than this share of the largest one are stray."""


@dataclass(frozen=True, eq=False)
class Silhouette:
    """Which pixels (H, W) show the thing; which are known at all (None: every one)."""

    inside: NDArray[np.bool_]
    known: NDArray[np.bool_] | None = None


def hull_field(
    views: Sequence[View],
    silhouettes: Sequence[Silhouette],
    voxel_m: float,
    least_views: int | None = None,
) -> Field:
    """Depth within the hull about the place the views look at.

    SurfaceError where nothing is in all silhouettes, or the grid would be too large.
    """
    least = max(2, len(views) // 2 + 1) if least_views is None else least_views
    if len(views) < least:
        raise SurfaceError(f"A hull needs at least {least} silhouettes: there are {len(views)}.")
    lenses = Lenses.of(views)
    maps = stack_pictures([outline_distances(s) for s in silhouettes], np.nan)
    p_origin, cells = _cells(views, lenses, maps, voxel_m, least)
    limit = LIMIT_VOXELS * voxel_m
    measured = np.empty((len(cells), CELL, CELL, CELL), np.float32)
    measure_cells(
        cells,
        p_origin,
        voxel_m,
        lenses.Ts,
        lenses.lenses,
        lenses.sizes,
        maps,
        least,
        limit,
        measured,
    )
    filled = (measured > 0).reshape(len(cells), -1).sum(axis=1)
    low, high = _bounds(cells, filled)
    _require_affordable(int(np.prod(high - low)), voxel_m)
    depths = np.full(high - low, -limit, np.float32)
    for cell in np.nonzero(((cells >= low) & (cells + CELL <= high)).all(axis=1))[0]:
        i, j, k = cells[cell] - low
        depths[i : i + CELL, j : j + CELL, k : k + CELL] = measured[cell]
    return Field(p_origin + voxel_m * low, voxel_m, depths)


def hull_mesh(field: Field, smoothing_voxels: float = SMOOTHING_VOXELS) -> SurfaceMesh:
    """The surface of a field, smoothed by less than a voxel, without stray pieces."""
    smooth = ndimage.gaussian_filter(field.depths, smoothing_voxels)
    pieces, count = ndimage.label(smooth > 0)
    if not count:
        raise SurfaceError(
            "The hull is thinner than a voxel everywhere: choose smaller voxels, or check the "
            "silhouettes."
        )
    sizes = np.bincount(pieces.ravel(), minlength=count + 1)
    sizes[0] = 0
    stray = np.nonzero(sizes < SMALLEST_PIECE * sizes.max())[0]
    smooth[np.isin(pieces, stray[stray > 0])] = -field.voxel_m
    return surface_of(replace(field, depths=smooth))


def outline_distances(silhouette: Silhouette) -> NDArray[np.float32]:
    """(H, W) distance to the outline in pixels, inside positive; NaN where nothing is known."""
    inside, is_known = silhouette.inside, silhouette.known
    outside = ~inside if is_known is None else is_known & ~inside
    far = float(sum(inside.shape))  # where there is nothing to be near to
    within = _distance_to(outside) if outside.any() else np.full(inside.shape, far, np.float32)
    beyond = _distance_to(inside) if inside.any() else np.full(inside.shape, far, np.float32)
    distances = np.where(inside, within - 0.5, 0.5 - beyond).astype(np.float32)
    if is_known is not None:
        distances[~is_known] = np.nan
    return distances


def _distance_to(mask: NDArray[np.bool_]) -> NDArray[np.float32]:
    free = np.where(mask, np.uint8(0), np.uint8(1))
    return np.asarray(cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE), np.float32)


def _cells(
    views: Sequence[View], lenses: Lenses, maps: NDArray[np.float32], voxel_m: float, least: int
) -> tuple[Array, NDArray[np.int64]]:
    """The grid's origin, and the first points of the cells (N, 3) that may hold some of the hull.

    An octree: cells that surely hold nothing are let go, the others cut into eight.
    """
    p_centre, reach_m = focus_of(views)
    side = CELL * 2 ** int(np.ceil(np.log2(max(2 * reach_m / voxel_m / CELL, 1.0))))
    p_origin, cells = p_centre - voxel_m * side / 2, np.zeros((1, 3), np.int64)
    while True:
        outside = np.empty(len(cells), np.bool_)
        centres = p_origin + voxel_m * (cells + (side - 1) / 2)
        radius = voxel_m * (np.sqrt(3) * side / 2 + LIMIT_VOXELS)
        judge_cells(centres, radius, lenses.Ts, lenses.lenses, lenses.sizes, maps, least, outside)
        cells = cells[~outside]
        if side == CELL:
            _require_affordable(len(cells) * CELL**3, voxel_m)
            return p_origin, cells
        side //= 2
        _require_affordable(8 * len(cells) * CELL_COSTS, voxel_m)
        cells = (cells[:, None] + side * CORNERS).reshape(-1, 3)


def focus_of(views: Sequence[View]) -> tuple[Array, float]:
    """The place (3,) nearest to all optical axes, and how far the farthest view is from it."""
    places = np.stack([view.p_world_view for view in views])
    axes = np.stack([view.T_view_world[2, :3] for view in views])
    across = np.eye(3) - axes[:, :, None] * axes[:, None]
    # Axes that are all parallel leave a direction open: a little weight on the cameras' own places.
    system = across.sum(axis=0) + 1e-6 * len(views) * np.eye(3)
    target = (across @ places[..., None])[..., 0].sum(axis=0) + 1e-6 * places.sum(axis=0)
    p_centre = np.linalg.solve(system, target)
    return p_centre, float(np.linalg.norm(places - p_centre, axis=1).max())


def _bounds(
    cells: NDArray[np.int64], filled: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First and last grid point of what hangs together and is no stray piece, with a rim.

    Far away from where the cameras look, few of them see, and what they see may be anything.
    """
    if not filled.any():
        raise SurfaceError(
            "No place lies within all silhouettes: check that they are of one moment, and that "
            "the cameras' file is theirs."
        )
    cells, filled = cells[filled > 0], filled[filled > 0]
    pieces = touching(cells // CELL)
    sizes = np.bincount(pieces, filled)
    kept = cells[sizes[pieces] >= SMALLEST_PIECE * sizes.max()]
    return kept.min(axis=0) - CELL, kept.max(axis=0) + 2 * CELL


def touching(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """(N,) the piece that each of the cells (N, 3) belongs to; cells touch also at corners."""
    from_low = cells - cells.min(axis=0) + 1
    shape = tuple(from_low.max(axis=0) + 2)
    keys = np.ravel_multi_index(tuple(from_low.T), shape)
    order = np.argsort(keys)
    links = []
    for step in np.ndindex(3, 3, 3):
        wanted = np.ravel_multi_index(tuple((from_low + step - 1).T), shape)
        at = np.minimum(np.searchsorted(keys, wanted, sorter=order), len(keys) - 1)
        is_there = keys[order[at]] == wanted
        links.append(np.stack([np.nonzero(is_there)[0], order[at[is_there]]]))
    cell, neighbour = np.concatenate(links, axis=1)
    graph = sparse.coo_array((np.ones(len(cell), bool), (cell, neighbour)), shape=(len(cells),) * 2)
    return np.asarray(sparse.csgraph.connected_components(graph, directed=False)[1], np.int64)


def _require_affordable(points: int, voxel_m: float) -> None:
    if points > MOST_POINTS:
        raise SurfaceError(
            f"Voxels of {100 * voxel_m:g} cm make a grid of more than {MOST_POINTS // 10**6} "
            "million points: choose larger ones."
        )
