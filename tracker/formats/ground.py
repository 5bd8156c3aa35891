"""A world that stands on the floor, for formats whose floor is z = 0.

z points up, x to the picture's right, y away from the camera, both level. The origin is the point
of the floor below the camera. The floor lies as high as the session says, or else where the moving
body stands lowest.
"""

from __future__ import annotations

import numpy as np

from tracker.body.floor import floor_height, lowest_heights
from tracker.formats.recording import Recording
from tracker.geometry.rotations import Array

STEEP = 1e-6
"""Sine of the angle between the line of sight and up, below which neither side is the right one."""


def ground_from_camera(recording: Recording) -> tuple[Array, Array]:
    """R_ground_camera (3, 3) and p_ground_camera (3,), the camera's centre, metres.

    Every frame of the recording is tracked.
    """
    Ts_camera_part = recording.trajectory.transforms(recording.skeleton)
    lowest = lowest_heights(recording.skeleton, Ts_camera_part, recording.up_camera)
    height = floor_height(recording.floor_m, lowest)
    return _level(recording.up_camera), np.array([0.0, 0.0, -height])


def _level(up_camera: Array) -> Array:
    """R_ground_camera: its rows are x, y and z of the ground in the camera frame."""
    across = np.cross([0.0, 0.0, 1.0], up_camera)
    if np.linalg.norm(across) < STEEP:  # it looks straight up or down
        across = np.array([1.0, 0.0, 0.0])
    y = np.cross(up_camera, across)
    y /= np.linalg.norm(y)
    return np.stack([np.cross(y, up_camera), y, up_camera])
