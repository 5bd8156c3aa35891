"""Find the parts of a posed body that a ray meets."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.shapes import Mesh, Shape
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, apply_transform


@lru_cache(maxsize=512)
def mesh_of(shape: Shape) -> Mesh:
    """A shape's mesh, made once."""
    return shape.mesh()


def parts_on_ray(
    skeleton: Skeleton, pose: Pose, origin: Array, direction: Array, start: float = 0.0
) -> tuple[str, ...]:
    """The names of the parts on a ray, in the order in which it first enters them.

    origin, direction: (3,) in the camera frame.  start: how far along it the ray begins.
    """
    Ts = pose_transforms(skeleton, pose)
    meshes = [mesh_of(part.shape) for part in skeleton.body.parts]
    corners = np.concatenate(
        [apply_transform(T, mesh.vertices)[mesh.faces] for mesh, T in zip(meshes, Ts, strict=True)]
    )  # (F, 3, 3)
    part_of = np.repeat(np.arange(len(meshes)), [len(mesh.faces) for mesh in meshes])
    distance = _hits(corners, origin, direction, start)
    distance_of_part: dict[int, float] = {}
    for face in np.flatnonzero(np.isfinite(distance)):
        part = int(part_of[face])
        distance_of_part[part] = min(distance_of_part.get(part, np.inf), float(distance[face]))
    return tuple(
        skeleton.body.names[part]
        for part in sorted(distance_of_part, key=lambda p: distance_of_part[p])
    )


def _hits(corners: Array, origin: Array, direction: Array, start: float) -> NDArray[np.float64]:
    """(F,) distance along the line at which it meets each triangle (F, 3, 3); inf where not, or
    before `start`.

    Möller and Trumbore's rule: the line's point in the triangle's two edges as coordinates.
    """
    a = corners[:, 0]
    e1, e2 = corners[:, 1] - a, corners[:, 2] - a
    across = np.cross(direction, e2)
    size = np.einsum("fi,fi->f", e1, across)
    flat = np.abs(size) < 1e-15
    scale = 1.0 / np.where(flat, 1.0, size)
    away = origin - a
    u = np.einsum("fi,fi->f", away, across) * scale
    turned = np.cross(away, e1)
    v = turned @ direction * scale
    distance = np.einsum("fi,fi->f", e2, turned) * scale
    inside = (u >= 0) & (v >= 0) & (u + v <= 1) & ~flat & (distance >= start)
    return np.where(inside, distance, np.inf)
