"""What lies under the pointer."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from keypose.app.posing import outline, parts_at
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.view import ViewCamera
from tests.app.posing.posing_cases import (
    CAMERA,
    DOG,
    PERSON,
    TELEPHOTO,
    bent,
    points,
    sights,
    tumbling,
    walking,
)

SKELETON = Skeleton.of(PERSON)


@pytest.mark.parametrize("camera", [CAMERA, TELEPHOTO], ids=["perspective", "telephoto"])
@pytest.mark.parametrize("pose", [walking(), tumbling()], ids=["walking", "tumbling"])
def test_the_front_part_is_the_one_that_the_picture_shows(camera: Camera, pose: Pose) -> None:
    shown = raster(
        BodyMesh.of(SKELETON), pose_transforms(SKELETON, pose), ViewCamera.of(camera)
    ).part
    rng = np.random.default_rng(1)
    edges = cv2.dilate((cv2.Laplacian(shown.astype(np.float32), -1) != 0).astype(np.uint8), None)
    v, u = np.nonzero(cv2.dilate((shown >= 0).astype(np.uint8), np.ones((9, 9))) & (edges == 0))
    view = sights(camera)["main"]
    for k in rng.integers(0, len(u), 120):
        found = parts_at(SKELETON, pose, view, (u[k], v[k]))
        part = shown[v[k], u[k]]
        assert (found[0] if found else None) == (PERSON.names[part] if part >= 0 else None)


@pytest.mark.parametrize("view", ["top", "side", "front"])
def test_the_small_views_pick_what_their_pictures_show(view: str) -> None:
    pose = walking()
    eye = ViewCamera.orthographic(view, pose.p_camera_root, 120.0, (240, 240))  # type: ignore[arg-type]
    shown = raster(BodyMesh.of(SKELETON), pose_transforms(SKELETON, pose), eye).part
    sight, middle = sights()[view], sights()[view].project(pose.p_camera_root)
    misses = 0
    for u in range(3, 240, 12):
        for v in range(3, 240, 12):
            at = middle + (np.array([u, v]) - eye.centre) / 120.0
            found = parts_at(SKELETON, pose, sight, at)
            part = shown[v, u]
            misses += (found[0] if found else None) != (PERSON.names[part] if part >= 0 else None)
    assert misses <= 2  # on an edge either answer is right


def test_parts_behind_one_another_are_listed_from_front_to_back() -> None:
    skeleton, view = Skeleton.of(DOG), sights()["side"]
    pose = bent(DOG, 1, size=0.0)
    at = view.project(points(DOG, pose)["left_front_lower_leg"])
    found = parts_at(skeleton, pose, view, at)
    # seen from the picture's right, along −x, what has the larger x is in front
    assert set(found[:2]) == {"left_front_lower_leg", "left_front_upper_leg"}
    assert set(found[2:]) == {"right_front_lower_leg", "right_front_upper_leg"}
    assert parts_at(skeleton, pose, view, at + 5.0) == ()


@pytest.mark.parametrize("view", ["main", "top", "side", "front"])
def test_an_outline_goes_around_all_points_at_which_the_part_is_hit(view: str) -> None:
    pose, sight = walking(), sights()[view]
    for part in ("chest", "right_foot"):
        corners = outline(SKELETON, pose, sight, part)
        low, high = corners.min(axis=0), corners.max(axis=0)
        for share in np.random.default_rng(2).uniform(-0.2, 1.2, (60, 2)):
            at = low + share * (high - low)
            side = cv2.pointPolygonTest(corners.astype(np.float32), at.tolist(), True)
            if abs(side) > 1e-3 * np.abs(high - low).max():
                assert (part in parts_at(SKELETON, pose, sight, at)) == (side > 0)


def test_what_is_behind_the_camera_is_not_picked_and_has_no_outline() -> None:
    pose = Pose(walking().Rs_parent_part, np.array([0.0, 0.0, -3.0]))
    middle = (CAMERA.cx, CAMERA.cy)
    assert parts_at(SKELETON, pose, sights()["main"], middle) == ()
    assert outline(SKELETON, pose, sights()["main"], "chest").shape == (0, 2)
