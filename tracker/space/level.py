"""Find what is up: by feet that stand on one level floor, and by how a person stands on them.

A camera is held level by about 3°, and looks down or up by more. Stances show the slope of the
floor as far as they are apart; that a person stands upright shows the rest, along the view less
surely than across it, where a network says how deep joints are. A person leans forward by a few
degrees, most of all on the way, so that this is unknown, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.ground import AHEAD_PART
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.pins import Pin
from keypose.tracker.solver.sigmas import (
    FORWARD_LEAN_RAD,
    LEAN_RAD,
    LEVEL_M,
    ROLL_RAD,
    TILT_RAD,
    UPRIGHT_ACROSS_RAD,
    UPRIGHT_ALONG_RAD,
    USUAL_FORWARD_RAD,
)
from keypose.tracker.space.pinned import KNEES

STEPS: Final = 3
"""The problem is linear but for the unit length."""
MOST_LEAN_RAD: Final = np.radians(45.0)
"""Nobody who stands is farther from what the camera takes for up."""
MOST_BEND_RAD: Final = np.radians(60.0)
"""Somebody whose knees are bent by more sits, or squats, and is not upright over the feet."""
LEVEL_CAMERA: Final = np.array([0.0, -1.0, 0.0])


def up_from_places(p_camera: Array, up_world: Array) -> Array:
    """Unit vector (3,) up, by places (N, 3) that lie on one level floor, metres, camera frame.

    up_world: unit vector (3,), what is known of up. It decides what the places do not show: those
    along one line show the slope along it alone.
    """
    from_middle = p_camera - p_camera.mean(axis=0)
    up = np.asarray(up_world, dtype=np.float64)
    for _ in range(STEPS):
        tilts = np.linalg.svd(up[None])[2][1:]  # (2, 3) directions across up
        rows = np.concatenate([from_middle @ tilts.T / LEVEL_M, tilts.T / LEAN_RAD])
        off = np.concatenate([from_middle @ up / LEVEL_M, (up - up_world) / LEAN_RAD])
        up = up - np.linalg.lstsq(rows, off, rcond=None)[0] @ tilts
        up = up / np.linalg.norm(up)
    return up


def up_from_standing(
    skeleton: Skeleton, motion: Trajectory, stances: Sequence[Pin]
) -> Array | None:
    """Unit vector (3,) up while a person stands; None where nobody does.

    motion: camera frame, metres.  stances: feet that stand still, whole, within it.
    """
    if not stances:
        return None
    Ts = motion.transforms(skeleton)
    standing = _standing(stances, motion) & (_bend_rad(skeleton, motion) < MOST_BEND_RAD)
    body, ahead = _upright(skeleton, Ts, standing)
    if body is None or body @ LEVEL_CAMERA < np.cos(MOST_LEAN_RAD):
        return None
    places = np.array([_place(skeleton, Ts, stance, motion.first_frame) for stance in stances])
    from_middle = places - places.mean(axis=0)
    # unknown: up's x and z beside (0, −1, 0), and by how much the person leans forward
    up, lean = LEVEL_CAMERA, USUAL_FORWARD_RAD
    ways = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    scale = np.array([UPRIGHT_ACROSS_RAD, UPRIGHT_ALONG_RAD])
    for _ in range(STEPS):
        rows = np.concatenate([
            np.column_stack([from_middle @ ways.T, np.zeros(len(places))]) / LEVEL_M,
            np.column_stack([np.eye(2), ways @ ahead]) / scale[:, None],
            np.diag(1 / np.array([ROLL_RAD, TILT_RAD, FORWARD_LEAN_RAD])),
        ])  # fmt: skip
        off = np.concatenate([
            from_middle @ up / LEVEL_M,
            (ways @ (up + lean * ahead - body)) / scale,
            [up[0] / ROLL_RAD, up[2] / TILT_RAD, (lean - USUAL_FORWARD_RAD) / FORWARD_LEAN_RAD],
        ])  # fmt: skip
        step = np.linalg.lstsq(rows, off, rcond=None)[0]
        up, lean = up - step[:2] @ ways, lean - step[2]
        up = up / np.linalg.norm(up)
    return np.asarray(up)


def leaning_rad(skeleton: Skeleton, motion: Trajectory, up_world: Array) -> float:
    """Return how far the line from feet to shoulders usually is from up; 0 without these."""
    everywhere = np.ones(len(motion), dtype=np.bool_)
    body, _ = _upright(skeleton, motion.transforms(skeleton), everywhere)
    return 0.0 if body is None else float(np.arccos(np.clip(body @ up_world, -1.0, 1.0)))


def _standing(stances: Sequence[Pin], motion: Trajectory) -> NDArray[np.bool_]:
    """(N,) True where a foot stands."""
    there = np.zeros(len(motion), dtype=np.bool_)
    for stance in stances:
        there[_rows(stance, motion.first_frame)] = True
    return there


def _bend_rad(skeleton: Skeleton, motion: Trajectory) -> Array:
    """(N,) by how much the less bent of the knees is bent; 0 of a body without."""
    shins = [i for i, name in enumerate(skeleton.body.names) if name in KNEES]
    if not shins:
        return np.zeros(len(motion))
    straight = motion.Rs_parent_part[:, shins, 1, 1]  # of the shin's length along the thigh's
    return np.asarray(np.arccos(np.clip(straight, -1.0, 1.0)).min(axis=1))


def _upright(
    skeleton: Skeleton, Ts: Array, standing: NDArray[np.bool_]
) -> tuple[Array | None, Array]:
    """The direction (3,) from the feet to the upper arms, the median of what stands, and the mean
    of where the body faces then; None without feet and arms."""
    names = skeleton.body.names
    feet, arms = (
        [i for i, name in enumerate(names) if name.endswith(end)] for end in ("foot", "upper_arm")
    )
    if not feet or not arms or not standing.any():
        return None, np.zeros(3)
    p = Ts[standing, :, :3, 3]
    along = p[:, arms].mean(axis=1) - p[:, feet].mean(axis=1)
    usual = np.median(along / np.linalg.norm(along, axis=1, keepdims=True), axis=0)
    faced = Ts[standing, 0, :3, :3] @ np.array(AHEAD_PART)
    return usual / np.linalg.norm(usual), faced.mean(axis=0)


def _place(skeleton: Skeleton, Ts: Array, stance: Pin, first_frame: int) -> Array:
    """(3,) where a foot stands: the median of its joint, as drafts turn feet less surely."""
    joint = Ts[_rows(stance, first_frame), skeleton.body.index(stance.part), :3, 3]
    return np.asarray(np.median(joint, axis=0))


def _rows(stance: Pin, first_frame: int) -> slice:
    return slice(stance.first_frame - first_frame, stance.last_frame + 1 - first_frame)
