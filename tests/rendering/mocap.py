"""Recorded motions carried over to the 16-part bodies.

The recordings are joint positions in metres, y up. They are not part of the project: without them
the functions raise FileNotFoundError, and tests carry the mark `needs_mocap`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from tests.rendering.bones import about_x, frame_along, hinge_angle, hinge_axis, unit, without_z
from tests.rendering.ground import lowest_sole
from tests.rendering.other_names import HEAD_M, JUMPING_JACKS, PIROUETTE

Floats = NDArray[np.float64]
Joints = dict[str, Floats]

FOLDER = Path(__file__).parents[2].parent / "shared/data/mocap"

needs_mocap = pytest.mark.skipif(
    not (FOLDER / "cmu_02_01.npz").is_file(), reason="the recorded motions are not here"
)


def walk(skeleton: Skeleton, frames: int = 76, constrained: bool = True) -> Trajectory:
    """A person walks across the picture from right to left, 30 frames a second."""
    joints = _recorded("cmu_02_01", every=2, frames=frames, yaw=1.15)
    return _placed(skeleton, joints, constrained, p_middle=(0.05, 0.95, 5.7))


def jump(skeleton: Skeleton, frames: int = 121, constrained: bool = True) -> Trajectory:
    """A person crouches and jumps, seen at an angle, 60 frames a second."""
    joints = _recorded("cmu_02_04", every=1, frames=frames, yaw=0.6)
    return _placed(skeleton, joints, constrained, p_middle=(0.0, 1.20, 6.7))


def wash(skeleton: Skeleton, frames: int = 121, constrained: bool = True) -> Trajectory:
    """A person washes arms and legs, bends down twice and rises, 30 frames a second."""
    joints = _recorded("cmu_02_10", every=2, frames=frames, yaw=0.35, first=330)
    return _placed(skeleton, joints, constrained, p_middle=(0.0, 0.92, 5.4))


def pirouette(skeleton: Skeleton, frames: int = 121, constrained: bool = True) -> Trajectory:
    """A person steps, spins twice about, the fastest 10° a frame, and lands, 60 frames a second."""
    joints = _recorded("pirouette", 1, frames, yaw=2.0, first=55, names=PIROUETTE)
    return _placed(skeleton, joints, constrained, p_middle=(0.0, 0.94, 5.4))


def jumping_jacks(skeleton: Skeleton, frames: int = 113, constrained: bool = True) -> Trajectory:
    """A person jumps on the spot, arms and legs apart and together, 30 frames a second."""
    joints = _recorded("ad_jumping_jacks", 1, frames, yaw=0.25, first=12, names=JUMPING_JACKS)
    return _placed(skeleton, joints, constrained, p_middle=(0.0, 0.98, 6.2))


def _recorded(
    name: str,
    every: int,
    frames: int,
    yaw: float,
    first: int = 0,
    names: Mapping[str, str] | None = None,
) -> Joints:
    """Joint positions (N, 3) by name, turned into the camera's axes; yaw 0 faces the camera.

    first: recorded frame from which on; names: ours by theirs, theirs are ours when left out.
    """
    with np.load(FOLDER / f"{name}.npz") as data:
        shown = slice(first, first + every * frames, every)
        xyz, theirs = data["xyz"][shown].astype(np.float64), data["names"].tolist()
        upward = data["R_global"][shown, ..., 1].astype(np.float64)
    R_camera_world = Rotation.from_euler("y", yaw).as_matrix() @ np.diag([1.0, -1.0, -1.0])
    turned, up = xyz @ R_camera_world.T, upward @ R_camera_world.T
    ours = names or {joint: joint for joint in theirs}
    joints = {ours[joint]: turned[:, i] for i, joint in enumerate(theirs) if joint in ours}
    if "head" not in joints:
        joints["head"] = joints["upperneck"] + HEAD_M * up[:, theirs.index("head")]
    return joints


def _placed(
    skeleton: Skeleton,
    joints: Joints,
    constrained: bool,
    p_middle: tuple[float, float, float],
) -> Trajectory:
    """The fitted motion, its path's middle over p_middle, which lies on the ground."""
    Rs = fitted(skeleton, joints, constrained)
    index = skeleton.body.index
    hips = (joints["lhipjoint"] + joints["rhipjoint"]) / 2
    thighs = skeleton.joints[[index("left_thigh"), index("right_thigh")]].mean(axis=0)
    ps = hips * _leg_ratio(skeleton, joints) - Rs[:, 0] @ thighs
    ps -= (ps.min(axis=0) + ps.max(axis=0)) / 2
    ps[:, 1] -= (ps[:, 1] + lowest_sole(skeleton, Rs)).max()
    return Trajectory(0, Rs, ps + p_middle)


