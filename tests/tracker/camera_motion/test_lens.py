"""Pixels become directions and pixels again, through any lens at any zoom."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.camera_motion.lens import Lens, unit
from keypose.tracker.geometry.camera import Camera

PLAIN = {"width": 640, "height": 480, "fx": 500.0, "fy": 500.0, "cx": 319.5, "cy": 239.5}
LENSES: dict[str, dict[str, object]] = {
    "ideal": {},
    "off its middle": {"cx": 280.0, "cy": 260.0},
    "taller pixels": {"fx": 500.0, "fy": 550.0},
    "distorted": {"distortion": (-0.2, 0.05, 0.001, -0.002, 0.0)},
    "telephoto": {"projection": "telephoto", "telephoto_distance_m": 8.0},
}
ZOOMS = [0.6, 1.0, 2.5]


def lens_of(name: str) -> Lens:
    return Lens.of(Camera(**{**PLAIN, **LENSES[name]}))  # type: ignore[arg-type]


def pixels(count: int = 50) -> np.ndarray:
    return np.random.default_rng(0).uniform((60, 40), (580, 440), (count, 2))


@pytest.mark.parametrize("zoom", ZOOMS)
@pytest.mark.parametrize("name", LENSES)
def test_what_is_seen_at_a_pixel_is_seen_there_again(name: str, zoom: float) -> None:
    lens, uv = lens_of(name), pixels()
    rays = lens.directions(uv, zoom)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=1), 1.0)
    np.testing.assert_allclose(lens.pixels(rays, zoom), uv, atol=1e-5)
    np.testing.assert_allclose(lens.pixels(7.0 * rays, zoom), uv, atol=1e-5)  # however far


@pytest.mark.parametrize("zoom", ZOOMS)
def test_an_ideal_lens_shows_pixels_where_the_camera_puts_them(zoom: float) -> None:
    uv = pixels()
    expected = (uv - (319.5, 239.5)) / 500.0
    np.testing.assert_allclose(lens_of("ideal").flat(uv, zoom), expected, atol=1e-12)
    rays = lens_of("ideal").directions(uv, zoom)
    np.testing.assert_allclose(rays[:, :2] / rays[:, 2:], expected / zoom, atol=1e-12)


def test_distortion_is_taken_out() -> None:
    lens, uv = lens_of("distorted"), pixels()
    ideal = lens_of("ideal").flat(uv, 1.0)
    assert np.abs(lens.flat(uv, 1.0) - ideal).max() > 0.01
    # half as large in the picture is distorted as what is half as far from its middle
    np.testing.assert_allclose(lens.flat(uv, 1.0), unflattened(lens, uv), atol=1e-6)


def unflattened(lens: Lens, uv: np.ndarray) -> np.ndarray:
    """The same by the camera alone."""
    p = lens.camera.back_project(uv, 1.0)
    return np.asarray(p[:, :2] / p[:, 2:])


def test_what_is_behind_the_camera_has_no_pixel() -> None:
    rays = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.3, 0.1, -2.0]])
    there = lens_of("ideal").pixels(rays, 1.0)
    assert np.isfinite(there).all(axis=1).tolist() == [True, False, False]


@pytest.mark.parametrize("by", [0.5, 3.0])
def test_a_longer_lens_shows_directions_farther_from_the_middle(by: float) -> None:
    lens = lens_of("taller pixels")
    assert lens.focal_px == pytest.approx(np.sqrt(500.0 * 550.0))
    longer = lens.scaled(by)
    assert longer.focal_px == pytest.approx(by * lens.focal_px)
    middle = np.array([319.5, 239.5])
    rays = lens.directions(middle + 0.2 * (pixels() - middle), 1.0)
    off, off_longer = (shown.pixels(rays, 1.0) - middle for shown in (lens, longer))
    np.testing.assert_allclose(off_longer, by * off, atol=1e-9)


def test_a_telephoto_camera_is_turned_as_a_plain_one() -> None:
    telephoto, plain, uv = lens_of("telephoto"), lens_of("ideal"), pixels()
    np.testing.assert_allclose(telephoto.directions(uv, 1.3), plain.directions(uv, 1.3))


def test_unit_vectors_of_tangents_point_where_these_are() -> None:
    rays = unit(np.array([[0.0, 0.0], [3.0, 0.0], [0.0, -1.0]]))
    expected = [[0.0, 0.0, 1.0], [3 / 10**0.5, 0.0, 1 / 10**0.5], [0.0, -(2**-0.5), 2**-0.5]]
    np.testing.assert_allclose(rays, expected)
