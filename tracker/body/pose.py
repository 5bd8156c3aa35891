"""Pose of a body, forward kinematics and the twist Jacobian (DRIFT §2.1, §2.3, appendix 1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import (
    Array,
    exp_rotation,
    frozen,
    nearest_rotation,
    transform,
)


@dataclass(frozen=True, eq=False)
class Pose:
    """Where every part of a body is: a root position and the rotation of each part.

    Rs_parent_part: (P, 3, 3) rotation of each part in its parent's frame (the root's: camera's).
    p_camera_root:  (3,) origin of the root part in the camera frame, metres.
    """

    Rs_parent_part: Array
    p_camera_root: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "Rs_parent_part", frozen(self.Rs_parent_part))
        object.__setattr__(self, "p_camera_root", frozen(self.p_camera_root))

    def writable(self) -> tuple[Array, Array]:
        """Writable copies of both arrays: the loops are compiled for that kind only."""
        return self.Rs_parent_part.copy(), self.p_camera_root.copy()

    def carried(self, T: Array) -> Pose:
        """The pose in another frame: T (4, 4) of that frame and this one."""
        R = self.Rs_parent_part.copy()
        R[0] = T[:3, :3] @ R[0]
        return Pose(R, T[:3, :3] @ self.p_camera_root + T[:3, 3])

    @classmethod
    def rest(cls, skeleton: Skeleton, p_camera_root: tuple[float, float, float]) -> Pose:
        """The rest pose, its root at the given place."""
        return cls(np.tile(np.eye(3), (skeleton.part_count, 1, 1)), np.array(p_camera_root))


def part_transforms(skeleton: Skeleton, Rs_parent_part: Array, p_camera_root: Array) -> Array:
    """Ts_camera_part (..., P, 4, 4): H_i = T_1 … T_i for every part, over any batch axes.

    Rs_parent_part (..., P, 3, 3) and p_camera_root (..., 3) as in Pose.  DRIFT (1)
    """
    T = transform(Rs_parent_part, np.broadcast_to(skeleton.joints, Rs_parent_part.shape[:-1]))
    T[..., 0, :3, 3] = p_camera_root
    for i, parent in enumerate(skeleton.parents):
        if parent >= 0:
            T[..., i, :, :] = T[..., parent, :, :] @ T[..., i, :, :]
    return T


def pose_transforms(skeleton: Skeleton, pose: Pose) -> Array:
    """Ts_camera_part (P, 4, 4) of one pose."""
    return part_transforms(skeleton, pose.Rs_parent_part, pose.p_camera_root)


def joint_names(skeleton: Skeleton) -> tuple[str, ...]:
    """Names of `joint_positions`: the parts (each at its own joint), then all landmarks."""
    landmarks = [name for part in skeleton.body.parts for name in part.landmarks]
    return (*skeleton.body.names, *landmarks)


def joint_positions(skeleton: Skeleton, Ts_camera_part: Array) -> Array:
    """Joints and landmarks (..., J, 3) in the camera frame, metres, in the order of joint_names."""
    points = [Ts_camera_part[..., :, :3, 3]]
    for i, part in enumerate(skeleton.body.parts):
        for p_part in part.landmarks.values():
            T = Ts_camera_part[..., i, :, :]
            points.append((T[..., :3, :3] @ np.array(p_part) + T[..., :3, 3])[..., None, :])
    return np.concatenate(points, axis=-2)


def twists(skeleton: Skeleton, Ts_camera_part: Array) -> Array:
    """Camera-frame twist (..., D, 6) of every degree of freedom: [velocity at origin, turn].

    A point p that the degree of freedom moves has the velocity v + w × p, which is
    H_j K_a H_j⁻¹ p for a translation and H_j N_a H_j⁻¹ p for a rotation about axis a of part j
    (DRIFT appendix 1; its N_x and N_z are printed exchanged).
    """
    T = Ts_camera_part[..., skeleton.dof_part, :, :]
    take = skeleton.dof_axis.reshape(-1, 1, 1)
    axis = np.take_along_axis(T[..., :3, :3], np.broadcast_to(take, (*T.shape[:-2], 3, 1)), -1)
    axis, turns = axis[..., 0], (skeleton.dof_turns == 1)[:, None]
    velocity = np.where(turns, np.cross(T[..., :3, 3], axis), axis)
    return np.concatenate([velocity, np.where(turns, axis, 0.0)], axis=-1)


def moved(skeleton: Skeleton, pose: Pose, motion: Array) -> Pose:
    """The pose after a motion x (D,), composed on the right in each part's own frame.  DRIFT (2)

    Rotations of one part are one exponential, which agrees with DRIFT's Euler product to first
    order and, unlike it, has no preferred order.
    """
    turn = np.zeros((skeleton.part_count, 3))
    shift = np.zeros(3)
    turns = skeleton.dof_turns == 1
    turn[skeleton.dof_part[turns], skeleton.dof_axis[turns]] = motion[turns]
    shift[skeleton.dof_axis[~turns]] = motion[~turns]
    return Pose(
        nearest_rotation(pose.Rs_parent_part @ exp_rotation(turn)),
        pose.p_camera_root + pose.Rs_parent_part[0] @ shift,
    )
