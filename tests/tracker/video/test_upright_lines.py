"""What is up by upright lines: found to a fraction of a degree, and not where there are none."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.video.upright_lines import up_from_lines, up_from_segments

CAMERA = Camera(width=640, height=360, fx=500.0, fy=500.0, cx=319.5, cy=179.5)
BENT = CAMERA.model_copy(update={"distortion": (-0.15, 0.03, 0.0, 0.0, 0.0)})


def up_of(tilt_deg: float, roll_deg: float) -> Array:
    turn = Rotation.from_euler("zx", [roll_deg, tilt_deg], degrees=True)
    return np.asarray(turn.apply([0.0, -1.0, 0.0]))


def posts(up: Array, camera: Camera, count: int = 9) -> list[Array]:
    """(M, 2) pixels along each of some posts that stand around the view."""
    middle = np.column_stack([np.linspace(-3, 3, count), np.zeros(count), np.full(count, 6.0)])
    along = np.linspace(-1.2, 1.2, 40)
    return [camera.project(place + along[:, None] * up) for place in middle]


def picture(up: Array, camera: Camera = CAMERA, slanted: int = 0) -> NDArray[np.uint8]:
    """Posts as broad as a hand before a wall, with some lines that lean this way and that."""
    grey = np.full((camera.height, camera.width), 90, np.uint8)
    for uv in posts(up, camera):
        cv2.polylines(grey, [np.round(uv).astype(np.int32)], False, 220, 7, cv2.LINE_AA)
    rng = np.random.default_rng(3)
    for _ in range(slanted):
        start, aside = rng.uniform((0, 0), (640, 200)), rng.uniform(-60, 60)
        end = start + np.array([aside, 120.0])
        cv2.line(grey, start.astype(int).tolist(), end.astype(int).tolist(), 30, 3, cv2.LINE_AA)
    return grey


def angle_deg(a: Array, b: Array) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))


@pytest.mark.parametrize(
    ("tilt", "roll"), [(0.0, 0.0), (12.0, 0.0), (25.0, -3.0), (-10.0, 5.0), (3.0, 12.0)]
)
def test_posts_show_what_is_up(tilt: float, roll: float) -> None:
    up = up_of(tilt, roll)
    found = up_from_lines([picture(up, slanted=6)], CAMERA)
    assert found is not None
    assert angle_deg(found.up_camera, up) < 0.7
    assert found.share > 0.5


@pytest.mark.parametrize("spread", [0.0, 0.3])
@pytest.mark.parametrize(("tilt", "roll"), [(0.0, 0.0), (12.0, 1.0), (25.0, -3.0), (-10.0, 5.0)])
def test_its_deviation_covers_the_truth_by_a_lens_that_is_known_or_is_not(
    tilt: float, roll: float, spread: float
) -> None:
    up = up_of(tilt, roll)
    wrong = CAMERA.model_copy(update={"fx": 500.0 * (1 + spread), "fy": 500.0 * (1 + spread)})
    found = up_from_lines([picture(up, slanted=6)], wrong, spread)
    assert found is not None
    sigma_deg = np.degrees(found.evidence.sigma_rad)
    assert angle_deg(found.up_camera, up) < 2 * sigma_deg
    assert sigma_deg < 1.5 + 1.5 * spread * abs(tilt)


def test_a_lens_that_bends_lines_is_allowed_for() -> None:
    up = up_of(15.0, 2.0)
    found = up_from_lines([picture(up, BENT)], BENT)
    assert found is not None
    assert angle_deg(found.up_camera, up) < 1.5


@pytest.mark.parametrize("bars", [(40, 40), (90, 60), (0, 120)])
def test_the_edges_of_bars_at_the_sides_are_no_upright_lines(bars: tuple[int, int]) -> None:
    up = up_of(12.0, 8.0)
    boxed = picture(up, slanted=6)
    boxed[:, : bars[0]] = boxed[:, 640 - bars[1] :] = 0
    found = up_from_lines([boxed], CAMERA)
    assert found is not None
    assert angle_deg(found.up_camera, up) < 0.7
    blank = np.full((360, 640), 128, np.uint8)
    blank[:, : bars[0]] = blank[:, 640 - bars[1] :] = 16
    assert up_from_lines([blank] * 6, CAMERA) is None


@pytest.mark.parametrize("slanted", [6, 9, 12])
@pytest.mark.parametrize(("tilt", "roll"), [(0.0, 40.0), (5.0, 30.0), (60.0, 0.0), (10.0, -45.0)])
def test_a_camera_that_leans_far_is_not_said_to_stand_upright_by_what_agrees_by_chance(
    tilt: float, roll: float, slanted: int
) -> None:
    up = up_of(tilt, roll)
    found = up_from_lines([picture(up, slanted=slanted)], CAMERA)
    assert found is None or angle_deg(found.up_camera, up) < 2 * np.degrees(found.alone.sigma_rad)


def test_one_thing_counts_once_however_many_edges_and_pictures_show_it() -> None:
    up = up_of(12.0, 1.0)
    once, often = (up_from_lines([picture(up)] * count, CAMERA) for count in (1, 3))
    assert once is not None
    assert often is not None
    assert often.alone.sigma_rad == pytest.approx(once.alone.sigma_rad, rel=0.05)
    two = np.full((360, 640), 90, np.uint8)
    for uv in (posts(up, CAMERA)[1], posts(up, CAMERA)[-2]):
        cv2.polylines(two, [np.round(uv).astype(np.int32)], False, 220, 7, cv2.LINE_AA)
    assert up_from_lines([two] * 3, CAMERA) is None


def test_the_far_edge_of_a_floor_that_leads_away_is_one_line_among_many() -> None:
    up = up_of(15.0, 0.0)
    shown = picture(up).copy()
    for shift in (0, 8):
        cv2.line(shown, (420 + shift, 20), (500 + shift, 350), 255, 2, cv2.LINE_AA)
    found = up_from_lines([shown], CAMERA)
    assert found is not None
    assert angle_deg(found.up_camera, up) < 2 * np.degrees(found.alone.sigma_rad)


def test_a_blank_wall_and_lines_that_lean_every_way_say_nothing() -> None:
    blank = np.full((360, 640, 3), 128, np.uint8)
    assert up_from_lines([blank, blank], CAMERA) is None
    rng = np.random.default_rng(0)
    tangle = np.full((360, 640), 90, np.uint8)
    for _ in range(60):
        start = rng.uniform((40, 20), (600, 250))
        end = start + np.array([rng.uniform(-60, 60), 90.0])
        cv2.line(tangle, start.astype(int).tolist(), end.astype(int).tolist(), 220, 2, cv2.LINE_AA)
    assert up_from_lines([tangle], CAMERA) is None


def test_what_the_lens_does_not_show_says_nothing_and_leaves_the_rest() -> None:
    narrow = CAMERA.model_copy(update={"distortion": (-0.9, 0.0, 0.0, 0.0, 0.0)})
    shown = picture(up_of(10.0, 2.0), slanted=9).copy()
    cv2.line(shown, (6, 4), (6, 150), 255, 3)
    assert not np.isfinite(narrow.back_project(np.array([6.0, 4.0]), 1.0)).all()
    found = up_from_lines([shown], narrow)
    assert found is None or np.isfinite(found.up_camera).all()


def test_a_telephoto_camera_tilts_as_its_lens_does() -> None:
    up = up_of(10.0, 2.0)
    far = CAMERA.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 5.0})
    found = up_from_lines([picture(up, slanted=9)], far)
    assert found is not None
    assert angle_deg(found.up_camera, up) < 1.5


def test_it_is_the_same_every_time() -> None:
    shown = [picture(up_of(9.0, 1.0), slanted=9)]
    one, other = (up_from_lines(shown, CAMERA) for _ in range(2))
    assert one is not None
    assert other is not None
    np.testing.assert_array_equal(one.up_camera, other.up_camera)


# --- two lines that a person draws


@pytest.mark.parametrize("camera", [CAMERA, BENT])
def test_two_verticals_show_tilt_and_roll(camera: Camera) -> None:
    up = up_of(14.0, -3.0)
    first, *_, last = posts(up, camera)
    found = up_from_segments(np.array([first[[5, -5]], last[[5, -5]]]), camera)
    assert found is not None
    assert angle_deg(found, up) < 0.3


def test_one_line_drawn_twice_and_lines_that_lie_say_nothing() -> None:
    line = [(100.0, 40.0), (104.0, 300.0)]
    assert up_from_segments(np.array([line, line]), CAMERA) is None
    spot = [(500.0, 40.0), (500.0, 40.0)]
    assert up_from_segments(np.array([line, spot]), CAMERA) is None
    level = [[(20.0, 100.0), (600.0, 102.0)], [(20.0, 300.0), (600.0, 250.0)]]
    assert up_from_segments(np.array(level), CAMERA) is None
