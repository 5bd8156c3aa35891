"""A small room, rendered exactly, seen by a camera that moves."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from bench.camera import errors
from bench.camera_worlds import Room
from keypose.tracker.camera_motion.find import MovedPath, find_moved_path
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array, exp_rotation, transform

CAMERA = Camera(width=320, height=180, fx=250, fy=250, cx=159.5, cy=89.5)
FRAMES = 45
Grey = NDArray[np.uint8]


@cache
def _film(metres: float, room_seed: int = 0) -> tuple[list[Grey], CameraPath]:
    """A camera that turns by 8° and goes so far aside, with the shake of a hand."""
    share, n = np.linspace(0, 1, FRAMES), np.arange(FRAMES)
    shake = 0.004 * np.stack([np.sin(1.3 * n), np.sin(0.9 * n), np.sin(1.7 * n)], axis=1)
    R = exp_rotation(np.stack([0 * share, np.radians(-8) * share, 0 * share], axis=1) + shake)
    p = metres * np.stack([share, 0.05 * np.sin(6 * share), 0.2 * share], axis=1)
    path = CameraPath(np.linalg.inv(transform(R, p)), np.ones(FRAMES))
    room, rng = Room.of(seed=room_seed), np.random.default_rng(0)
    films = []
    for T in path.Ts_camera_world:
        light = room.seen(CAMERA, T) + rng.normal(0, 1.5, (180, 320, 1))
        grey = cv2.cvtColor(np.clip(light, 0, 255).astype(np.uint8), cv2.COLOR_RGB2GRAY)
        films.append(np.asarray(grey, np.uint8))
    return films, path


def _found(pictures: list[Grey] | list[Grey | None]) -> MovedPath:
    return find_moved_path(pictures, CAMERA, len(pictures))


def test_the_way_of_a_camera_is_found_but_for_its_scale():
    pictures, true = _film(0.9)
    found = _found(pictures)
    turn, _, way = errors(found.path, true)
    assert found.moves
    assert found.known.all()
    assert not found.findings
    assert turn.max() < 0.3
    assert way.max() < 3.0
    np.testing.assert_array_equal(found.path.Ts_camera_world[0], np.eye(4))
    assert np.nanmedian(found.error_px) < 0.3


def test_a_camera_that_only_turns_is_not_said_to_move():
    pictures, true = _film(0.0)
    found = _found(pictures)
    assert not found.moves
    assert not found.path.moves
    assert [finding.kind for finding in found.findings] == ["no_parallax"]
    assert errors(found.path, true)[0].max() < 0.1


def test_the_focal_length_is_told_by_a_way_through_the_room():
    pictures, _ = _film(0.9)
    wrong = CAMERA.model_copy(update={"fx": 280.0, "fy": 280.0})
    found = find_moved_path(pictures, wrong, FRAMES, with_focal=True)
    assert found.focal is not None
    assert found.focal.scale * 280 == pytest.approx(250, rel=0.06)
    right = CAMERA.model_copy(update={"fx": 280 * found.focal.scale, "fy": 280 * found.focal.scale})
    again = find_moved_path(pictures, right, FRAMES, with_focal=True)
    assert again.focal is not None
    assert again.focal.scale == pytest.approx(1.0, abs=0.03)


def test_a_path_in_metres_is_the_path_with_its_way_scaled():
    found = _found(_film(0.9)[0])
    metric = found.in_metres(2.5)
    np.testing.assert_allclose(
        metric.Ts_world_camera[:, :3, 3], 2.5 * found.path.Ts_world_camera[:, :3, 3], atol=1e-12
    )


def test_frames_that_show_nothing_or_cannot_be_read_are_said_to_and_the_rest_is_found():
    pictures, true = _film(0.9)
    spoilt: list[Grey | None] = list(pictures)
    spoilt[30:34] = [None] * 4
    spoilt[38:41] = [np.full((180, 320), 120, np.uint8)] * 3
    found = _found(spoilt)
    assert [(f.kind, f.first_frame, f.last_frame) for f in found.findings] == [
        ("no_picture", 30, 33), ("no_texture", 38, 40),
    ]  # fmt: skip
    assert np.flatnonzero(~found.known).tolist() == [30, 31, 32, 33, 38, 39, 40]
    turn, _, way = errors(found.path, true)
    assert turn[found.known].max() < 0.3
    assert way[found.known].max() < 4.0
    assert way.max() < 8.0  # between them, bridged


def test_after_a_cut_the_path_begins_anew_and_both_pieces_are_right():
    (pictures, true), (others, other) = _film(0.9), _film(-0.9, 1)
    found = _found([*pictures, *others[::-1]])
    (cut,) = (finding for finding in found.findings if finding.kind == "cut")
    assert found.pieces == (0, cut.first_frame)
    assert FRAMES <= cut.first_frame < FRAMES + 8
    before = CameraPath(found.path.Ts_camera_world[:FRAMES], np.ones(FRAMES))
    assert errors(before, true)[2].max() < 3.0
    rest = slice(cut.first_frame - FRAMES, None)
    after = _from_first(found.path.Ts_camera_world[cut.first_frame :])
    turn, _, way = errors(after, _from_first(other.Ts_camera_world[::-1][rest]))
    assert turn.max() < 0.3
    assert way.max() < 4.0
    whole, apart = found.in_metres(2.0), found.in_metres(2.0, 3.0)
    np.testing.assert_allclose(apart.Ts_camera_world[:FRAMES], whole.Ts_camera_world[:FRAMES])
    steps, longer = (
        np.diff(path.Ts_world_camera[cut.first_frame :, :3, 3], axis=0) for path in (whole, apart)
    )
    np.testing.assert_allclose(longer, 1.5 * steps, atol=1e-9)
    with pytest.raises(ValueError, match="3 lengths were given for 2 pieces"):
        found.in_metres(1.0, 2.0, 3.0)


def _from_first(Ts: Array) -> CameraPath:
    return CameraPath(Ts @ np.linalg.inv(Ts[0]), np.ones(len(Ts)))


def test_someone_who_fills_the_picture_is_said_to_hide_the_background():
    pictures, _ = _film(0.9)
    hidden = np.zeros((180, 320), bool)
    found = find_moved_path(pictures, CAMERA, FRAMES, lambda frame: hidden if frame >= 38 else None)
    assert [(f.kind, f.first_frame) for f in found.findings] == [("body_fills", 38)]


def test_a_film_without_a_picture_has_a_path_without_a_frame():
    found = _found([])
    assert len(found.path) == 0
    assert not found.findings
