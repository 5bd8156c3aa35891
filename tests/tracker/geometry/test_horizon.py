"""Up from a drawn horizon, beside cameras whose leaning is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.horizon import horizon_of, up_from_horizon
from keypose.tracker.geometry.rotations import Array, exp_rotation

LENS = Camera(width=960, height=540, fx=800.0, fy=790.0, cx=471.0, cy=280.0)
BENT = LENS.model_copy(update={"distortion": (-0.25, 0.08, 0.001, -0.0006, -0.01)})
LONG = LENS.model_copy(
    update={"fx": 9000.0, "fy": 9000.0, "projection": "telephoto", "telephoto_distance_m": 40.0}
)
CAMERA_UP = (0.0, -1.0, 0.0)

steady = settings(derandomize=True, deadline=None, max_examples=60)
degrees = st.floats(-40, 40)


def held(tilt_deg: float, roll_deg: float) -> Array:
    """R_camera_world (3, 3) of a camera that looks down by a tilt and leans by a roll; the world's
    axes are right, down and ahead."""
    tilt, roll = math.radians(tilt_deg), math.radians(roll_deg)
    return np.asarray(exp_rotation((0.0, 0.0, roll)) @ exp_rotation((tilt, 0.0, 0.0)))


def far_away(camera: Camera, R_camera_world: Array, aside_deg: float) -> Array:
    """(2,) the pixel of a far point on level ground, this far aside of where the camera looks; a
    telephoto camera is the long lens that it stands for."""
    away = math.radians(aside_deg)
    there = R_camera_world @ (math.sin(away), 0.0, math.cos(away))
    lens = camera.model_copy(update={"projection": "perspective", "telephoto_distance_m": None})
    return np.asarray(lens.project(there))


@steady
@given(degrees, degrees)
def test_a_horizon_gives_tilt_and_roll_exactly(tilt: float, roll: float) -> None:
    R = held(tilt, roll)
    a, b = far_away(LENS, R, -20.0), far_away(LENS, R, 15.0)
    up = up_from_horizon(LENS, a, b, CAMERA_UP)
    np.testing.assert_allclose(up, R @ CAMERA_UP, atol=1e-9)
    np.testing.assert_array_equal(up_from_horizon(LENS, b, a, CAMERA_UP), up)


@pytest.mark.parametrize(
    ("camera", "tilt", "roll", "aside"),
    [
        pytest.param(BENT, 6.0, -4.0, 18.0, id="a lens that bends straight lines"),
        pytest.param(LONG, 1.2, 3.0, 2.0, id="a telephoto camera"),
        pytest.param(LENS, 0.0, 0.0, 20.0, id="through the middle of the picture"),
        pytest.param(LENS, 40.0, 5.0, 20.0, id="above the picture"),
    ],
)
def test_a_horizon_shows_what_is_up_for(
    camera: Camera, tilt: float, roll: float, aside: float
) -> None:
    R = held(tilt, roll)
    ends = far_away(camera, R, -aside), far_away(camera, R, aside)
    up = up_from_horizon(camera, *ends, CAMERA_UP)
    np.testing.assert_allclose(up, R @ CAMERA_UP, atol=1e-7)


def test_the_floor_lies_where_one_standing_foot_does() -> None:
    R, p_world_foot = held(12.0, -7.0), np.array([0.4, 1.6, 5.0])
    up = up_from_horizon(LENS, far_away(LENS, R, -15), far_away(LENS, R, 15), CAMERA_UP)
    assert float(up @ (R @ p_world_foot)) == pytest.approx(-1.6)


def test_a_horizon_drawn_two_pixels_off_turns_up_by_less_than_half_a_degree() -> None:
    R = held(5.0, 3.0)
    a, b = far_away(LENS, R, -20), far_away(LENS, R, 20)
    up = up_from_horizon(LENS, np.add(a, (0, 2)), np.subtract(b, (0, 2)), CAMERA_UP)
    assert math.degrees(math.acos(float(up @ (R @ CAMERA_UP)))) < 0.5


def test_what_is_known_of_up_gives_the_sky_from_the_ground() -> None:
    ends = (500.0, 20.0), (480.0, 500.0)
    leaning = up_from_horizon(LENS, *ends, (-1.0, -0.2, 0.0))
    assert leaning[0] < 0
    np.testing.assert_allclose(up_from_horizon(LENS, *ends, (1.0, -0.2, 0.0)), -leaning)
    with pytest.raises(CameraError, match="from side to side"):
        up_from_horizon(LENS, *ends, CAMERA_UP)


def test_what_is_no_line_is_refused_in_a_sentence() -> None:
    with pytest.raises(CameraError, match="the same point"):
        up_from_horizon(LENS, (3.0, 4.0), (3.0, 4.0), CAMERA_UP)
    folded = LENS.model_copy(update={"distortion": (-0.4, 0.0, 0.0, 0.0, 0.0)})
    with pytest.raises(CameraError, match="nearer the centre"):
        up_from_horizon(folded, (-4000.0, 100.0), (500.0, 100.0), CAMERA_UP)


@steady
@given(degrees, st.floats(-180, 180))
def test_the_horizon_of_what_is_up_leads_back_to_it(tilt: float, roll: float) -> None:
    up = held(tilt, roll) @ CAMERA_UP
    ends = horizon_of(LENS, up)
    assert ends is not None
    np.testing.assert_allclose(up_from_horizon(LENS, *ends, up), up, atol=1e-9)


def test_a_camera_that_looks_straight_down_shows_no_horizon() -> None:
    assert horizon_of(LENS, (0.0, 0.0, -1.0)) is None
    assert horizon_of(LENS, (0.0, -1e-3, -1.0)) is None
