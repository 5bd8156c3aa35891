"""Where a body stands before anyone has posed it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.upright import CAMERA_UP, view_rotations
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, apply_transform

FILLED_HEIGHT = 0.70
"""Share of the picture's height that the body takes at first."""

FILLED_WIDTH = 0.85
"""The most of the width that it may take for that."""

_NEAREST_M, _FARTHEST_M = 0.1, 1000.0
_ROUNDS, _EXACT_M = 30, 1e-9


def opening_pose(body: Body, camera: Camera, up_camera: ArrayLike = CAMERA_UP) -> Pose:
    """The rest pose upright before the camera, in the middle of the picture, wholly in it."""
    skeleton = Skeleton.of(body)
    R_camera_root = view_rotations(up_camera)["front"].T
    rest = Pose.rest(skeleton, (0.0, 0.0, 0.0))
    Rs = rest.Rs_parent_part.copy()
    Rs[0] = R_camera_root
    Ts = pose_transforms(skeleton, Pose(Rs, rest.p_camera_root))
    points = np.concatenate(
        [
            apply_transform(T, part.shape.mesh().vertices)
            for part, T in zip(body.parts, Ts, strict=True)
        ]
    )
    view = PointerView.of(camera)
    assert view.camera is not None
    place = _centred(points, view, _distance(points, view.camera))
    return Pose(Rs, place)


def _distance(points: Array, camera: Camera) -> float:
    """The depth of the root at which the body fills as much of the picture as it should."""
    if camera.telephoto_distance_m is not None:
        return camera.telephoto_distance_m
    view = PointerView.of(camera)
    near = _NEAREST_M - min(float(points[:, 2].min()), 0.0)  # the root too is before the camera

    def left(depth: float) -> float:
        """The share of the room that is left: nearly a line over depth, which a secant meets in a
        few rounds."""
        return 1.0 / _filled(points + _centred(points, view, depth), view) - 1.0

    before, depth = near, near + 1.0
    left_before = left(before)
    if left_before >= 0:
        return near
    for _ in range(_ROUNDS):
        left_now = left(depth)
        rise = (left_now - left_before) / (depth - before)
        before, left_before = depth, left_now
        depth = min(max(depth - left_now / rise, near), near + _FARTHEST_M)
        if abs(depth - before) < _EXACT_M:
            break
    return depth


def _filled(points: Array, view: PointerView) -> float:
    """1 where the body is as large as it may be."""
    assert view.camera is not None
    size = np.ptp(view.project(points), axis=0)
    width = float(size[0]) / (FILLED_WIDTH * view.camera.width)
    return max(width, float(size[1]) / (FILLED_HEIGHT * view.camera.height))


def _centred(points: Array, view: PointerView, depth: float) -> Array:
    """(3,) the root's place at this depth that puts the body in the middle of the picture."""
    assert view.camera is not None
    middle = np.array([view.camera.width - 1, view.camera.height - 1]) / 2
    place = view.at_depth(middle, np.array([0.0, 0.0, depth]))
    for _ in range(8):
        at = view.project(points + place)
        off = middle - (at.min(axis=0) + at.max(axis=0)) / 2
        place = view.at_depth(view.project(place) + off, place)
    return place
