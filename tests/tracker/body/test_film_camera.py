"""Poses lie before the camera of their own frame; one class carries them to the world and back."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.film_camera import FilmCamera
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation

LENS = Camera(width=640, height=480, fx=500, fy=500, cx=319.5, cy=239.5)
TURN = exp_rotation(np.array([[0.0, 0.0, 0.0], [0.0, 0.3, 0.1], [0.2, -0.4, 0.0]]))
MOVING = FilmCamera(
    LENS,
    CameraPath.of(TURN, np.array([[0.0, 0, 0], [0.1, 0, 1], [0.5, -0.2, 2]]), np.array([1, 2, 3])),
)
STILL = FilmCamera(LENS)
POSE = Pose(exp_rotation(np.array([[0.1, 0.2, 0.3], [0.0, 0.5, 0.0]])), np.array([0.2, -0.1, 4.0]))


def test_a_point_of_the_world_is_where_the_path_says_it_is() -> None:
    p = np.array([[0.3, -0.2, 5.0], [1.0, 1.0, 6.0]])
    for frame in range(3):
        T = MOVING.T_camera_world(frame)
        seen = MOVING.points_to_camera(frame, p)
        np.testing.assert_allclose(seen, p @ T[:3, :3].T + T[:3, 3])
        np.testing.assert_allclose(MOVING.points_to_world(frame, seen), p)
        ahead = MOVING.direction_to_world(frame, (0.0, 0.0, 1.0))
        np.testing.assert_allclose(T[:3, :3] @ ahead, (0.0, 0.0, 1.0), atol=1e-12)


def test_a_pose_that_goes_to_the_world_comes_back_as_it_was() -> None:
    for frame in range(3):
        back = MOVING.pose_to_camera(frame, MOVING.pose_to_world(frame, POSE))
        np.testing.assert_allclose(back.Rs_parent_part, POSE.Rs_parent_part, atol=1e-12)
        np.testing.assert_allclose(back.p_camera_root, POSE.p_camera_root, atol=1e-12)


def test_what_is_seen_at_another_frame_is_the_same_place_of_the_world() -> None:
    seen = MOVING.pose_seen_at(2, 1, POSE)
    there, here = MOVING.pose_to_world(2, seen), MOVING.pose_to_world(1, POSE)
    np.testing.assert_allclose(there.p_camera_root, here.p_camera_root, atol=1e-12)
    np.testing.assert_allclose(there.Rs_parent_part, here.Rs_parent_part, atol=1e-12)


def test_poses_parts_and_motions_are_carried_alike() -> None:
    motion = Trajectory(1, np.stack([POSE.Rs_parent_part] * 2), np.stack([POSE.p_camera_root] * 2))
    in_world = MOVING.motion_to_world(motion)
    by_frame = MOVING.poses_to_world({1: POSE, 2: POSE})
    Ts = np.tile(np.eye(4), (2, 1, 1))
    Ts[:, :3, 3] = POSE.p_camera_root
    parts = MOVING.parts_to_world(Ts, [1, 2])
    for row, frame in enumerate((1, 2)):
        placed = by_frame[frame]
        np.testing.assert_allclose(in_world.ps_camera_root[row], placed.p_camera_root)
        np.testing.assert_allclose(in_world.Rs_parent_part[row], placed.Rs_parent_part)
        np.testing.assert_allclose(parts[row, :3, 3], placed.p_camera_root)
    eyes = MOVING.eyes(motion)
    assert eyes is not None
    np.testing.assert_allclose(MOVING.points_to_camera(2, eyes[1]), 0.0, atol=1e-12)


@pytest.mark.parametrize(("frame", "zoom"), [(0, 1.0), (1, 2.0), (2, 3.0)])
def test_the_lens_zooms_as_the_path_says(frame: int, zoom: float) -> None:
    assert MOVING.zoom_at(frame) == zoom
    assert MOVING.at(frame).fx == pytest.approx(zoom * LENS.fx)


def test_before_a_camera_that_stands_still_everything_is_as_it_is() -> None:
    motion = Trajectory(0, POSE.Rs_parent_part[None], POSE.p_camera_root[None])
    points, Ts = np.ones((2, 3)), np.eye(4)[None]
    assert STILL.at(7) is LENS
    assert STILL.motion_to_world(motion) is motion
    assert STILL.pose_to_world(0, POSE) is STILL.pose_to_camera(0, POSE) is POSE
    assert STILL.pose_seen_at(3, 0, POSE) is POSE
    assert STILL.parts_to_world(Ts, [0]) is STILL.parts_seen_at(0, Ts, [0]) is Ts
    assert STILL.points_to_world(0, points) is STILL.points_to_camera(0, points) is points
    assert STILL.eyes(motion) is None
    np.testing.assert_array_equal(STILL.T_camera_world(0), np.eye(4))
