"""Heading, roll and pitch of a body's root against what is up.

R = Ry(heading) · Rz(roll) · Rx(pitch) in the level frame, which has y down along what is up, x to
the right of the camera's picture and z forward, as nearly as that allows. Heading is first, so that
somebody who turns round, leans or falls forward has no angle that is not determined; heading and
pitch are not determined one by one only where the body lies on its side, with roll a quarter turn.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from keypose.tracker.geometry.rotations import Array, exp_rotation, frozen

CAMERA_UP: Final = (0.0, -1.0, 0.0)
"""Up where no other direction is known: the camera's own."""

_Y_TO_Z: Final = frozen([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""A quarter turn about x, after which Ry · Rz · Rx is Rz · Ry⁻¹ · Rx."""


def heading_first(Rs_camera_root: Array, up_camera: ArrayLike) -> Array:
    """(..., 3, 3) rotations whose [z, y, x], R = Rz · Ry · Rx, are heading, −roll and pitch."""
    return np.asarray(_Y_TO_Z @ _level(up_camera) @ Rs_camera_root @ _Y_TO_Z.T)


def from_heading_first(rotations: Array, up_camera: ArrayLike) -> Array:
    """Rs_camera_root (..., 3, 3) of those."""
    return np.asarray(_level(up_camera).T @ _Y_TO_Z.T @ rotations @ _Y_TO_Z)


def _level(up_camera: ArrayLike) -> Array:
    """R_level_camera (3, 3): the least turn that brings up to −y."""
    up = np.asarray(up_camera, dtype=np.float64)
    up = up / np.linalg.norm(up)
    axis = np.cross(up, [0.0, -1.0, 0.0])
    sine = float(np.linalg.norm(axis))
    if sine < 1e-12:
        return np.eye(3) if up[1] < 0 else np.diag([1.0, -1.0, -1.0])
    return exp_rotation(axis / sine * np.arctan2(sine, -up[1]))
