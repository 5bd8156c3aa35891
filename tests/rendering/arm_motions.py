"""How the three arms move in 19 steps: they close, touch at steps 8 to 10, and open again.

Shortly before they touch, the space between them is hidden from most cameras: at steps 6 to 8 a
hull holds phantom volume there.  SURFACE §5.1, fig. 6
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.rotations import Array, rotation_from_euler
from tests.rendering.arm_bodies import APEX_M, LENGTH_M, MIDDLE_M, Kind

STEPS = 19
P_CENTRE = np.array([0.0, 0.0, 3.8])
"""The place in the camera frame, metres, about which it happens."""


def arm_poses(kind: Kind) -> list[Pose]:
    """The true poses."""
    return [_tripod(step) if kind == "tripod" else _chain(step) for step in range(STEPS)]


_TOUCHING_DEG = np.degrees(np.arctan(APEX_M / LENGTH_M))
# Step; of each arm of the tripod the angle from straight down, degrees.
_TRIPOD = np.array([
    (0, 60, 58, 62), (5, 33, 31, 35), (6, 23, 21, 25), (7, 14, 13, 16),
    (8, _TOUCHING_DEG, _TOUCHING_DEG, _TOUCHING_DEG + 7),
    (9, _TOUCHING_DEG, _TOUCHING_DEG, _TOUCHING_DEG),
    (10, _TOUCHING_DEG + 7, _TOUCHING_DEG, _TOUCHING_DEG),
    (11, 17, 13, 12), (12, 23, 20, 19), (13, 29, 26, 25), (18, 56, 52, 59),
])  # fmt: skip

_FOLDED_DEG = 2 * np.degrees(np.arctan(MIDDLE_M / (LENGTH_M / 2)))
# Step; the chain's angles between neighbouring arms, degrees.
_CHAIN = np.array([
    (0, 120, 112), (4, 78, 72), (6, 50, 47), (7, 37, 36),
    (8, _FOLDED_DEG + 1, _FOLDED_DEG + 2), (9, _FOLDED_DEG, _FOLDED_DEG),
    (10, _FOLDED_DEG + 2, _FOLDED_DEG + 1), (11, 37, 38), (12, 48, 50), (18, 110, 118),
])  # fmt: skip


_LEVEL = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
"""An arm to the right; what it folds about points down."""


def _tripod(step: int) -> Pose:
    tilts = np.radians([np.interp(step, _TRIPOD[:, 0], _TRIPOD[:, 1 + i]) for i in range(3)])
    free = 0.0 if 8 <= step <= 10 else np.radians(4.0)
    turns = np.radians(100 + 1.5 * step + 120 * np.arange(3)) + free * np.sin(
        step / 2 + np.arange(3)
    )
    Rs = np.stack([_arm_down(tilt, turn) for tilt, turn in zip(tilts, turns, strict=True)])
    p_hub = P_CENTRE + np.array([0.04 * np.sin(step / 4), -0.40, 0.03 * np.sin(step / 3)])
    return Pose(np.stack([Rs[0], Rs[0].T @ Rs[1], Rs[0].T @ Rs[2]]), p_hub)


def _arm_down(tilt: float, turn: float) -> Array:
    """R_camera_part of an arm that is tilted from straight down (+y) toward an azimuth."""
    y = np.array([np.sin(tilt) * np.cos(turn), np.cos(tilt), np.sin(tilt) * np.sin(turn)])
    x = np.array([np.cos(tilt) * np.cos(turn), -np.sin(tilt), np.cos(tilt) * np.sin(turn)])
    return np.stack([x, y, np.cross(x, y)], axis=1)


def _chain(step: int) -> Pose:
    first, second = (np.radians(np.interp(step, _CHAIN[:, 0], _CHAIN[:, i])) for i in (1, 2))
    # They fold in a plane that is nearly level; the middle arm stays where it is.
    tilt = rotation_from_euler(
        np.radians(5 * np.sin(step / 3)), 0.0, np.radians(40 + 6 * np.cos(step / 4))
    )
    R_middle = rotation_from_euler(0.0, np.radians(20 + 2.0 * step), 0.0) @ tilt @ _LEVEL
    fold = [rotation_from_euler(angle, 0.0, 0.0) for angle in (np.pi - first, -(np.pi - second))]
    R_first = R_middle @ fold[0].T
    p_middle = P_CENTRE - R_middle @ (0.0, LENGTH_M / 2, 0.0) + (0.0, 0.03 * np.sin(step / 2), 0.0)
    p_root = p_middle - R_first @ (0.0, LENGTH_M, 0.0)
    return Pose(np.stack([R_first, fold[0], fold[1]]), p_root)
