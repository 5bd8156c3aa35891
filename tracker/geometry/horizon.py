"""What is up, by where the horizon is seen.

Every direction that points to the horizon is level, so the plane of the rays through its line in
the picture is level too, and up is that plane's normal. A line along something upright leaves the
tilt open; this one gives tilt and roll.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, frozen

STEEPEST_RAD = math.radians(80.0)
"""A line that rises more than this toward what is known as up says nothing about which of its sides
is the sky."""
MARGIN = 0.15
"""How far from the picture's edges the two ends of a horizon lie, as a share of its size."""
FARTHEST = 20.0
"""Sizes of the picture beyond which a horizon counts as not to be seen: the camera looks straight
up or down."""


def up_from_horizon(camera: Camera, a: ArrayLike, b: ArrayLike, up_camera: ArrayLike) -> Array:
    """Unit vector (3,) up, camera frame, by two pixels (u, v) at which the horizon is seen.

    The ends may lie outside of the picture, and their order does not matter. up_camera: (3,) what
    is known of up; it decides which side of the line is the sky. A telephoto camera counts as the
    long lens that it stands for: the horizon is far away, and parallel rays would not show it.
    """
    uv = np.array([a, b], dtype=np.float64)
    if math.dist(uv[0], uv[1]) < 1e-9:
        raise CameraError("A horizon needs a line: its two ends are the same point.")
    lens = camera.model_copy(update={"projection": "perspective", "telephoto_distance_m": None})
    rays = lens.back_project(uv, 1.0)
    if not np.isfinite(rays).all():
        raise CameraError(
            "The lens shows nothing at one end of this line. Draw it nearer the centre."
        )
    normal = np.cross(rays[0], rays[1])
    up = normal / np.linalg.norm(normal)
    up_before = np.asarray(up_camera, dtype=np.float64)
    cosine = float(up @ up_before / np.linalg.norm(up_before))
    if abs(cosine) < math.cos(STEEPEST_RAD):
        raise CameraError("This line goes up, not across. Draw the horizon from side to side.")
    return frozen(math.copysign(1.0, cosine) * up)


def horizon_of(camera: Camera, up_camera: ArrayLike) -> Array | None:
    """Pixels (2, 2) of two points on the horizon, as an ideal lens shows them.

    They lie `MARGIN` from those edges of the picture between which the line runs. None where the
    camera looks so far up or down that no part of the line comes near the picture.
    """
    x, y, z = np.asarray(up_camera, dtype=np.float64)
    slopes = np.array([x / camera.fx, y / camera.fy])  # slopes · (uv − centre) + z = 0 on the line
    size, centre = np.array([camera.width, camera.height]), np.array([camera.cx, camera.cy])
    along = int(abs(slopes[0]) > abs(slopes[1]))
    across = 1 - along
    uv = np.empty((2, 2))
    uv[:, along] = np.array([MARGIN, 1 - MARGIN]) * (size[along] - 1)
    off = -(slopes[along] * (uv[:, along] - centre[along]) + z)
    if (np.abs(off) > abs(slopes[across]) * FARTHEST * size.max()).any():
        return None
    uv[:, across] = centre[across] + off / slopes[across]
    return frozen(uv)
