"""The camera: to pixels and back, with a lens that bends, and with a telephoto lens."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from pydantic import ValidationError

from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera import Camera

Floats = NDArray[np.float64]

IDEAL = Camera(width=640, height=480, fx=520.0, fy=510.0, cx=322.0, cy=236.0)
BARREL = IDEAL.model_copy(update={"distortion": (-0.28, 0.09, 0.0012, -0.0008, -0.01)})
PINCUSHION = IDEAL.model_copy(update={"distortion": (0.12, -0.05, 0.001, 0.001, 0.01)})
TELEPHOTO = IDEAL.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 6.0})
CAMERAS = {"ideal": IDEAL, "barrel": BARREL, "pincushion": PINCUSHION, "telephoto": TELEPHOTO}

steady = settings(derandomize=True, deadline=None, max_examples=60)
every_camera = pytest.mark.parametrize("name", CAMERAS)


def points(seed: int, count: int = 200) -> Floats:
    """Points that fall into the picture or a little beside it."""
    rng = np.random.default_rng(seed)
    z = rng.uniform(0.5, 20, count)
    return np.column_stack(
        [rng.uniform(-0.65, 0.65, count) * z, rng.uniform(-0.5, 0.5, count) * z, z]
    )


@pytest.mark.parametrize("name", ["ideal", "barrel", "pincushion"])
def test_projection_is_that_of_opencv(name: str) -> None:
    camera, p = CAMERAS[name], points(1)
    expected, _ = cv2.projectPoints(
        p, np.zeros(3), np.zeros(3), camera.K, np.array(camera.distortion)
    )
    np.testing.assert_allclose(camera.project(p), expected[:, 0], atol=1e-9)


@every_camera
def test_a_pixel_at_its_depth_is_the_point_it_shows(name: str) -> None:
    camera = CAMERAS[name]
    p = points(2)
    if name == "telephoto":
        p[:, :2] *= 6.0 / p[:, 2:]
    np.testing.assert_allclose(camera.back_project(camera.project(p), p[:, 2]), p, atol=1e-8)


@every_camera
@steady
@given(st.floats(0, 639), st.floats(0, 479), st.floats(0.1, 50))
def test_the_point_behind_a_pixel_projects_to_that_pixel(
    name: str, u: float, v: float, z: float
) -> None:
    camera = CAMERAS[name]
    p = camera.back_project(np.array([u, v]), z)
    assert p[2] == z
    np.testing.assert_allclose(camera.project(p), (u, v), atol=1e-8)


def test_batches_of_any_shape_are_projected() -> None:
    p = points(3, 24).reshape(2, 3, 4, 3)
    uv = BARREL.project(p)
    assert uv.shape == (2, 3, 4, 2)
    np.testing.assert_allclose(uv[1, 2, 3], BARREL.project(p[1, 2, 3]))
    np.testing.assert_allclose(BARREL.back_project(uv, p[..., 2]), p, atol=1e-8)
    assert BARREL.project(np.empty((0, 3))).shape == (0, 2)


@every_camera
def test_what_is_not_before_the_camera_has_no_pixel(name: str) -> None:
    p = np.array([[0.1, 0.1, 0.0], [0.1, 0.1, -2.0], [0.1, 0.1, 2.0]])
    uv = CAMERAS[name].project(p)
    assert np.isnan(uv[:2]).all()
    assert np.isfinite(uv[2]).all()


def test_a_telephoto_camera_shows_no_depth() -> None:
    p = np.array([0.4, -0.3, 5.0])
    nearer = p - (0, 0, 3)
    np.testing.assert_array_equal(TELEPHOTO.project(p), TELEPHOTO.project(nearer))
    at_its_distance = np.array([0.4, -0.3, 6.0])
    np.testing.assert_allclose(TELEPHOTO.project(p), IDEAL.project(at_its_distance))
    np.testing.assert_array_equal(TELEPHOTO.depth(np.stack([p, nearer])), [6.0, 6.0])
    np.testing.assert_array_equal(IDEAL.depth(np.stack([p, nearer])), [5.0, 2.0])


@pytest.mark.parametrize(("width", "height"), [(1920, 1080), (1080, 1920)])
@pytest.mark.parametrize("degrees", [20.0, 65.0, 120.0])
def test_the_longer_side_spans_the_field_of_view(width: int, height: int, degrees: float) -> None:
    camera = Camera.from_field_of_view(width, height, math.radians(degrees))
    middle = np.array([(width - 1) / 2, (height - 1) / 2])
    reach = np.array([max(width, height) / 2, 0.0])[:: 1 if width > height else -1]
    rays = camera.back_project(np.stack([middle - reach, middle + reach]), 1.0)
    cosine = rays[0] @ rays[1] / np.prod(np.linalg.norm(rays, axis=1))
    assert math.degrees(math.acos(cosine)) == pytest.approx(degrees)
    assert camera.fx == camera.fy
    assert camera.origin == "field of view"


def test_a_guessed_camera_says_that_it_is_a_guess() -> None:
    camera = Camera.guess(1280, 720)
    assert camera.origin == "guess"
    assert camera.width / 2 / camera.fx == pytest.approx(math.tan(math.radians(25)))
    assert IDEAL.origin == "intrinsics"


@pytest.mark.parametrize("name", ["barrel", "pincushion"])
def test_a_dot_on_the_distorted_picture_lands_where_the_ideal_lens_shows_it(name: str) -> None:
    camera = CAMERAS[name]
    rows, columns = np.mgrid[0:480, 0:640]
    for p in np.array([[-0.4, -0.3, 1.0], [0.45, 0.2, 1.0], [0.1, 0.35, 1.0], [0.0, 0.0, 1.0]]):
        u, v = camera.project(p)
        spread = np.exp(-((columns - u) ** 2 + (rows - v) ** 2) / (2 * 2.5**2))
        light = camera.rectify((255 * spread).astype(np.uint8)).astype(float)
        found = np.array([(light * columns).sum(), (light * rows).sum()]) / light.sum()
        ideal = camera.without_distortion().project(p)
        assert np.abs(found - ideal).max() < 0.15
        assert np.abs(found - (u, v)).max() > 1.0 or np.allclose(ideal, (u, v), atol=1.0)


def test_with_an_ideal_lens_the_picture_stays_as_it_is() -> None:
    picture = np.random.default_rng(0).integers(0, 255, (480, 640, 3)).astype(np.uint8)
    assert IDEAL.rectify(picture) is picture
    assert not IDEAL.is_distorted
    assert BARREL.is_distorted
    assert not BARREL.without_distortion().is_distorted
    assert BARREL.without_distortion().K.tolist() == BARREL.K.tolist()


@pytest.mark.parametrize("degrees", [0.0, -10.0, 180.0, 400.0, math.nan])
def test_an_impossible_field_of_view_is_refused_in_one_sentence(degrees: float) -> None:
    with pytest.raises(CameraError, match=r"^The field of view must lie between 0 and 180 degrees"):
        Camera.from_field_of_view(640, 480, math.radians(degrees))


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"fx": 0.0}, "fx"),
        ({"fy": -5.0}, "fy"),
        ({"cx": math.nan}, "cx"),
        ({"cx": 2e6}, "cx"),
        ({"cy": -2e6}, "cy"),
        ({"distortion": (2e3, 0.0, 0.0, 0.0, 0.0)}, "distortion"),
        ({"projection": "telephoto", "telephoto_distance_m": 2e5}, "telephoto_distance_m"),
        ({"width": 1}, "width"),
        ({"height": 70000}, "height"),
        ({"distortion": (0.1, 0.2)}, "distortion"),
        ({"distortion": (0.1, 0.2, 0.0, 0.0, math.inf)}, "distortion"),
        ({"projection": "telephoto"}, "telephoto_distance_m"),
        ({"telephoto_distance_m": 3.0}, "telephoto_distance_m"),
        ({"projection": "fisheye"}, "projection"),
    ],
)
def test_numbers_that_are_no_camera_are_refused_by_name(
    change: dict[str, object], word: str
) -> None:
    with pytest.raises(ValidationError, match=word):
        Camera.model_validate(IDEAL.model_dump() | change)


@pytest.mark.parametrize(
    "distortion",
    [
        (-0.3, 0.1, 0.0, 0.0, 0.0),
        (0.35, 0.0, 0.0, 0.0, 0.0),
    ],
    ids=["barrel", "pincushion"],
)
def test_the_edges_of_a_wide_lens_are_found_again(distortion: tuple[float, ...]) -> None:
    wide = Camera.from_field_of_view(640, 480, math.radians(90))
    wide = wide.model_copy(update={"distortion": distortion})
    turn = np.linspace(0, 2 * np.pi, 40)
    ideal = np.column_stack([np.cos(turn), np.sin(turn), np.ones(40)])
    again = wide.back_project(wide.project(ideal), 1.0)
    np.testing.assert_allclose(again, ideal, atol=1e-6)


@pytest.mark.parametrize("channels", [(), (3,)], ids=["grey", "colour"])
def test_pictures_are_rectified_as_opencv_does_one_by_one(channels: tuple[int, ...]) -> None:
    rng = np.random.default_rng(4)
    for k in range(3):  # cameras in turn, one of them twice
        bent = IDEAL.model_copy(
            update={"distortion": (0.1 - 0.2 * (k % 2), 0.05, 0.001, 0.0, 0.01)}
        )
        picture = rng.integers(0, 256, (bent.height, bent.width, *channels)).astype(np.uint8)
        expected = cv2.undistort(picture, bent.K, np.array(bent.distortion))
        np.testing.assert_array_equal(bent.rectify(picture), expected)