def _leg_ratio(skeleton: Skeleton, joints: Joints) -> float:
    """How much longer the body's legs are than the recorded ones."""
    index = skeleton.body.index
    own = skeleton.joints[index("left_shin"), 1] + skeleton.joints[index("left_foot"), 1]
    legs = [("lhipjoint", "lfemur"), ("lfemur", "ltibia")]
    recorded = sum(np.linalg.norm(joints[b] - joints[a], axis=1).mean() for a, b in legs)
    return float(own / recorded)


def fitted(skeleton: Skeleton, joints: Joints, constrained: bool) -> Floats:
    """Rs_parent_part (N, P, 3, 3) whose bones point as the recorded ones do.

    Constrained, elbows and knees are hinges about x, the head only nods and turns, and hands, feet
    and neck stay at rest: no part moves in a way that the tracker's degrees of freedom cannot.
    """
    across = unit(joints["lhipjoint"] - joints["rhipjoint"])
    waist = frame_along(joints["root"] - joints["upperback"], across)
    shoulders = unit(joints["lclavicle"] - joints["rclavicle"])
    chest = frame_along(joints["lowerback"] - joints["lowerneck"], shoulders)
    head = frame_along(joints["upperneck"] - joints["head"], chest[:, :, 0])
    local = {"waist": waist, "chest": _in(waist, chest)}
    local["head"] = without_z(_in(chest, head)) if constrained else _in(chest, head)
    for side in ("left", "right"):
        local |= _arm(joints, side, chest, constrained) | _leg(joints, side, waist, constrained)
    at_rest = np.tile(np.eye(3), (len(waist), 1, 1))
    return np.stack([local.get(name, at_rest) for name in skeleton.body.names], axis=1)


def _arm(joints: Joints, side: str, chest: Floats, constrained: bool) -> Joints:
    s = side[0]
    upper = joints[f"{s}humerus"] - joints[f"{s}clavicle"]
    lower = joints[f"{s}radius"] - joints[f"{s}humerus"]
    names = (f"{side}_upper_arm", f"{side}_forearm")
    return _limb(names, upper, lower, -1.0, chest, constrained)


def _leg(joints: Joints, side: str, waist: Floats, constrained: bool) -> Joints:
    s = side[0]
    upper = joints[f"{s}femur"] - joints[f"{s}hipjoint"]
    lower = joints[f"{s}tibia"] - joints[f"{s}femur"]
    names = (f"{side}_thigh", f"{side}_shin")
    local = _limb(names, upper, lower, 1.0, waist, constrained)
    if not constrained:
        shin = waist @ local[names[0]] @ local[names[1]]
        toward_heel = joints[f"{s}tibia"] - joints[f"{s}foot"]
        local[f"{side}_foot"] = _in(shin, _foot(toward_heel, shin[:, :, 0]))
    return local


def _limb(
    names: tuple[str, str],
    upper: Floats,
    lower: Floats,
    sign: float,
    trunk: Floats,
    constrained: bool,
) -> Joints:
    """Local rotations of the upper and lower part of an arm (sign −1) or a leg (sign 1)."""
    R_upper = frame_along(upper, hinge_axis(upper, lower, sign, trunk[:, :, 0]))
    if constrained:
        R_bend = about_x(hinge_angle(R_upper, lower, sign))
    else:
        R_bend = _in(R_upper, frame_along(lower, R_upper[:, :, 0]))
    return {names[0]: _in(trunk, R_upper), names[1]: R_bend}


def _foot(z: Floats, x_hint: Floats) -> Floats:
    """Rotations (N, 3, 3) with z from the toes to the heel and x as near x_hint as can be."""
    z = unit(z)
    x = unit(x_hint - np.sum(x_hint * z, axis=-1, keepdims=True) * z)
    return np.stack([x, np.cross(z, x), z], axis=-1)


def _in(R_camera_a: Floats, R_camera_b: Floats) -> Floats:
    """R_a_b (N, 3, 3)."""
    return np.swapaxes(R_camera_a, 1, 2) @ R_camera_b
