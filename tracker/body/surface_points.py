"""Points sampled on the body's surface, which the tracker follows.

Each part carries points with outward normals on all its sides, about a fixed spacing apart. A pose
shows those that face the camera and that no nearer part covers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.shapes import Mesh
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array

GOLDEN = 0.6180339887498949
"""The golden ratio less one: by such steps points around a limb never line up."""


@dataclass(frozen=True, eq=False)
class SurfacePoints:
    """S points on the surface of a body, sorted by part and, inside a part, by neighbourhood.

    points:  (S, 3) float32 in the part's frame, metres.
    normals: (S, 3) float32 outward unit normals in the part's frame.
    starts:  (P + 1,) part i's points are starts[i] up to starts[i + 1].
    spacing_m: distance between neighbours.
    """

    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    starts: NDArray[np.int64]
    spacing_m: float


@lru_cache(maxsize=8)
def surface_area(skeleton: Skeleton) -> float:
    """Area of all parts' surfaces in square metres, hidden sides included."""
    meshes = (part.shape.mesh() for part in skeleton.body.parts)
    return float(sum(_face_areas(mesh)[0].sum() for mesh in meshes))


def sample_points(skeleton: Skeleton, spacing_m: float) -> SurfacePoints:
    """Points about `spacing_m` apart on every part."""
    sampled = [_sample_mesh(part.shape.mesh(), spacing_m) for part in skeleton.body.parts]
    counts = [len(points) for points, _ in sampled]
    arrays = (
        np.concatenate([points for points, _ in sampled]).astype(np.float32),
        np.concatenate([normals for _, normals in sampled]).astype(np.float32),
        np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
    )
    for array in arrays:
        array.setflags(write=False)
    return SurfacePoints(*arrays, spacing_m)


def _face_areas(mesh: Mesh) -> tuple[Array, Array]:
    """Areas (F,) and unit normals (F, 3) of the faces."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    length = np.linalg.norm(cross, axis=1)
    return length / 2, cross / np.maximum(length, 1e-300)[:, None]


def _sample_mesh(mesh: Mesh, spacing: float) -> tuple[Array, Array]:
    """Points (N, 3) and normals (N, 3), evenly by area: a low-discrepancy walk over the faces."""
    areas, normals = _face_areas(mesh)
    edges = np.concatenate([[0.0], np.cumsum(areas)])
    count = max(8, round(edges[-1] / spacing**2))
    along = (np.arange(count) + 0.5) / count * edges[-1]
    face = np.minimum(np.searchsorted(edges, along, side="right") - 1, len(areas) - 1)
    share = np.sqrt((along - edges[face]) / areas[face])
    across = ((np.arange(count) + 1) * GOLDEN) % 1.0
    a, b, c = (mesh.vertices[mesh.faces[face, k]] for k in range(3))
    points = a + share[:, None] * ((b - a) + across[:, None] * (c - b))
    order = _neighbours_together(points, normals[face], spacing)
    return points[order], normals[face][order]


def _neighbours_together(points: Array, normals: Array, spacing: float) -> NDArray[np.intp]:
    """An order in which points of one side and one small cell follow each other."""
    cell = np.floor((points - points.min(0)) / (4 * spacing)).astype(int)
    side = np.round(normals * 1.5).astype(int)
    keys = (cell[:, 0], cell[:, 2], cell[:, 1], side[:, 2], side[:, 0], side[:, 1])
    return np.lexsort(keys)
