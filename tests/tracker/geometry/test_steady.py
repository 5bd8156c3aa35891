"""The steady camera in the place of one that shakes: the same scene, seen without the shake."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation, log_rotation, transpose
from keypose.tracker.geometry.steady import MOST_RAD, SteadyCamera

FRAMES = 60
CAMERA = Camera(width=320, height=180, fx=300.0, fy=305.0, cx=160.0, cy=88.0)
BENT = CAMERA.model_copy(update={"distortion": (-0.1, 0.02, 0.001, 0.0, 0.0)})


def path(shake: float = 0.006, pan_deg: float = 20.0, zoom: float = 1.3) -> CameraPath:
    t, rng = np.linspace(0, 1, FRAMES), np.random.default_rng(0)
    turn = np.radians(pan_deg) * t[:, None] * (0.0, 1.0, 0.0) + rng.normal(0, shake, (FRAMES, 3))
    return CameraPath.of(exp_rotation(turn - turn[0]), np.zeros((FRAMES, 3)), zoom**t)


def steps_deg(Rs: np.ndarray) -> np.ndarray:
    return np.degrees(np.linalg.norm(log_rotation(Rs[1:] @ transpose(Rs[:-1])), axis=1))


def test_the_shake_is_gone_and_the_pan_stays() -> None:
    shaking = path()
    steady = SteadyCamera.along(CAMERA, shaking)
    Rs = steady.Rs_steady_camera @ shaking.Ts_camera_world[:, :3, :3]
    jumps = [
        np.abs(np.diff(steps_deg(one))).max() for one in (shaking.Ts_camera_world[:, :3, :3], Rs)
    ]
    assert jumps[1] < 0.15 * jumps[0]
    turned = np.degrees(np.linalg.norm(log_rotation(Rs[-1] @ Rs[0].T)))
    assert turned == pytest.approx(20.0, abs=4.0)
    assert np.linalg.norm(log_rotation(steady.Rs_steady_camera), axis=1).max() <= MOST_RAD + 1e-9


@pytest.mark.parametrize("camera", [CAMERA, BENT], ids=["ideal", "bent"])
def test_pixels_are_where_the_steady_camera_sees_the_same_point(camera: Camera) -> None:
    shaking = path()
    steady = SteadyCamera.along(camera, shaking)
    p = np.array([[0.3, -0.2, 2.0], [-0.4, 0.3, 3.0], [0.0, 0.0, 4.0]])
    for frame in (0, 17, 59):
        if camera.is_distorted and shaking.zoom[frame] != 1:
            continue  # how a bent lens zooms is not known
        seen = shaking.camera_at(camera, frame).project(p)
        expected = camera.project(p @ steady.Rs_steady_camera[frame].T)
        np.testing.assert_allclose(steady.pixels(seen, frame), expected, atol=1e-6)


def test_the_picture_shows_what_the_pixels_say() -> None:
    shaking = path()
    steady = SteadyCamera.along(CAMERA, shaking)
    uv = np.array([[100.0, 60.0], [200.0, 110.0]])
    for frame in (0, 30, 59):
        image = np.zeros((CAMERA.height, CAMERA.width), np.uint8)
        for u, v in uv.astype(int):
            cv2.circle(image, (int(u), int(v)), 6, 255, -1)
        shown = steady.picture(image, frame)
        for u, v in np.round(steady.pixels(uv, frame)).astype(int):
            assert shown[v, u] > 200
        assert (
            abs(int((shown > 128).sum()) * shaking.zoom[frame] ** 2 / (image > 128).sum() - 1) < 0.1
        )


def test_a_camera_that_stands_still_gives_its_own_picture_to_the_last_bit() -> None:
    steady = SteadyCamera.along(CAMERA, CameraPath.standing_still(FRAMES))
    image = np.random.default_rng(1).integers(0, 255, (180, 320), dtype=np.uint8)
    assert steady.picture(image, 7) is image
    assert steady.covers(7)
    uv = np.array([[3.25, 7.5]])
    np.testing.assert_array_equal(steady.pixels(uv, 7), uv)


def test_a_telephoto_lens_is_not_turned() -> None:
    far = CAMERA.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 4.0})
    steady = SteadyCamera.along(far, path())
    np.testing.assert_array_equal(steady.Rs_steady_camera, np.tile(np.eye(3), (FRAMES, 1, 1)))
