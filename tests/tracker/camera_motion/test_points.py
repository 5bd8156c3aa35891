"""Points of the background are picked evenly, and followed to a fraction of a pixel."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.camera_motion.points import BORDER_PX, CELLS, KeyframePicture, PointFollower
from keypose.tracker.geometry.rotations import Array
from tests.tracker.camera_cases import Grey, noisy, texture

WIDTH, HEIGHT = 320, 180
SCENE = texture(3)
NOBODY = np.zeros(0, np.int64), np.zeros((0, 2))


def view(u: float = 0.0, v: float = 0.0) -> Grey:
    """The scene from (u, v) on: what is at a pixel is (u, v) farther left and up."""
    shift = np.array([[1.0, 0.0, -(600.0 + u)], [0.0, 1.0, -(300.0 + v)]])
    return np.asarray(cv2.warpAffine(SCENE, shift, (WIDTH, HEIGHT), flags=cv2.INTER_LINEAR))


def started(
    picture: Grey | None = None, usable: NDArray[np.bool_] | None = None
) -> tuple[PointFollower, KeyframePicture]:
    follower = PointFollower(WIDTH, HEIGHT)
    follower.look(view() if picture is None else picture)
    return follower, follower.pick(usable, *NOBODY)


# --- picking


def test_points_are_picked_one_a_cell_all_over_the_picture() -> None:
    follower, keyframe = started()
    assert 0.5 * CELLS < len(keyframe.ids) <= 1.1 * CELLS
    assert follower.in_empty_cells(keyframe.uv, np.zeros((0, 2))).all()
    quarters = 2 * (keyframe.uv[:, 0] > WIDTH / 2) + (keyframe.uv[:, 1] > HEIGHT / 2)
    assert np.bincount(quarters.astype(int), minlength=4).min() > len(keyframe.ids) / 6
    far = np.array([WIDTH - 1, HEIGHT - 1]) - BORDER_PX
    assert ((keyframe.uv >= BORDER_PX) & (keyframe.uv <= far)).all()


WALLS: dict[str, Grey] = {
    "black": np.zeros((HEIGHT, WIDTH), np.uint8),
    "grey": np.full((HEIGHT, WIDTH), 128, np.uint8),
    "noisy": noisy(np.full((HEIGHT, WIDTH), 120, np.uint8), np.random.default_rng(0), 3.0),
}


@pytest.mark.parametrize("name", WALLS)
def test_on_a_wall_hardly_a_point_is_picked(name: str) -> None:
    follower, keyframe = started(WALLS[name])
    assert len(keyframe.ids) < 12
    assert not follower.could_pick(None, 12)


def test_on_what_is_no_background_nothing_is_picked_nor_near_it() -> None:
    usable = np.ones((HEIGHT, WIDTH), bool)
    usable[:, 150:] = False
    _, keyframe = started(usable=usable)
    assert len(keyframe.ids) > 50
    assert keyframe.uv[:, 0].max() < 150 - 6


def test_points_that_are_known_keep_their_ids_and_their_cells() -> None:
    follower, first = started()
    few = first.ids[::3], first.uv[::3]
    second = follower.pick(None, *few)
    np.testing.assert_array_equal(second.ids[: len(few[0])], few[0])
    np.testing.assert_array_equal(second.uv[: len(few[0])], few[1])
    fresh = second.ids[len(few[0]) :]
    assert fresh.min() > first.ids.max()
    assert follower.in_empty_cells(second.uv, np.zeros((0, 2))).all()


# --- following


def error_px(uv: Array, keyframe: KeyframePicture, shift: tuple[float, float]) -> Array:
    return np.linalg.norm(uv - (keyframe.uv - shift), axis=1)


@pytest.mark.parametrize("shift", [(0.0, 0.0), (2.3, -1.4), (7.0, 5.5), (-11.5, 3.0)], ids=str)
def test_points_are_followed_to_a_fraction_of_a_pixel(shift: tuple[float, float]) -> None:
    follower, keyframe = started()
    rough, followed = follower.look(view(*shift))
    assert followed.mean() > 0.7
    assert np.median(error_px(rough, keyframe, shift)[followed]) < 0.5
    uv, tracked = follower.refine(rough, None)
    assert tracked.mean() > 0.7
    assert np.median(error_px(uv, keyframe, shift)[tracked]) < 0.05
    assert np.percentile(error_px(uv, keyframe, shift)[tracked], 95) < 0.5


def test_a_jerk_of_a_third_of_the_picture_is_followed() -> None:
    follower, keyframe = started()
    shift = (100.0, -20.0)
    rough, followed = follower.look(view(*shift))
    inside = ((keyframe.uv - shift > 10) & (keyframe.uv - shift < (310, 170))).all(axis=1)
    assert followed[inside].mean() > 0.6
    assert np.median(error_px(rough, keyframe, shift)[followed]) < 0.5


def test_errors_do_not_add_up_from_frame_to_frame() -> None:
    follower, keyframe = started()
    for k in range(1, 41):
        rough, _ = follower.look(view(0.7 * k, 0.4 * k))
        uv, tracked = follower.refine(rough, None, halvings=0)
    assert np.median(error_px(uv, keyframe, (28.0, 16.0))[tracked]) < 0.05


def test_a_point_that_was_hidden_is_found_again() -> None:
    follower, keyframe = started()
    hidden = view()
    hidden[40:140, 100:220] = 0
    follower.look(hidden)
    _, tracked = follower.refine(keyframe.uv, None)
    behind = ((keyframe.uv > (112, 52)) & (keyframe.uv < (208, 128))).all(axis=1)
    assert tracked[behind].mean() < 0.1
    follower.look(view())
    uv, tracked = follower.refine(keyframe.uv, None)
    assert tracked[behind].mean() > 0.9
    assert error_px(uv, keyframe, (0.0, 0.0))[tracked & behind].max() < 0.1


def test_points_on_what_is_no_background_are_not_taken() -> None:
    follower, keyframe = started()
    usable = np.ones((HEIGHT, WIDTH), bool)
    usable[:, :160] = False
    follower.look(view())
    _, tracked = follower.refine(keyframe.uv, usable)
    assert not tracked[keyframe.uv[:, 0] < 160].any()
    assert tracked[keyframe.uv[:, 0] > 180].mean() > 0.9
    assert follower.visible <= (keyframe.uv[:, 0] > 160).sum()


def test_points_expected_outside_the_picture_or_nowhere_are_not_found() -> None:
    follower, keyframe = started()
    follower.look(view())
    expected = keyframe.uv.copy()
    expected[:20] += (1000.0, 0.0)
    expected[20:30] = -1e4
    uv, tracked = follower.refine(expected, None)
    assert not tracked[:30].any()
    assert tracked[30:].mean() > 0.9
    np.testing.assert_array_equal(uv[:30], expected[:30])  # where they are taken to be


LIGHTS = {"darker": (0.7, 0.0), "brighter": (1.2, 10.0), "flatter": (0.6, 40.0)}


@pytest.mark.parametrize("name", LIGHTS)
def test_a_change_of_light_is_not_taken_for_motion(name: str) -> None:
    gain, offset = LIGHTS[name]
    follower, keyframe = started()
    for k in range(1, 5):
        share = k / 4
        dimmed = view(0.5 * k) * (1 + share * (gain - 1)) + share * offset
        rough, _ = follower.look(np.clip(dimmed, 0, 255).astype(np.uint8))
        uv, tracked = follower.refine(rough, None)
    assert tracked.mean() > 0.7
    assert np.median(error_px(uv, keyframe, (2.0, 0.0))[tracked]) < 0.25


def test_noise_is_not_followed() -> None:
    follower, keyframe = started()
    follower.look(texture(77)[:HEIGHT, :WIDTH].copy())
    _, tracked = follower.refine(keyframe.uv, None)
    assert tracked.mean() < 0.15


def test_only_as_many_as_asked_are_followed_from_the_picture_before() -> None:
    follower, keyframe = started()
    rough, followed = follower.look(view(2.0), most=30)
    assert 20 <= followed.sum() <= 30
    np.testing.assert_array_equal(rough[~followed], keyframe.uv[~followed])


def test_the_whole_picture_tells_how_far_it_is_shifted_from_a_keyframe() -> None:
    follower, keyframe = started()
    follower.look(view(40.0, -12.0))
    np.testing.assert_allclose(follower.shift_from(keyframe), (-40.0, 12.0), atol=4.0)


def test_an_older_keyframe_can_be_gone_on_with() -> None:
    follower, first = started()
    follower.look(view(30.0))
    follower.pick(None, *NOBODY)
    follower.look(view(3.0))
    follower.use(first, first.uv - (3.0, 0.0))
    uv, tracked = follower.refine(first.uv - (3.0, 0.0), None)
    assert tracked.mean() > 0.8
    assert np.median(error_px(uv, first, (3.0, 0.0))[tracked]) < 0.05


# --- sizes


@pytest.mark.parametrize(("width", "height"), [(320, 180), (3840, 2160), (1080, 1920)])
def test_pixels_of_the_film_and_of_what_is_looked_at_lead_to_each_other(
    width: int, height: int
) -> None:
    follower = PointFollower(width, height)
    uv = np.array([[-0.5, -0.5], [width - 0.5, height - 0.5], [12.3, 45.6]])
    at = follower.to_look(uv)
    np.testing.assert_allclose(follower.to_film(at), uv)
    np.testing.assert_allclose(at[0], -0.5)  # the picture's corner stays its corner
    assert max(at[1] + 0.5) <= 960
    assert follower.scale == min(1.0, 960 / max(width, height))


def test_a_large_film_is_followed_in_its_own_pixels() -> None:
    large = cv2.resize(view(), (1280, 720), interpolation=cv2.INTER_CUBIC)
    moved = cv2.resize(view(2.0), (1280, 720), interpolation=cv2.INTER_CUBIC)
    follower = PointFollower(1280, 720)
    follower.look(np.asarray(large))
    keyframe = follower.pick(None, *NOBODY)
    rough, _ = follower.look(np.asarray(moved))
    uv, tracked = follower.refine(rough, None)
    assert tracked.mean() > 0.7
    assert np.median(error_px(uv, keyframe, (8.0, 0.0))[tracked]) < 0.2
