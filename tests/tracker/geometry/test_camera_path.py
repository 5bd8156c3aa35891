"""A camera's path: met exactly where a person corrected it, as it was from frame to frame."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import (
    CameraCorrection,
    CameraPath,
    corrected,
    rigid_inverse,
)
from keypose.tracker.geometry.rotations import Array, exp_rotation, transform, transpose

N = 41
CAMERA = Camera(width=640, height=360, fx=500.0, fy=510.0, cx=319.5, cy=179.5)


def panned(degrees: float, metres: float = 0.0, zoom: float = 1.0) -> CameraPath:
    t = np.linspace(0, 1, N)
    turn = np.radians(degrees) * t[:, None] * (0.1, 1.0, -0.05)
    return CameraPath.of(exp_rotation(turn), metres * t[:, None] * (1.0, 0.2, 0.5), zoom**t)


def apart_deg(one: Array, other: Array) -> Array:
    cosine = (np.trace(one @ transpose(other), axis1=-2, axis2=-1) - 1) / 2
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))


def key(path: CameraPath, frame: int) -> CameraCorrection:
    return CameraCorrection(frame, path.Ts_camera_world[frame], float(path.zoom[frame]))


@pytest.mark.parametrize("frames", [(20,), (40,), (13, 30), (1, 20, 40), (0, 40)])
def test_every_correction_is_met_exactly_and_the_first_frame_stays(frames: tuple[int, ...]) -> None:
    truth, wrong = panned(20, 1.0, 1.5), panned(16, 0.8, 1.4)
    found = corrected(wrong, [key(truth, frame) for frame in frames])
    for frame in (0, *frames):
        np.testing.assert_array_equal(found.Ts_camera_world[frame], truth.Ts_camera_world[frame])
        assert found.zoom[frame] == truth.zoom[frame]


def test_a_wrong_start_that_is_corrected_at_two_frames_is_half_as_far_off_between() -> None:
    """The world is carried along a wrong axis, as by a wrong focal length."""
    truth = panned(20, 1.0, 1.3)
    t = np.linspace(0, 1, N)
    bent = exp_rotation(np.radians(4) * (t**1.5)[:, None] * (0.3, 0.8, 0.2))
    T = truth.Ts_camera_world.copy()
    T[:, :3, :3] = bent @ T[:, :3, :3]
    wrong = CameraPath(T, truth.zoom * 1.1**t)
    found = corrected(wrong, [key(truth, 20), key(truth, 40)])
    before = apart_deg(wrong.Ts_camera_world[:, :3, :3], truth.Ts_camera_world[:, :3, :3])
    after = apart_deg(found.Ts_camera_world[:, :3, :3], truth.Ts_camera_world[:, :3, :3])
    assert after.max() < 0.5 * before.max()
    assert after[1:20].max() < 0.5 * before[1:21].max()
    assert np.abs(np.log(found.zoom / truth.zoom)).max() < 0.01


def test_a_path_that_is_right_stays_as_it_is() -> None:
    path = panned(20, 1.0, 1.3)
    assert corrected(path, []) is path
    found = corrected(path, [key(path, 12), key(path, 33)])
    np.testing.assert_allclose(found.Ts_camera_world, path.Ts_camera_world, atol=1e-12)


def test_drift_lies_where_nothing_ties_and_is_even_elsewhere() -> None:
    path, truth = CameraPath.standing_still(N), panned(4)
    untied = np.zeros(N - 1, bool)
    untied[10] = True
    found = corrected(path, [key(truth, 20), key(truth, 40)], untied)
    turned = apart_deg(found.Ts_camera_world[:, :3, :3], np.eye(3))
    np.testing.assert_allclose(turned[:11], 0.0, atol=0.01)
    np.testing.assert_allclose(turned[11:21], turned[20], atol=0.01)
    np.testing.assert_allclose(turned[30], (turned[20] + turned[40]) / 2, atol=0.01)


def test_pieces_of_a_path_have_units_of_their_own() -> None:
    path = panned(20, 1.0)
    places = path.Ts_world_camera[:, :3, 3]
    apart = path.in_metres((0, 15), (2.0, 3.0)).Ts_world_camera[:, :3, 3]
    np.testing.assert_allclose(apart[:15], 2 * places[:15], atol=1e-12)
    np.testing.assert_allclose(np.diff(apart[14:], axis=0), 3 * np.diff(places[14:], axis=0))


def test_between_frames_it_goes_on_evenly() -> None:
    path = panned(20, 1.0, 1.3)
    np.testing.assert_allclose(path.sampled(np.arange(N)).Ts_camera_world, path.Ts_camera_world)
    half = path.sampled(np.array([7.5]))
    ends = path.Ts_camera_world[[7, 8]]
    turned = apart_deg(half.Ts_camera_world[:, :3, :3], ends[:, :3, :3])
    assert turned[0] == pytest.approx(turned[1], rel=1e-3)
    np.testing.assert_allclose(half.Ts_camera_world[0, :3, 3], ends[:, :3, 3].mean(axis=0))


def test_the_inverse_of_a_rigid_motion_leads_back() -> None:
    T = transform(exp_rotation(np.array([0.3, -1.0, 2.0])), np.array([1.0, 2.0, 3.0]))
    np.testing.assert_allclose(rigid_inverse(T) @ T, np.eye(4), atol=1e-12)
