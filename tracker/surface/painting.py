"""An observed surface as a camera would see it: clay in soft light, or in telling colours."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from tracker.camera import Camera
from tracker.geometry import Array
from tracker.surface.mesh import SurfaceMesh

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


def painted(mesh: SurfaceMesh, camera: Camera, colours: Colours | None = None) -> Picture:
    """A surface (camera frame, metres) as this camera, with an ideal lens, would see it.

    Returns (height, width, 3) RGB. colours: clay when left out.
    """
    import cv2  # loads, as the loops do, when something is drawn

    from tracker.kernels.painting import colour
    from tracker.kernels.raster import PERSPECTIVE, fill

    size = (FINE * camera.height, FINE * camera.width)
    nearness = np.full(size, -np.inf, dtype=np.float32)
    face = np.full(size, -1, dtype=np.int32)
    fine = np.empty((*size, 3), dtype=np.uint8)
    fine[:] = GROUND
    lens, vertices = _enlarged(camera), np.ascontiguousarray(mesh.vertices)
    projection = np.array([PERSPECTIVE, *lens, 1.0])
    fill(vertices, mesh.faces, projection, NEAR_M, nearness, face)
    colour(vertices, mesh.faces, _lit(mesh, colours), lens, INSIDE, face, fine)
    small = cv2.resize(fine, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
    return np.asarray(small, dtype=np.uint8)


def _enlarged(camera: Camera) -> Array:
    """fx, fy, cx, cy of the larger picture; a pixel's middle stays where it was."""
    off = (FINE - 1) / 2
    return FINE * np.array([camera.fx, camera.fy, camera.cx, camera.cy]) + (0.0, 0.0, off, off)


def _lit(mesh: SurfaceMesh, colours: Colours | None) -> NDArray[np.float32]:
    """(V, 3) the vertices' colours in the light, 0 to 255, as seen from outside."""
    tints = np.array([CLAY], dtype=np.uint8) if colours is None else colours
    normals = mesh.normals
    wrapped = np.clip((normals @ _TO_LIGHT + 0.35) / 1.35, 0.0, 1.0)
    away = mesh.vertices / np.maximum(np.linalg.norm(mesh.vertices, axis=1, keepdims=True), 1e-9)
    rim = np.clip(1.0 + np.einsum("vi,vi->v", normals, away), 0.0, 1.0)
    brightness = 0.52 + 0.52 * wrapped - 0.16 * rim**3
    return np.asarray(np.clip(tints * brightness[:, None], 0.0, 255.0), dtype=np.float32)
