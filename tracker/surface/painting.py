"""An observed surface as a camera would see it: clay or given colours, in soft light."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.raster import depth_of, projection_of
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, apply_transform, frozen
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.surface.mesh import SurfaceMesh

Picture: TypeAlias = NDArray[np.uint8]
Colours: TypeAlias = NDArray[np.uint8]
"""(V, 3) RGB, of every vertex."""

CLAY = (186, 190, 194)
"""Cooler than the parts of a body, which are seen in it."""
GROUND = (28, 31, 36)
"""What is behind the surface."""
INSIDE = 0.45
"""How bright the inner side of a surface is, where one looks through a hole."""
NEAR_M = 0.02
FINE = 2
"""Drawn so many times larger and then reduced, for smooth outlines."""

_TO_LIGHT = np.array([-0.50, -0.70, -0.75]) / np.linalg.norm([-0.50, -0.70, -0.75])
"""From the upper left, behind the viewer."""


def paint(mesh: SurfaceMesh, camera: Camera, colours: Colours | None = None) -> Picture:
    """A surface (camera frame, metres) as this camera, with an ideal lens, would see it.

    Returns (height, width, 3) RGB. colours: clay when left out.
    """
    import cv2  # loads, as the loops do, when something is drawn

    from keypose.tracker.kernels.painting import colour
    from keypose.tracker.kernels.raster import PERSPECTIVE, fill

    size = (FINE * camera.height, FINE * camera.width)
    nearness = np.full(size, -np.inf, dtype=np.float32)
    face = np.full(size, -1, dtype=np.int32)
    fine = np.empty((*size, 3), dtype=np.uint8)
    fine[:] = GROUND
    lens, vertices = _enlarge(camera), np.ascontiguousarray(mesh.vertices)
    projection = np.array([PERSPECTIVE, *lens, 1.0])
    fill(vertices, mesh.faces, projection, NEAR_M, nearness, face)
    lit = _shade(mesh.normals, mesh.vertices, colours)
    colour(vertices, mesh.faces, lit, lens, INSIDE, face, fine)
    small = cv2.resize(fine, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
    return np.asarray(small, dtype=np.uint8)


@dataclass(frozen=True, eq=False)
class Layer:
    """The nearest layer of a surface, as a view camera sees it.

    rgb:   (H, W, 3) in the light, 0 to 255; black where there is none.
    depth: (H, W) float32 z in the view's frame, metres, inf where there is none.
    """

    rgb: Picture
    depth: NDArray[np.float32]


def layer(mesh: SurfaceMesh, view: ViewCamera, colours: Colours | None = None) -> Layer:
    """A surface (camera frame, metres) from any view camera; each pixel is what its middle
    shows. colours: clay when left out."""
    from keypose.tracker.kernels.painting import colour
    from keypose.tracker.kernels.raster import fill

    size = (view.height, view.width)
    nearness = np.full(size, -np.inf, dtype=np.float32)
    face = np.full(size, -1, dtype=np.int32)
    rgb = np.zeros((*size, 3), dtype=np.uint8)
    p_eye = frozen(apply_transform(view.T_view_camera, mesh.vertices))
    fill(p_eye, mesh.faces, projection_of(view), view.near_m, nearness, face)
    lit = _shade(mesh.normals @ view.T_view_camera[:3, :3].T, view.rays(p_eye), colours)
    lens = np.array([*view.focal, *view.centre])
    colour(_pixels_on_rays(p_eye, view), mesh.faces, lit, lens, INSIDE, face, rgb)
    return Layer(rgb, depth_of(nearness, view))


def _pixels_on_rays(p_eye: Array, view: ViewCamera) -> Array:
    """Points that the perspective projects to the pixels of the view: for parallel rays all lie on
    one plane."""
    if view.parallel_m is None:
        return p_eye
    return frozen(np.column_stack([p_eye[:, :2] / view.parallel_m, np.ones(len(p_eye))]))


def _enlarge(camera: Camera) -> Array:
    """fx, fy, cx, cy of the larger picture; a pixel's middle stays where it was."""
    off = (FINE - 1) / 2
    return FINE * np.array([camera.fx, camera.fy, camera.cx, camera.cy]) + (0.0, 0.0, off, off)


def _shade(normals: Array, rays: Array, colours: Colours | None) -> NDArray[np.float32]:
    """(V, 3) the vertices' colours in the light, 0 to 255, as seen from outside.

    normals, rays: (V, 3) in the frame that is looked from; rays toward the vertices, of any length.
    """
    tints = np.array([CLAY], dtype=np.uint8) if colours is None else colours
    wrapped = np.clip((normals @ _TO_LIGHT + 0.35) / 1.35, 0.0, 1.0)
    away = rays / np.maximum(np.linalg.norm(rays, axis=1, keepdims=True), 1e-9)
    rim = np.clip(1.0 + np.einsum("vi,vi->v", normals, away), 0.0, 1.0)
    brightness = 0.52 + 0.52 * wrapped - 0.16 * rim**3
    return np.asarray(np.clip(tints * brightness[:, None], 0.0, 255.0), dtype=np.float32)
