"""A film by a shaking hand: tracked as a steady one had held the camera, told as it was filmed."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation, transform
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.tracking.ahead.follow import follow_ahead
from tests.rendering import scenes
from tests.rendering.render import render
from tests.rendering.settings import RenderSettings
from tests.tracker.tracking_cases import SMALL, Case, tracked

FRAMES = 13


@pytest.fixture(scope="module")
def path() -> CameraPath:
    turn = np.random.default_rng(2).normal(0, 0.012, (FRAMES, 3))
    turn[0] = 0
    return CameraPath.of(exp_rotation(turn), np.zeros((FRAMES, 3)), np.ones(FRAMES))


@pytest.fixture(scope="module")
def shaken(path: CameraPath) -> Case:
    made = scenes.scene("tumbling_box", size=SMALL).cut(10, 10 + FRAMES - 1)
    truth = made.truth.carried(transform(path.Ts_camera_world[:, :3, :3], np.zeros((FRAMES, 3))))
    pictures = render(made.skeleton, truth, made.camera, RenderSettings())
    return Case(made.skeleton, made.camera, truth, pictures)


def test_the_shake_is_no_motion_of_the_body(shaken: Case, path: CameraPath) -> None:
    steady = SteadyCamera.along(shaken.camera, path)
    errors = []
    for tracker in (
        shaken.tracker(0, FRAMES - 1),
        shaken.tracker(0, FRAMES - 1, steady=steady),
    ):
        (segment,) = tracked(tracker)
        errors.append(shaken.error_cm(segment.trajectory))
        for frame in (0, FRAMES - 1):
            found, given = segment.trajectory.pose(frame), shaken.truth.pose(frame)
            np.testing.assert_array_equal(found.Rs_parent_part, given.Rs_parent_part)
            np.testing.assert_array_equal(found.p_camera_root, given.p_camera_root)
    assert errors[1] < 0.6
    assert errors[1] < errors[0]


@pytest.mark.parametrize("shakes", [False, True], ids=["still", "shaking"])
def test_a_keyframe_comes_back_as_the_very_numbers_that_were_set_however_a_processor_rounds(
    shaken: Case, path: CameraPath, shakes: bool
) -> None:
    steady = SteadyCamera.along(shaken.camera, path) if shakes else None
    tracker = shaken.tracker(0, FRAMES - 1, steady=steady)
    rounded, ends = np.random.default_rng(3), (0, FRAMES - 1)
    R, t = shaken.truth.writable()
    for frame in ends:
        pose = tracker.keyposes[frame]
        R[frame] = pose.Rs_parent_part + rounded.normal(0, 1e-16, pose.Rs_parent_part.shape)
        t[frame] = pose.p_camera_root + rounded.normal(0, 1e-16, 3)
    found = tracker.as_filmed(Trajectory(0, R, t))
    for frame in ends:
        given = shaken.truth.pose(frame)
        np.testing.assert_array_equal(found.pose(frame).Rs_parent_part, given.Rs_parent_part)
        np.testing.assert_array_equal(found.pose(frame).p_camera_root, given.p_camera_root)


def test_a_pass_that_misses_a_keyframe_is_shown_as_it_is(shaken: Case) -> None:
    tracker = shaken.tracker(0, FRAMES - 1)
    R, t = shaken.truth.writable()
    t[-1] += 1e-3
    found = tracker.as_filmed(Trajectory(0, R, t))
    np.testing.assert_array_equal(found.ps_camera_root, t)


def test_what_is_followed_ahead_is_as_it_was_filmed(shaken: Case, path: CameraPath) -> None:
    from keypose.tracker.session.settings import TrackSettings

    steady = SteadyCamera.along(shaken.camera, path)
    tracker = shaken.tracker(0, steady=steady, fewest=1)
    seen: list[Trajectory] = []
    found = follow_ahead(tracker, 0, "forward", TrackSettings(), seen.append, 6)
    np.testing.assert_array_equal(
        found.motion.pose(0).p_camera_root, shaken.truth.pose(0).p_camera_root
    )
    last = found.motion.last_frame
    apart = found.motion.pose(last).p_camera_root - shaken.truth.pose(last).p_camera_root
    assert last >= 2
    assert np.linalg.norm(apart[:2]) < 0.02
    assert seen
