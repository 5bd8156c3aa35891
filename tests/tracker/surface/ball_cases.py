"""A textured ball among calibrated cameras: its silhouettes, pictures and true surface."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.shapes import Mesh
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.cameras.hull import Field, Silhouette, surface_of
from keypose.tracker.surface.cameras.rig import View
from tests.rendering.ring import Carvings, Shot, ring_of

P_BALL = np.array([0.0, 0.0, 3.8])
RADIUS_M = 0.3


def ball_field(p_centre: Array, radius_m: float, voxel_m: float = 0.02) -> Field:
    """Depth within a ball, exact."""
    count = int(np.ceil(2 * radius_m / voxel_m)) + 7
    p_origin = p_centre - voxel_m * (count - 1) / 2
    grid = np.stack(np.meshgrid(*[np.arange(count)] * 3, indexing="ij"), axis=-1)
    beyond = np.linalg.norm(p_origin + voxel_m * grid - p_centre, axis=-1)
    return Field(p_origin, voxel_m, (radius_m - beyond).astype(np.float32))


def ball_mesh(p_centre: Array, radius_m: float, voxel_m: float = 0.02) -> Mesh:
    mesh = surface_of(ball_field(p_centre, radius_m, voxel_m))
    return Mesh(mesh.vertices, mesh.faces, np.zeros(len(mesh.faces), np.int64))


@cache
def studio(
    count: int, balls: tuple[tuple[float, float, float], ...] = ((0.0, 0.0, 0.0),)
) -> tuple[tuple[View, ...], tuple[Shot, ...]]:
    """So many views of balls at these places beside P_BALL, and what they see."""
    views = ring_of(count, P_BALL)
    meshes = tuple(ball_mesh(P_BALL + np.array(p), RADIUS_M) for p in balls)
    carvings = Carvings(meshes)
    Ts = np.tile(np.eye(4), (len(meshes), 1, 1))
    return views, tuple(carvings.seen_by(view, Ts, [i]) for i, view in enumerate(views))


def silhouettes(shots: Sequence[Shot]) -> list[Silhouette]:
    return [Silhouette(shot.inside) for shot in shots]


def pictures(shots: Sequence[Shot]) -> list[NDArray[np.uint8]]:
    return [shot.picture for shot in shots]
