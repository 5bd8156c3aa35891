"""The four views: from points to the view and back, and what is up."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from keypose.app.posing import (
    CAMERA_UP,
    PointerView,
    tilt_and_roll,
    up_from_vertical,
    view_rotations,
)
from keypose.app.posing.vectors import unit
from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.geometry.view import ViewCamera
from tests.app.posing.posing_cases import CAMERA, TELEPHOTO, VIEWS, off_axis, sights

numbers = st.floats(-1, 1)
cameras = pytest.mark.parametrize("camera", [CAMERA, TELEPHOTO], ids=["perspective", "telephoto"])


@cameras
@pytest.mark.parametrize("view", VIEWS)
@given(x=numbers, y=numbers, z=st.floats(2, 6))
def test_the_ray_at_a_point_s_image_goes_through_the_point(
    camera: Camera, view: str, x: float, y: float, z: float
) -> None:
    sight, p = sights(camera)[view], np.array([x, y, z])
    origin, direction = sight.ray(sight.project(p))
    assert np.linalg.norm(direction) == pytest.approx(1)
    off = (p - origin) - ((p - origin) @ direction) * direction
    np.testing.assert_allclose(off, 0, atol=1e-9)
    np.testing.assert_allclose(sight.ray_through(p), direction, atol=1e-9)


@cameras
@pytest.mark.parametrize("view", VIEWS)
def test_at_depth_finds_the_point_again_and_keeps_the_reference_s_depth(
    camera: Camera, view: str
) -> None:
    sight, p = sights(camera)[view], np.array([0.3, -0.4, 3.0])
    np.testing.assert_allclose(sight.at_depth(sight.project(p), p), p, atol=1e-12)
    at = sight.project(p) + np.array([0.2, 0.1])
    q = sight.at_depth(at, p)
    np.testing.assert_allclose(sight.project(q), at, atol=1e-12)
    assert (q - p) @ sight.away == pytest.approx(0, abs=1e-12)


@cameras
@pytest.mark.parametrize("view", VIEWS)
def test_the_slope_is_what_a_small_motion_of_the_point_shows(camera: Camera, view: str) -> None:
    sight, p, step = sights(camera)[view], np.array([0.3, -0.4, 3.0]), 1e-6
    ways = step * np.eye(3)
    measured = (sight.project(p + ways) - sight.project(p - ways)).T / (2 * step)
    np.testing.assert_allclose(sight.slope(p), measured, atol=1e-4)
    across = 1 / sight.metres_per_unit(p)
    assert np.abs(sight.slope(p)[0]).max() == pytest.approx(across, rel=0.1)


def test_the_main_view_is_the_picture_that_the_eye_draws_without_distortion() -> None:
    bent = CAMERA.model_copy(update={"distortion": (0.1, 0.0, 0.0, 0.0, 0.0)})
    p = np.array([[0.3, -0.4, 3.0], [-0.2, 0.1, 5.0]])
    np.testing.assert_allclose(PointerView.of(bent).project(p), ViewCamera.of(bent).project(p))


@pytest.mark.parametrize("view", ["top", "side", "front"])
def test_upright_the_small_views_are_those_of_the_pictures(view: str) -> None:
    eye = ViewCamera.orthographic(view, np.zeros(3), 100.0, (201, 201))  # type: ignore[arg-type]
    np.testing.assert_array_equal(view_rotations()[view], eye.T_view_camera[:3, :3])  # type: ignore[index]
    p = np.array([0.3, -0.4, 3.0])
    at = eye.project(eye.T_view_camera[:3, :3] @ p)
    np.testing.assert_allclose(100 * sights()[view].project(p) + 100, at)


@given(numbers, numbers, numbers)
def test_the_views_stand_on_what_is_up(x: float, y: float, z: float) -> None:
    up = unit(np.array([x, y, z])) if abs(x) + abs(y) + abs(z) > 0.1 else np.array(CAMERA_UP)
    for name, R in view_rotations(up).items():
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(R) == pytest.approx(1)
        down = R[2] if name == "top" else R[1]
        np.testing.assert_allclose(down, -up, atol=1e-12)
    front = view_rotations(up)["front"]
    if abs(up[2]) < 0.99:  # the front view turns away from the camera's axis by its tilt only
        tilt = math.asin(np.clip(up[2], -1, 1))
        assert off_axis(front[2], np.array([0, 0, 1.0])) == pytest.approx(abs(tilt), abs=1e-6)


@pytest.mark.parametrize("z", [1.0, -1.0])
def test_a_camera_that_looks_straight_down_or_up_still_has_a_front(z: float) -> None:
    R = view_rotations((0.0, 0.0, z))["front"]
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    nearly = view_rotations(unit(np.array([0.0, -1e-4, z])))["front"]
    np.testing.assert_allclose(R, nearly, atol=1e-3)


@cameras
@given(st.tuples(*[st.floats(-400, 400)] * 2), st.floats(0, math.pi), st.floats(20, 300))
def test_up_projects_along_the_drawn_line_and_leans_as_little_as_it_can(
    camera: Camera, a: tuple[float, float], angle: float, size: float
) -> None:
    b = (a[0] + size * math.cos(angle), a[1] + size * math.sin(angle))
    up = up_from_vertical(camera, a, b)
    np.testing.assert_allclose(up, up_from_vertical(camera, b, a), atol=1e-9)
    view = PointerView.of(camera)
    p = view.at_depth(a, np.array([0, 0, 5.0]))
    seen = view.project(p + 0.3 * up) - a
    line = np.array(b) - a
    assert abs(seen[0] * line[1] - seen[1] * line[0]) <= 1e-6 * size * (1 + np.abs(seen).max())
    # of all directions that do so, none is nearer to the picture's own up
    normal = unit(np.cross(view.at_depth(b, p) - p, view.ray_through(p)))
    others = exp_rotation(np.linspace(0, 2 * math.pi, 720)[:, None] * normal) @ up
    assert up @ CAMERA_UP >= (others @ CAMERA_UP).max() - 1e-6


def test_a_line_straight_up_through_the_middle_of_the_picture_changes_nothing() -> None:
    up = up_from_vertical(CAMERA, (CAMERA.cx, 10), (CAMERA.cx, 300))
    np.testing.assert_allclose(up, CAMERA_UP, atol=1e-12)
    assert tilt_and_roll(up) == (0, 0)
    with pytest.raises(CameraError, match="two ends are the same point"):
        up_from_vertical(CAMERA, (5, 5), (5, 5))


def test_tilt_and_roll_are_those_of_a_camera_that_was_turned() -> None:
    world_up = np.array(CAMERA_UP)
    looking_up = exp_rotation([math.radians(20), 0, 0])  # R_world_camera: −y turns toward −z …
    assert (looking_up @ [0, 0, 1.0])[1] < 0  # … and the optical axis toward up
    tilt, roll = tilt_and_roll(looking_up.T @ world_up)
    assert (tilt, roll) == (pytest.approx(20), pytest.approx(0))
    rolled = exp_rotation([0, 0, math.radians(-10)])
    assert tilt_and_roll(rolled.T @ world_up) == (pytest.approx(0), pytest.approx(10))
