"""Shaded solids: round where a shape is round, flat where it is flat, each part in a dark line."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.app.render.palette import INK, Canvas, on_canvas
from keypose.tracker.body.raster import BodyMesh, Raster
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewCamera

Mask: TypeAlias = NDArray[np.bool_]

CREASE_COSINE = np.cos(np.deg2rad(35.0))
"""Faces that meet at a smaller angle are shaded as one round surface."""

TO_LIGHT = np.array([-0.50, -0.70, -0.75]) / np.linalg.norm([-0.50, -0.70, -0.75])
"""From the upper left, behind the viewer, in the view's frame."""


def face_normals(vertices: Array, faces: NDArray[np.int64]) -> Array:
    """Unit outward normals (F, 3)."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def smooth_normal_maps(mesh: BodyMesh) -> Array:
    """(F, 3, 4): the smooth normal at a point p of a face is M @ [p, 1], in the part's frame.

    It runs linearly between the normals of the face's corners, each the mean over the faces there
    that lie within the crease angle.
    """
    flat = face_normals(mesh.vertices, mesh.faces)
    corner = _corner_normals(mesh, flat)
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    shares = np.linalg.inv(np.stack([b - a, c - a, flat], axis=2))[:, :2]
    turn = np.stack([corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]], axis=2) @ shares
    offset = corner[:, 0] - (turn @ a[:, :, None])[..., 0]
    return np.concatenate([turn, offset[:, :, None]], axis=2)


def _corner_normals(mesh: BodyMesh, flat: Array) -> Array:
    """Normals (F, 3, 3) at the corners of every face."""
    around: list[list[int]] = [[] for _ in mesh.vertices]
    for face, corners in enumerate(mesh.faces.tolist()):
        for vertex in corners:
            around[vertex].append(face)
    normals = np.empty((len(mesh.faces), 3, 3))
    for face, corners in enumerate(mesh.faces.tolist()):
        for k, vertex in enumerate(corners):
            near = flat[around[vertex]]
            total = near[near @ flat[face] > CREASE_COSINE].sum(0)
            normals[face, k] = total / np.linalg.norm(total)
    return normals


def shade(
    mesh: BodyMesh,
    normal_maps: Array,
    colours: Array,
    Ts_camera_part: Array,
    view: ViewCamera,
    raster: Raster,
) -> tuple[Array, Mask]:
    """The colours (N, 3), 0 to 255, of the N pixels in the mask (H, W) that show the body.

    normal_maps are those of `smooth_normal_maps`, colours (P, 3) those of the parts.
    """
    mask = raster.part >= 0
    Ts_eye_part = view.T_view_camera @ Ts_camera_part
    normals = _pixel_normals(mesh, normal_maps, Ts_eye_part, view, raster, mask)
    wrapped = np.clip((normals @ TO_LIGHT + 0.35) / 1.35, 0.0, 1.0)
    edge = np.clip(1.0 + normals[:, 2], 0.0, 1.0)
    brightness = 0.55 + 0.53 * wrapped - 0.14 * edge**3
    rgb = colours[raster.part[mask]] * brightness[:, None]
    return np.clip(rgb, 0.0, 255.0), mask


def _pixel_normals(
    mesh: BodyMesh,
    normal_maps: Array,
    Ts_eye_part: Array,
    view: ViewCamera,
    raster: Raster,
    mask: Mask,
) -> Array:
    """Unit normals (N, 3) in the view's frame, facing the camera."""
    rows, columns = np.nonzero(mask)
    depth = raster.depth[mask].astype(np.float64)
    p_eye = view.back_project(np.column_stack([columns, rows]), depth)
    turn = Ts_eye_part[mesh.face_part, :3, :3] @ normal_maps
    to_part = np.linalg.inv(Ts_eye_part)[mesh.face_part]
    maps = (turn @ to_part)[raster.face[mask]]
    normals = np.einsum("nij,nj->ni", maps[:, :, :3], p_eye) + maps[:, :, 3]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    away = np.einsum("ni,ni->n", normals, view.rays(p_eye)) > 0
    normals[away] *= -1
    return np.asarray(normals)


def part_borders(raster: Raster) -> Mask:
    """Pixels (H, W) on the border between parts, or between the body and what is behind it."""
    part = np.pad(raster.part, 1, constant_values=-1)
    middle = part[1:-1, 1:-1]
    border = np.zeros(middle.shape, dtype=bool)
    for rows, columns in ((0, 1), (2, 1), (1, 0), (1, 2)):
        height, width = middle.shape
        border |= middle != part[rows : rows + height, columns : columns + width]
    return border & (middle >= 0)


def paint_solid(canvas: Canvas, rgb: Array, mask: Mask, opacity: float, border: Mask) -> None:
    """Paint the shaded body, and the dark line of its borders, over a canvas in place."""
    flat = canvas.reshape(-1, canvas.shape[2])
    for pixels, colours, share in (
        (np.flatnonzero(mask), on_canvas(rgb, canvas), opacity),
        (np.flatnonzero(border), on_canvas(INK, canvas), 0.65 * min(1.0, opacity + 0.15)),
    ):
        before = flat[pixels]
        flat[pixels] = before + share * (colours - before)
