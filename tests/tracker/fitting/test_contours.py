"""Where a body ends before its background, by colours, on drawn pictures of a thing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import ALL_DOFS, Body, Part
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import BodyMesh
from keypose.tracker.body.shapes import Box
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.fitting.sizes.contours import (
    FEWEST_FOR_PLATE,
    ColourModels,
    Contour,
    colour_cells,
    contour_of,
    learn_colours,
    offsets,
    plate_odds,
)
from keypose.tracker.geometry.camera import Camera

WIDTH = 160
HEIGHT = 120
CAMERA = Camera(width=WIDTH, height=HEIGHT, fx=200.0, fy=200.0, cx=79.5, cy=59.5)
SIDE_M = 0.5
DEPTH_M = 2.0
SIDE_PX = 200.0 * SIDE_M / (DEPTH_M - SIDE_M / 2)
"""Of the face toward the camera."""
THING = (200, 60, 50)
BEHIND = (60, 110, 180)
REACH_PX = 8.0
GRAIN = 14.0
"""Grey levels."""

Picture = NDArray[np.uint8]


def box() -> Skeleton:
    half = SIDE_M / 2
    shape = Box(low_m=(-half, -half, -half), high_m=(half, half, half))
    return Skeleton.of(Body(name="box", parts=(Part(name="box", shape=shape, tracked=ALL_DOFS),)))


def contour(x_m: float = 0.0, y_m: float = 0.0) -> Contour:
    """Of the box, its face square to the camera."""
    skeleton = box()
    T = pose_transforms(skeleton, Pose.rest(skeleton, (x_m, y_m, DEPTH_M)))
    return contour_of(BodyMesh.of(skeleton), T, CAMERA)


def picture(
    wider_px: float = 0.0,
    thing: tuple[int, int, int] = THING,
    behind: tuple[int, int, int] = BEHIND,
) -> Picture:
    """The face, so much larger on every side; its rim is as bright as it covers each pixel. Both
    have a grain, as all that is filmed has."""
    half = SIDE_PX / 2 + wider_px
    cover = [
        np.clip(half + 0.5 - np.abs(np.arange(count) - middle), 0, 1)
        for count, middle in ((HEIGHT, CAMERA.cy), (WIDTH, CAMERA.cx))
    ]
    share = (cover[0][:, None] * cover[1])[..., None]
    grain = np.random.default_rng(1).normal(0, GRAIN, (HEIGHT, WIDTH, 3))
    shown = share * thing + (1 - share) * np.array(behind) + grain
    return np.rint(np.clip(shown, 0, 255)).astype(np.uint8)


def models(rgb: Picture, seen: Contour, usable: NDArray[np.bool_] | None = None) -> ColourModels:
    usable = np.ones(rgb.shape[:2], np.bool_) if usable is None else usable
    plates = [np.zeros(rgb.shape[:2], np.float32)]
    return learn_colours(
        [rgb], [usable], [colour_cells(rgb)], [seen.shown], np.zeros(1, np.int64), plates
    )


# --- the contour of a posed body


def test_the_contour_goes_around_the_box_and_outward() -> None:
    seen = contour()
    away = seen.uv - (CAMERA.cx, CAMERA.cy)
    np.testing.assert_allclose(np.abs(away).max(axis=1), SIDE_PX / 2, atol=0.4)
    assert ((away * seen.normals).sum(axis=1) > 0).all()
    np.testing.assert_allclose(np.linalg.norm(seen.normals, axis=1), 1.0)
    assert len(seen.parts) > 4 * SIDE_PX / 2.5, "two pixels apart all around"
    assert (seen.shown >= 0).sum() == pytest.approx(SIDE_PX**2, rel=0.05)


def test_points_of_the_contour_are_places_on_the_part() -> None:
    seen = contour(x_m=0.1)
    p = seen.points + np.array([0.1, 0.0, DEPTH_M])
    np.testing.assert_allclose(CAMERA.project(p), seen.uv, atol=0.6)
    assert (np.abs(seen.points).max(axis=1) < SIDE_M / 2 + 0.01).all()


@pytest.mark.parametrize(("x_m", "y_m"), [(3.0, 0.0), (0.0, -3.0)])
def test_a_body_out_of_the_picture_has_no_contour(x_m: float, y_m: float) -> None:
    seen = contour(x_m, y_m)
    assert len(seen.parts) == 0
    assert (seen.shown < 0).all()
    assert offsets(seen, models(picture(), contour()), 0, REACH_PX).shape == (0,)


def test_where_the_picture_ends_the_body_does_not() -> None:
    seen = contour(x_m=0.62)
    assert len(seen.parts) > 0
    assert seen.uv[:, 0].max() < WIDTH - 0.5
    assert not ((seen.normals[:, 0] > 0.9) & (seen.uv[:, 0] > WIDTH - 3)).any()


# --- where the picture has it


@pytest.mark.parametrize("wider_px", [-4.0, -1.5, 0.0, 0.4, 2.25, 5.0])
def test_how_much_wider_it_is_seen_is_found_to_a_share_of_a_pixel(wider_px: float) -> None:
    seen, rgb = contour(), picture(wider_px)
    away = offsets(seen, models(rgb, seen), 0, REACH_PX)
    straight = np.abs(seen.normals).max(axis=1) > 0.99
    assert np.isfinite(away[straight]).mean() > 0.7
    assert np.nanmedian(away[straight]) == pytest.approx(wider_px, abs=0.3)


@pytest.mark.parametrize("behind", [THING, (196, 62, 52)], ids=["the same", "nearly the same"])
def test_before_a_background_of_its_own_colour_nothing_is_found(
    behind: tuple[int, int, int],
) -> None:
    seen, rgb = contour(), picture(2.0, behind=behind)
    assert np.isnan(offsets(seen, models(rgb, seen), 0, REACH_PX)).all()


def test_of_two_places_that_fit_as_well_neither_is_taken() -> None:
    """A stripe of the background goes around inside: the body may end before or after it."""
    seen, rgb = contour(), picture(3.0)
    inside = np.abs(np.indices((HEIGHT, WIDTH)) - np.array([CAMERA.cy, CAMERA.cx])[:, None, None])
    away = inside.max(axis=0) - SIDE_PX / 2
    alone = models(rgb, seen)
    striped = rgb.copy()
    stripe = (away > -4) & (away < -1)
    striped[stripe] = picture(-30.0)[stripe]
    cells = [colour_cells(striped)]
    doubtful = replace(alone, rgb=[striped], cells=cells)
    straight = np.abs(seen.normals).max(axis=1) > 0.99
    assert np.isfinite(offsets(seen, alone, 0, REACH_PX)[straight]).mean() > 0.7
    assert np.isnan(offsets(seen, doubtful, 0, REACH_PX)[straight]).mean() > 0.6


def test_farther_than_asked_nothing_is_looked_for() -> None:
    seen, rgb = contour(), picture(7.0)
    assert np.isnan(offsets(seen, models(rgb, seen), 0, 4.0)).all()


def test_what_may_not_be_used_decides_nothing() -> None:
    seen, rgb = contour(), picture(2.0)
    usable = np.ones(rgb.shape[:2], np.bool_)
    usable[:, : WIDTH // 2] = False
    away = offsets(seen, models(rgb, seen, usable), 0, REACH_PX)
    left = seen.uv[:, 0] < WIDTH / 2 - REACH_PX
    assert np.isnan(away[left]).all()
    assert np.isfinite(away[~left]).any()


def test_a_part_too_small_to_learn_its_colours_is_not_found() -> None:
    seen, rgb = contour(), picture(2.0)
    hardly = np.full_like(seen.shown, -1)
    hardly[58:62, 78:82] = 0
    few = learn_colours(
        [rgb],
        [np.ones(rgb.shape[:2], np.bool_)],
        [colour_cells(rgb)],
        [hardly],
        np.zeros(1, np.int64),
        [np.zeros(rgb.shape[:2], np.float32)],
    )
    np.testing.assert_array_equal(few.odds_of, 0.0)
    assert np.isnan(offsets(seen, few, 0, REACH_PX)).all()


def test_a_body_that_fills_the_picture_leaves_no_background_to_learn() -> None:
    seen, rgb = contour(), picture(2.0)
    filled = replace(seen, shown=np.zeros_like(seen.shown))
    np.testing.assert_array_equal(models(rgb, filled).odds_of, 0.0)


# --- the empty scene


def moving_thing(count: int, shift_px: int = 0) -> list[Picture]:
    """A square that goes across a pattern, which itself may go as well."""
    rng = np.random.default_rng(2)
    wide = rng.integers(60, 120, (HEIGHT, WIDTH + 200, 3))
    out = []
    for k in range(count):
        shown = wide[:, k * shift_px : k * shift_px + WIDTH].copy()
        shown[40:80, 10 + 20 * k : 30 + 20 * k] = THING
        out.append(shown.astype(np.uint8))
    return out


def test_what_differs_from_the_empty_scene_is_the_body() -> None:
    pictures = moving_thing(FEWEST_FOR_PLATE + 1)
    odds = plate_odds(pictures[:2], pictures[2:])
    assert len(odds) == 2
    for k in range(2):
        assert odds[k][45:75, 12 + 20 * k : 28 + 20 * k].min() > 1.0
        assert odds[k][90:].max() < -1.0


@pytest.mark.parametrize(
    ("count", "shift_px"), [(FEWEST_FOR_PLATE - 1, 0), (FEWEST_FOR_PLATE + 1, 9)]
)
def test_of_few_pictures_or_a_camera_that_moves_no_empty_scene_is_known(
    count: int, shift_px: int
) -> None:
    pictures = moving_thing(count, shift_px)
    for odds in plate_odds(pictures[:2], pictures[2:]):
        np.testing.assert_array_equal(odds, 0.0)
