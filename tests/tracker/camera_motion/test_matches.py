"""Points that a person matched tell how the camera turned, or in one sentence why not."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.matches import Matched, rotation_from_matches
from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from tests.tracker.camera_cases import SMALL, off_deg, turned

DISTORTED = SMALL.model_copy(update={"distortion": (-0.2, 0.05, 0.001, -0.001, 0.0)})
ZOOM = 1.2
R = turned(7, -3, 4)


def matches(count: int, camera: Camera = SMALL, zoom: float = 1.4) -> tuple[Array, Array]:
    lens = Lens.of(camera)
    uv = np.random.default_rng(count).uniform((60, 40), (220, 140), (count, 2))
    return uv, lens.pixels(lens.directions(uv, ZOOM) @ R.T, zoom)


def matched(uv: Array, other: Array, camera: Camera = SMALL, zooms: bool = True) -> Matched:
    return rotation_from_matches(uv, other, camera, zoom=ZOOM, zooms=zooms)


@pytest.mark.parametrize("camera", [SMALL, DISTORTED], ids=["ideal", "distorted"])
@pytest.mark.parametrize("count", [2, 3, 12])
def test_matched_points_tell_the_turn_and_the_zoom(camera: Camera, count: int) -> None:
    found = matched(*matches(count, camera), camera)
    np.testing.assert_allclose(found.R_other_one, R, atol=1e-7)
    assert found.zoom == pytest.approx(1.4, abs=1e-6)
    assert found.error_px.max() < 1e-3


@pytest.mark.parametrize("count", [2, 5])
def test_a_camera_that_does_not_zoom_keeps_its_zoom(count: int) -> None:
    found = matched(*matches(count, zoom=ZOOM), zooms=False)
    assert found.zoom == ZOOM
    np.testing.assert_allclose(found.R_other_one, R, atol=1e-7)


def test_a_turn_and_back_is_none() -> None:
    uv, other = matches(6)
    there = matched(uv, other)
    back = rotation_from_matches(other, uv, SMALL, zoom=there.zoom)
    np.testing.assert_allclose(back.R_other_one @ there.R_other_one, np.eye(3), atol=1e-7)
    assert back.zoom == pytest.approx(ZOOM, abs=1e-6)


def test_marks_that_are_a_pixel_off_are_off_by_about_that_in_the_end() -> None:
    uv, other = matches(40)
    other = other + np.random.default_rng(0).normal(0, 1.0, other.shape)
    found = matched(uv, other)
    assert off_deg(found.R_other_one[None], [R]).max() < 0.3
    assert np.sqrt((found.error_px**2).mean() / 2) == pytest.approx(1.0, rel=0.2)


def test_one_wrong_mark_shows_by_its_error() -> None:
    uv, other = matches(8)
    other[3] += (25.0, 0.0)
    assert matched(uv, other).error_px.argmax() == 3


APART = [[20.0, 20.0], [200.0, 100.0]]
BAD = {
    "none": ([], []),
    "one": ([[10.0, 10.0]], [[20.0, 10.0]]),
    "more in one frame": (APART, [[20.0, 10.0]]),
    "at one place in both": ([[10.0, 10.0], [11.0, 10.0]], [[20.0, 10.0], [21.0, 10.0]]),
    "at one place in the one": ([[10.0, 10.0], [11.0, 10.0]], APART),
    "at one place in the other": (APART, [[10.0, 10.0], [11.0, 10.0]]),
}


@pytest.mark.parametrize("name", BAD)
def test_too_few_matches_are_refused(name: str) -> None:
    uv, other = BAD[name]
    with pytest.raises(CameraError, match="points") as error:
        rotation_from_matches(np.array(uv), np.array(other), SMALL)
    assert str(error.value).count(".") == 1


@pytest.mark.parametrize("zooms", [True, False])
def test_points_that_no_turn_explains_are_said_to_be_different_ones(zooms: bool) -> None:
    uv = np.array([[20.0, 20.0], [300.0, 20.0], [20.0, 160.0], [300.0, 160.0]])
    mirrored = uv[[1, 0, 3, 2]]
    with pytest.raises(CameraError, match="No turn of the camera explains these points"):
        rotation_from_matches(uv, mirrored, SMALL, zooms=zooms)
