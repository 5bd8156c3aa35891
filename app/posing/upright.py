"""What is up, and the views that stand on it.

A view's frame is x right, y down, z away, as the camera's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.vectors import across, cross, length, unit
from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, frozen
from keypose.tracker.geometry.view import ViewName

CAMERA_UP = (0.0, -1.0, 0.0)
"""The picture's own up direction, in the camera frame."""


def view_rotations(up_camera: ArrayLike = CAMERA_UP) -> dict[ViewName, Array]:
    """R_view_camera (3, 3) of the three small views, for a direction that is up.

    The front view looks horizontally, along the camera's optical axis as far as that can be. The
    top view looks down with the far side up, the side view from the right with the far side right.
    """
    down = -unit(np.asarray(up_camera, dtype=np.float64))
    away = across(np.array([0.0, 0.0, 1.0]), down)
    if length(away) < 1e-6:  # the camera looks straight up or down: its own up direction decides
        away = across(np.array([0.0, 1.0 if down[2] < 0 else -1.0, 0.0]), down)
    away = unit(across(unit(away), down))  # once more: what is left of a short one is inexact
    right = cross(down, away)
    return {
        "top": frozen([right, -away, down]),
        "side": frozen([away, down, -right]),
        "front": frozen([right, down, away]),
    }


def eye_rotation(azimuth_deg: float, elevation_deg: float) -> Array:
    """R_eye_level (3, 3): how an eye going round a level world looks: right, down, away.

    The level frame is that of the front view. An azimuth of 0 looks as the front view does, 90 from
    the right of it as the side view, 180 from behind; an elevation of 90 looks straight down.
    """
    a, e = math.radians(azimuth_deg), math.radians(elevation_deg)
    right = np.array([math.cos(a), 0.0, math.sin(a)])
    away = np.array([-math.sin(a) * math.cos(e), math.sin(e), math.cos(a) * math.cos(e)])
    return np.array([right, np.cross(away, right), away])


def up_from_vertical(camera: Camera, a: Sequence[float], b: Sequence[float]) -> Array:
    """(3,) the up direction, given by a line drawn from pixel a to b along something upright.

    One line does not show how far the camera is tilted: every direction in the plane through the
    line and the camera projects along it. Of these the nearest to the picture's own up is taken,
    so the tilt is the least there can be. The order of the ends does not matter.
    """
    view = PointerView.of(camera)
    start, one = view.ray(a)
    end, other = view.ray(b)
    across_line = cross(one, other) if view.is_perspective else cross(end - start, one)
    if length(across_line) < 1e-12:
        raise CameraError("A vertical needs a line: its two ends are the same point.")
    return frozen(unit(_within(np.array(CAMERA_UP), unit(across_line))))


def _within(up: Array, normal: Array) -> Array:
    """`up` turned into the plane; along the picture's right where it stands at right angles."""
    found = across(up, normal)
    return found if length(found) > 1e-9 else across(np.array([1.0, 0.0, 0.0]), normal)


def tilt_and_roll(up_camera: ArrayLike) -> tuple[float, float]:
    """Degrees by which the camera looks up (tilt), and by which up leans right in it (roll)."""
    x, y, z = (float(v) for v in unit(np.asarray(up_camera, dtype=np.float64)))
    tilt = math.degrees(math.asin(min(max(z, -1.0), 1.0)))
    return tilt + 0.0, math.degrees(math.atan2(x, -y)) + 0.0
