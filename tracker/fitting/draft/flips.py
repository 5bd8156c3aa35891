"""Whether a limb may point the other way: toward the camera instead of away from it.

In the picture both look the same: the far joint of a bone lies on its ray, at either of the two
places as far from the near joint as the bone is long. What tells them apart is the depth that the
network sees, and what joints can do.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from tracker.body.joint_limits import Limits
from tracker.body.trajectory import Trajectory
from tracker.fitting.draft.first_poses import hinged
from tracker.fitting.draft.limbs import Joints, Limb
from tracker.fitting.draft.whole import LIMIT_RAD
from tracker.geometry.camera import Camera
from tracker.geometry.rotations import Array, transpose
from tracker.solver.robust import Huber

DEPTH_M = 0.1
"""Standard deviation of a joint's depth as the network sees it."""
TELLING_M = 0.10
"""A limb whose joints would move by less in depth is in the picture's plane: no matter."""


def flip_odds(joints: Joints, camera: Camera, told_m: Array, motion: Trajectory) -> Array:
    """(N, 4) by limb: how likely the best of its other poses is beside the one it has, 0 to 1.

    told_m (N, 12): how much farther than the root the network sees each joint of the N frames.
    camera: without distortion.
    """
    Ts = motion.transforms(joints.skeleton)
    p = joints.points.at(Ts)
    told_z = told_m + motion.ps_camera_root[:, 2:]
    odds = [_limb_odds(joints, limb, camera, p, told_z, motion, Ts) for limb in joints.limbs]
    return np.stack(odds, axis=1)


def _limb_odds(
    joints: Joints, limb: Limb, camera: Camera, p: Array, told_z: Array, motion: Trajectory,
    Ts: Array,
) -> Array:  # fmt: skip
    near, middle, far = limb.upper.near, limb.upper.far, limb.lower.far
    ends = [middle, far]
    now = _cost(joints, limb, p, told_z, motion, Ts)
    best = np.full(len(p), np.inf)
    for flip_upper, flip_lower in list(product((False, True), repeat=2))[1:]:
        other = p.copy()
        if flip_upper:
            other[:, middle] = _other_way(camera, p[:, near], p[:, middle])
            length = joints.length_m(limb.lower)
            other[:, far] = _at_length(camera, other[:, middle], p[:, far], length, flip_lower)
        elif flip_lower:
            other[:, far] = _other_way(camera, p[:, middle], p[:, far])
        moved = np.abs(other[:, ends, 2] - p[:, ends, 2]).max(axis=1)
        cost = _cost(joints, limb, other, told_z, motion, Ts)
        best = np.minimum(best, np.where(moved > TELLING_M, cost, np.inf))
    return np.asarray(np.minimum(np.exp(now - best), 1.0))


def _other_way(camera: Camera, near: Array, far: Array) -> Array:
    """(N, 3) the other point on the ray of the far joints that is as far from the near ones."""
    if camera.telephoto_distance_m is not None:
        return np.stack([far[:, 0], far[:, 1], 2 * near[:, 2] - far[:, 2]], axis=1)
    share = 2 * (far * near).sum(1) / (far**2).sum(1) - 1
    return np.asarray(far * share[:, None])


def _at_length(camera: Camera, near: Array, far: Array, length: float, deeper: bool) -> Array:
    """(N, 3) the point on the ray of `far` at a length from the near joints, the deeper one or the
    nearer one; the nearest on the ray where it is not that long."""
    if camera.telephoto_distance_m is not None:
        flat = ((far - near)[:, :2] ** 2).sum(1)
        rest = np.sqrt(np.maximum(length**2 - flat, 0.0))
        z = near[:, 2] + (rest if deeper else -rest)
        return np.stack([far[:, 0], far[:, 1], z], axis=1)
    ray = far / np.linalg.norm(far, axis=1, keepdims=True)
    along = (ray * near).sum(1)
    rest = np.sqrt(np.maximum(length**2 - (near**2).sum(1) + along**2, 0.0))
    return np.asarray(ray * (along + (rest if deeper else -rest))[:, None])


def _cost(
    joints: Joints, limb: Limb, p: Array, told_z: Array, motion: Trajectory, Ts: Array
) -> Array:
    """(N,) of a limb with its joints at p: its depths and its joints' limits."""
    ends = [limb.upper.far, limb.lower.far]
    away = np.abs(p[:, ends, 2] - told_z[:, ends]) / DEPTH_M
    H = Ts[..., :3, :3]
    upper, lower = hinged(limb, p, H[:, limb.upper.part])
    above = H[:, joints.skeleton.parents[limb.upper.part]]
    Rs = motion.Rs_parent_part.copy()
    Rs[:, limb.upper.part] = transpose(above) @ upper
    Rs[:, limb.lower.part] = transpose(upper) @ lower
    outside, _ = Limits.of(joints.skeleton.body).excess(Rs)
    over = (outside[:, [limb.upper.part, limb.lower.part]] / LIMIT_RAD) ** 2
    return np.asarray(0.5 * (Huber().loss(away).sum(1) + over.sum((1, 2))))
