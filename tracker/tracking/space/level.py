"""Up from where feet stand: the direction along which their places are equally high."""

from __future__ import annotations

from math import radians

import numpy as np

from keypose.tracker.geometry.rotations import Array

LEVEL_M = 0.03
"""Sigma of how far a standing foot is off the common level: soles, grass, an uneven floor."""
LEAN_RAD = radians(5)
"""Sigma of how far the camera leans beyond what is known of it."""
STEPS = 3
"""The problem is linear but for the unit length."""


def up_from_places(p_camera: Array, up_camera: Array) -> Array:
    """Unit vector (3,) up, by places (N, 3) that lie on one level floor, metres, camera frame.

    up_camera: unit vector (3,), what is known of up. It decides what the places do not show: those
    along one line show the slope along it alone.
    """
    from_middle = p_camera - p_camera.mean(axis=0)
    up = np.asarray(up_camera, dtype=np.float64)
    for _ in range(STEPS):
        tilts = np.linalg.svd(up[None])[2][1:]  # (2, 3) directions across up
        rows = np.concatenate([from_middle @ tilts.T / LEVEL_M, tilts.T / LEAN_RAD])
        off = np.concatenate([from_middle @ up / LEVEL_M, (up - up_camera) / LEAN_RAD])
        up = up - np.linalg.lstsq(rows, off, rcond=None)[0] @ tilts
        up = up / np.linalg.norm(up)
    return up
