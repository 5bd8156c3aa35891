"""Mirror a pose, or swap its left and right where they are seen.

The picture stays, as far as the joints allow, and the body in it becomes another one: seen from the
side it steps with the other foot, seen from the front it turns its back. Unlike a mirrored pose,
which is another picture of the same sides.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.solver.fit_joints import fit_picture
from keypose.tracker.solver.posed import BodyPoint, BodyPoints

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
    own, mirrored = body.index(part), body.index(body.mirror_of(part))
    if own == mirrored:
        return pose
    Rs = pose.Rs_parent_part.copy()
    Rs[mirrored] = Rs[own] * _FLIP
    return Pose(Rs, pose.p_camera_root)


HALF_TURN = np.array([0.0, np.pi, 0.0])
"""About the root's own y."""


def swap_left_right(skeleton: Skeleton, camera: Camera, pose: Pose) -> Pose:
    """The pose whose left joints are seen where the right ones of this pose are, and so on.

    Of poses that are seen alike it is the best of those found from this pose, its mirror image and
    both of them turned around; its distance stays about the same.
    """
    places, others = _pairs(skeleton.body)
    uv = camera.project(BodyPoints(skeleton, others).at(pose_transforms(skeleton, pose)))
    flipped = mirror_pose(skeleton, pose)
    starts = [pose, flipped, _turned(pose), _turned(flipped)]
    weights = np.ones(len(places))
    return fit_picture(skeleton.body, camera, places, uv, weights, starts, pose).pose


def _turned(pose: Pose) -> Pose:
    Rs: Array = pose.Rs_parent_part.copy()
    Rs[0] = Rs[0] @ exp_rotation(HALF_TURN)
    return Pose(Rs, pose.p_camera_root)


def _pairs(body: Body) -> tuple[tuple[BodyPoint, ...], tuple[BodyPoint, ...]]:
    """Every joint and landmark, and beside it the one on the other side.

    Landmarks of two sides belong together by their order, and only where both have as many.
    """
    pairs: list[tuple[BodyPoint, BodyPoint]] = []
    for i, part in enumerate(body.parts):
        k = body.index(body.mirror_of(part.name))
        origin = (0.0, 0.0, 0.0)
        pairs.append((((i, origin),), ((k, origin),)))
        own, mirrored = (list(p.landmarks.values()) for p in (part, body.parts[k]))
        if len(own) == len(mirrored):
            pairs += [(((i, a),), ((k, b),)) for a, b in zip(own, mirrored, strict=True)]
    return tuple(a for a, _ in pairs), tuple(b for _, b in pairs)
