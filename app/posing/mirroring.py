"""Left and right exchanged."""

from __future__ import annotations

import numpy as np

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array

_FLIP = np.array([[1.0, -1.0, -1.0], [-1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]])
"""S R S with S = diag(−1, 1, 1), element by element: a rotation seen in the mirror."""


def mirror_pose(skeleton: Skeleton, pose: Pose) -> Pose:
    """The pose with left and right exchanged, mirrored in the root's own sagittal plane.

    The root keeps its place and its direction: its mirror image in its own plane is itself.
    """
    order = [skeleton.body.index(skeleton.body.mirror_of(name)) for name in skeleton.body.names]
    Rs: Array = pose.Rs_parent_part[order] * _FLIP
    Rs[0] = pose.Rs_parent_part[0]
    return Pose(Rs, pose.p_camera_root)


def with_other_side(skeleton: Skeleton, pose: Pose, part: str) -> Pose:
    """The pose in which the part on the other side does what this part does, mirrored.

    A part of the middle has no other side; then the pose stays.
    """
    body = skeleton.body
    own, other = body.index(part), body.index(body.mirror_of(part))
    if own == other:
        return pose
    Rs = pose.Rs_parent_part.copy()
    Rs[other] = Rs[own] * _FLIP
    return Pose(Rs, pose.p_camera_root)
