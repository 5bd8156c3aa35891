"""A pose prepared for one gesture: where every part is, and how one is turned."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.app.posing.limits import (
    JointRange,
    box_of,
    fitting,
    nearest_within,
    range_of,
    resting_rotation,
)
from keypose.app.posing.vectors import unit
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, nearest_rotation


@dataclass(frozen=True, eq=False)
class GestureContext:
    """The pose before a gesture.

    Ts_camera_part: (P, 4, 4).
    limits_on:      whether joint limits count.
    posed:          the pose whose angles that are beyond a limit may stay there: the one before the
                    gesture.
    """

    skeleton: Skeleton
    pose: Pose
    Ts_camera_part: Array
    limits_on: bool
    posed: Pose

    @classmethod
    def of(
        cls, skeleton: Skeleton, pose: Pose, limits_on: bool, posed: Pose | None = None
    ) -> GestureContext:
        """posed: where the pose is one in the midst of a gesture, that before it."""
        Ts = pose_transforms(skeleton, pose)
        return cls(skeleton, pose, Ts, limits_on, pose if posed is None else posed)

    def joint(self, part: int) -> Array:
        """(3,) a part's joint in the camera frame."""
        return self.Ts_camera_part[part, :3, 3]

    def R_camera_part(self, part: int) -> Array:
        """(3, 3)."""
        return self.Ts_camera_part[part, :3, :3]

    def R_camera_parent(self, part: int) -> Array:
        """(3, 3); the camera itself for the root."""
        parent = int(self.skeleton.parents[part])
        return np.eye(3) if parent < 0 else self.Ts_camera_part[parent, :3, :3]

    def point(self, name: str) -> tuple[int, Array]:
        """A joint or landmark by name: the part it is fixed to, and where (3,) in its frame."""
        body = self.skeleton.body
        if name in body.names:
            return body.index(name), np.zeros(3)
        for i, part in enumerate(body.parts):
            if name in part.landmarks:
                return i, np.array(part.landmarks[name])
        raise KeyError(name)

    def placed(self, part: int, p_part: Array) -> Array:
        """(3,) a point of a part in the camera frame."""
        T = self.Ts_camera_part[part]
        return np.asarray(T[:3, :3] @ p_part + T[:3, 3])

    def joint_range(self, part: int) -> JointRange | None:
        """The limits that count for a part in this gesture."""
        allowed = range_of(self.skeleton.body.parts[part]) if self.limits_on else None
        return None if allowed is None else allowed.widened(self.posed.Rs_parent_part[part])

    def allowed(self, part: int, R_parent_part: Array) -> Array:
        """The nearest rotation that the limits of the part allow."""
        return nearest_within(R_parent_part, self.joint_range(part))

    def resting_direction(self, part: int, p_part_tip: Array) -> Array:
        """(3,) where a limb that begins at this part points in the middle of its joint's range.

        Unit vector in the camera frame. p_part_tip: the limb's end in the rest pose, from the
        part's joint. Without limits it is where the limb points at rest.
        """
        R = resting_rotation(self.skeleton.body.parts[part])
        return unit(self.R_camera_parent(part) @ (R @ p_part_tip))

    def turned(self, rotations: dict[int, Array]) -> Pose:
        """The pose with other rotations of some parts in their parents' frames."""
        Rs = self.pose.Rs_parent_part.copy()
        for part, R in rotations.items():
            Rs[part] = nearest_rotation(R)
        return Pose(Rs, self.pose.p_camera_root)

    def angles(self, part: int) -> Array:
        """The part's angles [x, y, z] (3,), radians, inside its limits where they can be."""
        box = box_of(self.skeleton.body.parts[part])
        return fitting(self.pose.Rs_parent_part[part], box)
