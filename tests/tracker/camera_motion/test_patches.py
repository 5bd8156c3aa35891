"""Landmarks are found again by what they look like, and nothing else is taken for them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.patches import MOST_KEPT, PATCH_PX, REACH, Patches, tiles
from keypose.tracker.camera_motion.points import KeyframePicture, PointFollower
from keypose.tracker.geometry.rotations import Array
from tests.tracker.camera_cases import SMALL, Grey, noisy, rendered, texture, turned

LENS = Lens.of(SMALL)
PICTURE = rendered(SMALL, np.eye(3))


def picked() -> KeyframePicture:
    follower = PointFollower(320, 180)
    follower.look(PICTURE)
    return follower.pick(None, np.zeros(0, np.int64), np.zeros((0, 2)))


def kept(keyframe: KeyframePicture) -> Patches:
    patches = Patches()
    patches.keep(PICTURE, 0, keyframe.ids, keyframe.uv, keyframe.uv)
    return patches


def inner(uv: Array) -> NDArray[np.int64]:
    """Rows of places well within the picture."""
    return np.flatnonzero(((uv > 24) & (uv < (295, 155))).all(axis=1))


def plain(count: int) -> Array:
    """Warps of pictures taken from one place with one lens."""
    return np.broadcast_to(np.eye(2), (count, 2, 2))


def test_landmarks_are_found_in_a_turned_and_zoomed_picture() -> None:
    R, zoom = turned(3, 1, 12), 1.2
    keyframe = picked()
    true = LENS.pixels(LENS.directions(keyframe.uv, 1.0) @ R.T, zoom)
    rows = inner(true)
    warps = np.broadcast_to(zoom * R[:2, :2], (len(rows), 2, 2))
    about = true[rows] + (2.0, -3.0)
    there, is_found = kept(keyframe).register(rows, rendered(SMALL, R, zoom), about, warps)
    off = np.linalg.norm(there - true[rows], axis=1)
    assert is_found.mean() > 0.8
    assert np.median(off[is_found]) < 0.15


def shifted(by: tuple[int, int]) -> Grey:
    return np.roll(PICTURE, by, axis=(1, 0))


CHANGES: dict[str, Grey] = {
    "moved": shifted((3, -2)),
    "darker, with less contrast": (shifted((3, -2)) * 0.6 + 20).astype(np.uint8),
    "noisy": noisy(shifted((3, -2)), np.random.default_rng(0), 6.0),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_landmark_is_found_to_a_fraction_of_a_pixel(name: str) -> None:
    keyframe = picked()
    rows = inner(keyframe.uv)
    true = keyframe.uv[rows] + (3.0, -2.0)
    there, is_found = kept(keyframe).register(
        rows, CHANGES[name], keyframe.uv[rows], plain(len(rows))
    )
    assert is_found.mean() > 0.9
    assert np.median(np.linalg.norm((there - true)[is_found], axis=1)) < 0.15


def test_another_scene_has_none_of_the_landmarks() -> None:
    keyframe = picked()
    other = rendered(SMALL, np.eye(3), seed=5)
    _, is_found = kept(keyframe).register(
        np.arange(len(keyframe.ids)), other, keyframe.uv, plain(len(keyframe.ids))
    )
    assert is_found.mean() < 0.1


def test_what_lies_too_far_from_where_it_is_expected_is_not_taken() -> None:
    keyframe = picked()
    rows = inner(keyframe.uv)
    far = keyframe.uv[rows] + (14.0, 0.0)
    _, is_found = kept(keyframe).register(rows, PICTURE, far, plain(len(rows)))
    assert is_found.mean() < 0.1


def test_asked_for_none_it_finds_none() -> None:
    there, is_found = kept(picked()).register(
        np.zeros(0, np.int64), PICTURE, np.zeros((0, 2)), np.zeros((0, 2, 2))
    )
    assert there.shape == (0, 2)
    assert is_found.shape == (0,)


@pytest.mark.parametrize("at", [(0.0, 0.0), (319.0, 179.0), (160.4, 90.6), (-40.0, 500.0)], ids=str)
def test_a_tile_shows_the_picture_about_its_place_and_its_edge_beyond(
    at: tuple[float, float],
) -> None:
    cut, first = tiles(PICTURE, np.array([at]))
    assert cut.shape == (1, PATCH_PX, PATCH_PX)
    columns = np.clip(first[0, 0] + np.arange(PATCH_PX), 0, 319).astype(int)
    rows = np.clip(first[0, 1] + np.arange(PATCH_PX), 0, 179).astype(int)
    np.testing.assert_array_equal(cut[0], PICTURE[np.ix_(rows, columns)])
    if 0 <= at[0] < 320:  # what lies outside is about the nearest tile
        assert np.abs(np.array(at) - first[0] - REACH).max() <= 0.5


def test_no_more_landmarks_are_kept_than_memory_has_room_for() -> None:
    patches, picture = Patches(), texture(0, 100, 100)
    for number in range(6):
        ids = np.arange(number * 4000, (number + 1) * 4000)
        uv = np.full((4000, 2), 50.0)
        patches.keep(picture, number, ids, uv, uv)
        assert len(patches) <= MOST_KEPT
    assert set(patches.anchor.tolist()) == set(range(6))
    assert (np.diff(patches.ids) > 0).all()
    assert len(patches.grey) == len(patches.uv) == len(patches.inside) == len(patches)
