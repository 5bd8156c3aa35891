"""The whole body turned to face a way, as seen in the picture."""

from __future__ import annotations

import math
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from keypose.app.posing.angles import with_rotation
from keypose.app.posing.upright import CAMERA_UP, view_rotations
from keypose.app.posing.vectors import across, cross, length, unit
from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.rotations import Array, exp_rotation, nearest_rotation

Way: TypeAlias = Literal["camera", "away", "left", "right"]
"""Left and right are those of the picture."""

_LEVEL = 1e-3
"""A chest whose direction is this steep has none along the ground."""


def facing(pose: Pose, way: Way, up_camera: ArrayLike = CAMERA_UP) -> Pose:
    """The body turned about the up direction through its root until it faces this way.

    Its lean, its place and what the limbs do stay as they are.
    """
    right, down, away = view_rotations(up_camera)["front"]
    wanted = {"camera": -away, "away": away, "left": -right, "right": right}[way]
    R_camera_root = pose.Rs_parent_part[0]
    now = _ahead(R_camera_root, -down)
    angle = math.atan2(float(cross(now, wanted) @ -down), float(now @ wanted))
    return with_rotation(pose, 0, nearest_rotation(exp_rotation(-down * angle) @ R_camera_root))


def _ahead(R_camera_root: Array, up: Array) -> Array:
    """(3,) where the body faces along the ground; one that lies on its front, where its head is."""
    ahead, top = -R_camera_root[:, 2], -R_camera_root[:, 1]
    level = across(ahead, up)
    if length(level) < _LEVEL:
        level = across(top if ahead @ up < 0 else -top, up)
    return np.asarray(unit(level))
