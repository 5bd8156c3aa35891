"""Place a body that nobody has posed, turn it to face a way, and say what is up.

A view's frame is x right, y down, z away, as the camera's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from keypose.app.posing.angles import with_rotation
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.vectors import across, cross, length, unit
from keypose.tracker.body.body import Body
from keypose.tracker.body.heading import CAMERA_UP
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import (
    Array,
    apply_transform,
    exp_rotation,
    frozen,
    nearest_rotation,
)
from keypose.tracker.geometry.view import ViewName


def view_rotations(up_camera: ArrayLike = CAMERA_UP) -> dict[ViewName, Array]:
    """R_view_camera (3, 3) of the three small views, for a direction that is up.

    The front view looks horizontally, along the camera's optical axis as far as that can be. The
    top view looks down with the far side up, the side view from the right with the far side right.
    """
    down = -unit(np.asarray(up_camera, dtype=np.float64))
    away = across(np.array([0.0, 0.0, 1.0]), down)
    if length(away) < 1e-6:  # the camera looks straight up or down: its own up direction decides
        away = across(np.array([0.0, 1.0 if down[2] < 0 else -1.0, 0.0]), down)
    away = unit(across(unit(away), down))  # once more: what is left of a short one is inexact
    right = cross(down, away)
    return {
        "top": frozen([right, -away, down]),
        "side": frozen([away, down, -right]),
        "front": frozen([right, down, away]),
    }


def eye_rotation(azimuth_deg: float, elevation_deg: float) -> Array:
    """R_eye_level (3, 3): how an eye going round a level world looks: right, down, away.

    The level frame is that of the front view. An azimuth of 0 looks as the front view does, 90 from
    the right of it as the side view, 180 from behind; an elevation of 90 looks straight down.
    """
    a, e = math.radians(azimuth_deg), math.radians(elevation_deg)
    right = np.array([math.cos(a), 0.0, math.sin(a)])
    away = np.array([-math.sin(a) * math.cos(e), math.sin(e), math.cos(a) * math.cos(e)])
    return np.array([right, np.cross(away, right), away])


def up_from_vertical(camera: Camera, a: Sequence[float], b: Sequence[float]) -> Array:
    """(3,) the up direction, given by a line drawn from pixel a to b along something upright.

    One line does not show how far the camera is tilted: every direction in the plane through the
    line and the camera projects along it. Of these the nearest to the picture's own up is taken,
    so the tilt is the least there can be. The order of the ends does not matter.
    """
    view = PointerView.of(camera)
    start, start_ray = view.ray(a)
    end, end_ray = view.ray(b)
    across_line = (
        cross(start_ray, end_ray) if view.is_perspective else cross(end - start, start_ray)
    )
    if length(across_line) < 1e-12:
        raise CameraError("A vertical needs a line: its two ends are the same point.")
    return frozen(unit(_within(np.array(CAMERA_UP), unit(across_line))))


def _within(up: Array, normal: Array) -> Array:
    """`up` turned into the plane; along the picture's right where it stands at right angles."""
    direction = across(up, normal)
    return direction if length(direction) > 1e-9 else across(np.array([1.0, 0.0, 0.0]), normal)


def tilt_and_roll(up_camera: ArrayLike) -> tuple[float, float]:
    """Degrees by which the camera looks up (tilt), and by which up leans right in it (roll)."""
    x, y, z = (float(v) for v in unit(np.asarray(up_camera, dtype=np.float64)))
    tilt = math.degrees(math.asin(min(max(z, -1.0), 1.0)))
    return tilt + 0.0, math.degrees(math.atan2(x, -y)) + 0.0


Way: TypeAlias = Literal["camera", "away", "left", "right"]
"""Left and right are those of the picture."""

_LEVEL = 1e-3
"""A chest whose direction is this steep has none along the ground."""


def facing(pose: Pose, direction: Way, up_camera: ArrayLike = CAMERA_UP) -> Pose:
    """The body turned about the up direction through its root until it faces this way.

    Its lean, its place and what the limbs do stay as they are.
    """
    right, down, away = view_rotations(up_camera)["front"]
    wanted = {"camera": -away, "away": away, "left": -right, "right": right}[direction]
    R_camera_root = pose.Rs_parent_part[0]
    now = _ahead(R_camera_root, -down)
    angle = math.atan2(float(cross(now, wanted) @ -down), float(now @ wanted))
    return with_rotation(pose, 0, nearest_rotation(exp_rotation(-down * angle) @ R_camera_root))


def _ahead(R_camera_root: Array, up: Array) -> Array:
    """(3,) where the body faces along the ground; one that lies on its front, where its head is."""
    ahead, top = -R_camera_root[:, 2], -R_camera_root[:, 1]
    level = across(ahead, up)
    if length(level) < _LEVEL:
        level = across(top if ahead @ up < 0 else -top, up)
    return np.asarray(unit(level))


FILLED_HEIGHT = 0.70
"""Share of the picture's height that the body takes at first."""

FILLED_WIDTH = 0.85
"""The most of the width that it may take for that."""

_NEAREST_M = 0.1
_FARTHEST_M = 1000.0
_ROUNDS = 30
_EXACT_M = 1e-9
"""The nearest distance, and how much farther away a body may be; it is looked for in so many rounds
at most, until it changes by less."""


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
        return 1.0 / _filling_picture(points + _centred(points, view, depth), view) - 1.0

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


def _filling_picture(points: Array, view: PointerView) -> float:
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
