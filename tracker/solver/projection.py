"""Where points are seen, and how their pixels move."""

from __future__ import annotations

import numpy as np

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array


def image_points(camera: Camera, p: Array) -> Array:
    """Pixels (..., 2) of points (..., 3) without distortion, also behind the camera."""
    z = camera.depth(p)[..., None]
    return np.asarray(p[..., :2] / z * (camera.fx, camera.fy) + (camera.cx, camera.cy))


def image_jacobian(camera: Camera, p: Array, J: Array) -> Array:
    """(..., D, 2) how the pixels of points p (..., 3) move that move by J (..., D, 3)."""
    z = camera.depth(p)[..., None, None]
    uv = J[..., :2] / z
    if camera.projection == "perspective":
        uv = uv - p[..., None, :2] / z**2 * J[..., 2:]
    return np.asarray(uv * (camera.fx, camera.fy))
