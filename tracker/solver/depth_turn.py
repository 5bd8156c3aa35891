"""A limb, or the whole body, turned in depth: what points toward the camera points away from it.

A picture gives depth only up to this mirror image. Every bone is mirrored at the plane across the
view; what cannot be mirrored, the handedness of each part, goes into an axis the bones do not show:
of the trunk front and back, of a limb left and right, so that elbows and knees bend as before.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.body.modify import height
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.fit_joints import fit_picture
from keypose.tracker.solver.posed import joints_and_landmarks

TRUNK = ("waist", "chest", "neck", "head")
FLAT_LIMB = np.diag([-1.0, 1.0, 1.0])
FLAT_TRUNK = np.diag([1.0, 1.0, -1.0])


def turned_in_depth(skeleton: Skeleton, camera: Camera, pose: Pose, top: int) -> Pose:
    """The pose with part `top` and all below it mirrored in depth, seen about where it was.

    Of the mirrored poses with hands, feet and head mirrored too, or as they stood to their
    forearm, shin or neck, the one whose joints bend most as they can.
    """
    points = joints_and_landmarks(skeleton)
    places, uv = points.points, camera.project(points.at(pose_transforms(skeleton, pose)))
    starts = [_mirrored(skeleton, pose, top, ends) for ends in (True, False)]
    mirrored = fit_picture(skeleton.body, camera, places, uv, np.ones(len(places)), starts).pose
    if top == 0:
        return mirrored
    Rs = np.where(skeleton.below[:, top, None, None], mirrored.Rs_parent_part, pose.Rs_parent_part)
    return Pose(Rs, pose.p_camera_root)


def _mirrored(skeleton: Skeleton, pose: Pose, top: int, ends: bool) -> Pose:
    """Mirrored about its uppermost joint. ends: whether the last parts of limbs are, too."""
    below = skeleton.below[:, top]
    T = pose_transforms(skeleton, pose)
    ray = T[top, :3, 3] / np.linalg.norm(T[top, :3, 3])
    mirror = np.eye(3) - 2 * np.outer(ray, ray)
    is_last = ~np.isin(np.arange(skeleton.part_count), skeleton.parents)
    Hs, Rs = T[:, :3, :3].copy(), pose.Rs_parent_part.copy()
    for i in np.flatnonzero(below):
        parent = skeleton.parents[i]
        above = np.eye(3) if parent < 0 else Hs[parent]
        if ends or not is_last[i] or i == top:
            Hs[i] = mirror @ T[i, :3, :3] @ _flat(skeleton, i)
            Rs[i] = above.T @ Hs[i]
        else:
            Hs[i] = above @ Rs[i]
    return Pose(Rs, pose.p_camera_root)


def _flat(skeleton: Skeleton, part: np.intp) -> Array:
    return FLAT_TRUNK if skeleton.body.names[part] in TRUNK else FLAT_LIMB


def turns_round(skeleton: Skeleton, pose: Pose, turned: Pose, top: int) -> bool:
    """Whether part `top` and what hangs on it really is the other way round: joints that
    cannot bend so far may have kept it as it was.
    """
    return bool(depths_m(skeleton, pose, top) @ depths_m(skeleton, turned, top) <= 0)


def strays(skeleton: Skeleton, camera: Camera, pose: Pose, turned: Pose, top: int) -> float:
    """How far from where it was seen a joint of part `top`, or of what hangs on it, came to
    lie at most: a share of the body's height in the picture, infinite behind the camera.
    """
    points = joints_and_landmarks(skeleton)
    inside = skeleton.below[np.array([place[0][0] for place in points.points]), top]
    uv, others = (camera.project(points.at(pose_transforms(skeleton, p))) for p in (pose, turned))
    tall_px = height(skeleton.body) * camera.fy / float(camera.depth(pose.p_camera_root))
    off_px = np.nan_to_num(np.linalg.norm(uv - others, axis=-1)[inside], nan=np.inf)
    return float(off_px.max()) / tall_px


def depths_m(skeleton: Skeleton, pose: Pose, top: int) -> Array:
    """How much farther than a part's joint those that hang on it are, and their landmarks;
    of the whole body, where its limbs hang on the trunk.
    """
    points = joints_and_landmarks(skeleton)
    parts = np.array([place[0][0] for place in points.points])
    p = points.at(pose_transforms(skeleton, pose))
    ray = p[top] / np.linalg.norm(p[top])
    on_trunk = np.array([_hangs_on_trunk(skeleton, part) for part in parts])
    inside = on_trunk if top == 0 and on_trunk.any() else skeleton.below[parts, top]
    return np.asarray((p[inside] - p[top]) @ ray)


def _hangs_on_trunk(skeleton: Skeleton, part: int) -> bool:
    names, parent = skeleton.body.names, int(skeleton.parents[part])
    return parent >= 0 and names[parent] in TRUNK and names[part] not in TRUNK
