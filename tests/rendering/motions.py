"""Written motions of the preset bodies, and of a box, seen from about 5 m.

The rest pose faces the camera; x points to the picture's right, y down, z away. About x, negative
angles lift arms and thighs forward and bend elbows, positive ones bend knees and lean forward.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import gaussian_filter1d

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from tests.rendering.angles import Angles, bump, wave
from tests.rendering.ground import lowest_sole
from tests.rendering.mocap import jump, jumping_jacks, pirouette, walk, wash
from tests.rendering.throw_poses import THROW

__all__ = [
    "crossing", "jump", "jumping_jacks", "pirouette", "shelf", "speech", "stride", "throw",
    "tumbling_box", "walk", "wash",
]  # fmt: skip

FPS = 30.0
GROUND_Y_M = 0.86
"""Where the ground lies below the camera's axis, so that a person fills the picture's height."""


def speech(skeleton: Skeleton, frames: int = 181) -> Trajectory:
    """Someone explains with the right arm, while chest, head and the other arm sway; slow."""
    s = np.arange(frames) / FPS
    a = Angles(skeleton, frames)
    a.turn("waist", y=0.22 + 0.05 * wave(s, 0.12), z=0.012 * wave(s, 0.12, 0.5))
    a.turn("chest", 0.05 * wave(s, 0.26), 0.10 * wave(s, 0.20, 0.3), 0.05 * wave(s, 0.16, 1.1))
    a.turn("head", 0.10 * wave(s, 0.42, 0.6), 0.24 * wave(s, 0.23))
    a.turn("right_upper_arm", -0.42 + 0.24 * wave(s, 0.27, 2.1), 0.0, 0.28 + 0.20 * wave(s, 0.21))
    a.turn("right_forearm", -1.20 - 0.50 * wave(s, 0.36))
    a.turn("left_upper_arm", -0.12 + 0.08 * wave(s, 0.19), 0.0, -0.16 - 0.06 * wave(s, 0.24, 0.4))
    a.turn("left_forearm", -0.55 + 0.20 * wave(s, 0.31, 1.0))
    sway = 0.012 * wave(s, 0.12, 0.5)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        a.turn(f"{side}_thigh", -0.03 * sign, 0.0, -sign * 0.07 - sway)
        a.turn(f"{side}_shin", 0.06 + 0.02 * sign)
    y = GROUND_Y_M - lowest_sole(skeleton, a.rotations())
    return a.trajectory(np.column_stack([0.03 * wave(s, 0.12), y, 5.0 + 0.03 * wave(s, 0.14)]))


def throw(skeleton: Skeleton, frames: int = 120) -> Trajectory:
    """A fast overarm throw: wind-up, stride, the arm whips through, follow-through."""
    keys = np.array([key.frame for key in THROW]) * (frames - 1) / THROW[-1].frame
    a = Angles(skeleton, frames)
    for part in sorted({part for key in THROW for part in key.angles}):
        values = np.array([key.angles.get(part, (0.0, 0.0, 0.0)) for key in THROW])
        x, y, z = _through(keys, values, frames).T
        a.turn(part, x, y, z)
    ground = _through(keys, np.array([key.place for key in THROW]), frames)
    y_root = GROUND_Y_M - lowest_sole(skeleton, a.rotations())
    return a.trajectory(np.column_stack([ground[:, 0], y_root, ground[:, 1]]))


def stride(skeleton: Skeleton, frames: int = 121) -> Trajectory:
    """A walk across the picture, from right to left and a little nearer, on a bent path."""
    j = np.arange(frames)
    yaw = 1.22 + 0.22 * np.cos(np.pi * j / max(frames - 1, 1))
    cycle = j / 44.0
    swing = np.cos(2 * np.pi * cycle)
    a = Angles(skeleton, frames)
    a.turn("waist", 0.03, yaw + 0.07 * swing, 0.02 * np.sin(2 * np.pi * cycle))
    a.turn("chest", 0.03, -0.15 * swing)
    a.turn("head", -0.03 + 0.03 * np.sin(4 * np.pi * cycle), -0.15 + 0.10 * swing)
    for side, sign, start in (("left", 1.0, 0.0), ("right", -1.0, 0.5)):
        step = cycle + start
        beat = np.cos(2 * np.pi * step)
        knee = 0.10 + 0.20 * bump(step, 0.13, 0.07) + 0.88 * bump(step, 0.72, 0.105)
        a.turn(
            f"{side}_thigh", -0.08 - 0.29 * beat - 0.12 * bump(step, 0.80, 0.1), 0.0, -0.03 * sign
        )
        a.turn(f"{side}_shin", knee)
        a.turn(f"{side}_upper_arm", 0.06 + 0.32 * beat, 0.0, -0.13 * sign)
        a.turn(f"{side}_forearm", -0.34 + 0.14 * beat)
    path = np.cumsum(np.column_stack([-np.sin(yaw), np.zeros(frames), -np.cos(yaw)]), axis=0)
    ps = 0.0208 * (path - path[frames // 2]) + (0.08, 0.0, 5.4)
    ps[:, 1] = GROUND_Y_M - lowest_sole(skeleton, a.rotations())
    return a.trajectory(ps)


def shelf(skeleton: Skeleton, frames: int = 39) -> Trajectory:
    """Someone seen from the side reaches up and takes something down from a shelf, with one arm.

    INITIAL §4, its first experiment: the arm moves in a plane parallel to the picture, up past the
    head and down again, so that the first and the last pose say nothing of where it was.
    """
    keys = np.array([0.0, 5.0, 17.0, 21.0, 32.0, 38.0]) * (frames - 1) / 38
    shoulder, elbow = (
        (-0.15, -0.50, -2.45, -2.55, -1.05, -0.75),
        (-0.5, -1.1, -0.5, -0.4, -1.0, -1.3),
    )
    reach = _through(keys, np.column_stack([shoulder, elbow]), frames)
    up = -reach[:, 0] / 2.55
    a = Angles(skeleton, frames)
    a.turn("waist", 0.01, np.pi / 2)
    a.turn("chest", 0.06 - 0.08 * up)
    a.turn("head", 0.02 - 0.22 * up)
    a.turn("left_upper_arm", reach[:, 0], 0.0, -0.02)
    a.turn("left_forearm", reach[:, 1])
    a.turn("right_upper_arm", 0.10 - 0.12 * up, 0.0, 0.05)
    a.turn("right_forearm", -0.25)
    for side, swing in (("left", -0.10), ("right", 0.08)):
        a.turn(f"{side}_thigh", swing)
        a.turn(f"{side}_shin", 0.08)
    y = GROUND_Y_M + 0.3 - lowest_sole(skeleton, a.rotations())
    return a.trajectory(np.column_stack([0.15 - 0.03 * up, y, np.full(frames, 6.6)]))


def crossing(skeleton: Skeleton, frames: int = 153) -> Trajectory:
    """Someone seen exactly from the side walks across the picture, from right to left, six steps.

    INITIAL §4, its second experiment. The left side is the near one.
    """
    j = np.arange(frames)
    cycle = j / 51.0 + 0.18
    a = Angles(skeleton, frames)
    a.turn("waist", 0.03, np.pi / 2)
    a.turn("chest", 0.04 + 0.02 * np.cos(4 * np.pi * cycle))
    a.turn("head", -0.04 + 0.03 * np.sin(4 * np.pi * cycle))
    for side, start in (("left", 0.0), ("right", 0.5)):
        step = cycle + start
        beat = np.cos(2 * np.pi * step)
        knee = 0.10 + 0.20 * bump(step, 0.13, 0.07) + 0.85 * bump(step, 0.72, 0.105)
        a.turn(f"{side}_thigh", -0.08 - 0.31 * beat - 0.12 * bump(step, 0.80, 0.1))
        a.turn(f"{side}_shin", knee)
        a.turn(f"{side}_upper_arm", 0.06 + 0.34 * beat)
        a.turn(f"{side}_forearm", -0.34 + 0.14 * beat)
    y = GROUND_Y_M - lowest_sole(skeleton, a.rotations())
    x = 1.55 - 3.1 * j / max(frames - 1, 1)
    return a.trajectory(np.column_stack([x, y, np.full(frames, 5.9)]))


def tumbling_box(skeleton: Skeleton, frames: int = 61) -> Trajectory:
    """A one-part body that turns about all axes while it drifts across the picture, 3 m away."""
    s = np.arange(frames) / 40.0
    a = Angles(skeleton, frames)
    a.turn(
        skeleton.body.names[0],
        0.45 + 0.30 * np.sin(np.pi * s),
        0.35 + 1.05 * s + 0.10 * np.sin(2 * np.pi * s),
        0.28 * np.sin(1.1 * np.pi * s),
    )
    x, y = -0.34 + 0.56 * s, 0.06 - 0.15 * np.sin(np.pi * s)
    return a.trajectory(np.column_stack([x, y, 3.1 + 0.30 * np.sin(0.8 * np.pi * s)]))


def _through(keys: np.ndarray, values: np.ndarray, frames: int) -> np.ndarray:
    """Values at the key frames joined smoothly, without overshoot, one row per frame."""
    smooth = PchipInterpolator(keys, values, axis=0)(np.arange(frames))
    return np.asarray(gaussian_filter1d(smooth, 1.2, axis=0, mode="nearest"))
