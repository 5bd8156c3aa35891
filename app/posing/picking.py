"""Which parts lie under the pointer, and where a part's outline runs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.app.posing.pointer_view import PointerView
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.shapes import Mesh, Shape
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.geometry.view import NEAR_M


@lru_cache(maxsize=512)
def _mesh_of(shape: Shape) -> Mesh:
    return shape.mesh()


def parts_at(
    skeleton: Skeleton, pose: Pose, view: PointerView, at: Sequence[float]
) -> tuple[str, ...]:
    """Names of the parts seen at a point of the view, from front to back.

    A part lies where the line of sight first enters it. Behind the camera nothing is seen.
    """
    origin, direction = view.ray(at)
    near = NEAR_M if view.camera is not None else -np.inf
    Ts = pose_transforms(skeleton, pose)
    meshes = [_mesh_of(part.shape) for part in skeleton.body.parts]
    corners = np.concatenate(
        [_corners(mesh, T) for mesh, T in zip(meshes, Ts, strict=True)]
    )  # (F, 3, 3)
    part_of = np.repeat(np.arange(len(meshes)), [len(mesh.faces) for mesh in meshes])
    distance = _hits(corners, origin, direction, view.away, float(view.depth(origin)), near)
    found: dict[int, float] = {}
    for face in np.flatnonzero(np.isfinite(distance)):
        part = int(part_of[face])
        found[part] = min(found.get(part, np.inf), float(distance[face]))
    return tuple(skeleton.body.names[part] for part in sorted(found, key=lambda p: found[p]))


def outline(skeleton: Skeleton, pose: Pose, view: PointerView, part: str) -> Array:
    """The convex outline (N, 2) of a part in view coordinates; empty when it cannot be seen."""
    i = skeleton.body.index(part)
    T = pose_transforms(skeleton, pose)[i]
    p_camera = apply_transform(T, _mesh_of(skeleton.body.parts[i].shape).vertices)
    if view.camera is not None and view.depth(p_camera).min() <= NEAR_M:
        return np.zeros((0, 2))
    at = view.project(p_camera).astype(np.float32)
    return cv2.convexHull(at)[:, 0].astype(np.float64)


def _corners(mesh: Mesh, T_camera_part: Array) -> Array:
    placed: Array = apply_transform(T_camera_part, mesh.vertices)[mesh.faces]
    return placed


def _hits(
    corners: Array, origin: Array, direction: Array, away: Array, start_depth: float, near: float
) -> NDArray[np.float64]:
    """(F,) distance along the line at which it meets each triangle (F, 3, 3); inf where not, or
    less than `near` deep, where the line begins `start_depth` deep.

    Möller and Trumbore's rule: the line's point in the triangle's two edges as coordinates.
    """
    a = corners[:, 0]
    e1, e2 = corners[:, 1] - a, corners[:, 2] - a
    across = np.cross(direction, e2)
    size = np.einsum("fi,fi->f", e1, across)
    flat = np.abs(size) < 1e-15
    scale = 1.0 / np.where(flat, 1.0, size)
    start = origin - a
    u = np.einsum("fi,fi->f", start, across) * scale
    turned = np.cross(start, e1)
    v = turned @ direction * scale
    distance = np.einsum("fi,fi->f", e2, turned) * scale
    depth = distance * (direction @ away) + start_depth
    inside = (u >= 0) & (v >= 0) & (u + v <= 1) & ~flat & (depth >= near)
    return np.where(inside, distance, np.inf)
