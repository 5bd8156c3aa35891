"""A camera that somebody says is compared with the film's own background."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache

import numpy as np
import pytest

from keypose.tracker.camera_motion.agreement import Pair, error_px, followed_pairs
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array, transform
from tests.tracker.camera_cases import SMALL, Grey, planes, rendered, texture, turned

FRAMES = 24
SPANS = [(0, 10), (12, 22)]
EVERYWHERE: Callable[[int], None] = lambda frame: None  # noqa: E731
Pictures = Callable[[int, int, int], Iterator[tuple[int, Grey | None]]]


def read(pictures: list[Grey] | list[Grey | None]) -> Pictures:
    return lambda first, beyond, step: (
        (k, pictures[k]) for k in range(first, min(beyond, len(pictures)), step)
    )


@cache
def turning() -> tuple[Array, list[Grey]]:
    rotations = [turned(0.6 * k, 0.1 * k) for k in range(FRAMES)]
    Ts = transform(np.stack(rotations), np.zeros((FRAMES, 3)))
    return Ts, [rendered(SMALL, R) for R in rotations]


@cache
def moving() -> tuple[Array, list[Grey]]:
    p = np.stack([[0.06 * k, 0.0, 0.03 * k] for k in range(FRAMES)])
    Ts = transform(np.broadcast_to(np.eye(3), (FRAMES, 3, 3)), -p)
    return Ts, [planes(SMALL, np.eye(3), each) for each in p]


FILMS = {"turns": turning, "moves": moving}


def pairs_of(pictures: list[Grey] | list[Grey | None]) -> list[Pair]:
    return followed_pairs(read(pictures), (320, 180), SPANS, EVERYWHERE)


def path_at(pairs: list[Pair], Ts: Array, zoom: float = 1.0) -> CameraPath:
    """The path at both frames of each pair in turn."""
    frames = [frame for pair in pairs for frame in (pair.one, pair.other)]
    return CameraPath(Ts[frames], np.full(len(frames), zoom))


def off_px(pairs: list[Pair], Ts: Array, camera: Camera = SMALL, zoom: float = 1.0) -> float:
    error = error_px(pairs, camera, path_at(pairs, Ts, zoom))
    assert error is not None
    return error


@pytest.mark.parametrize("kind", FILMS)
def test_points_are_followed_over_each_span_and_half_of_it(kind: str) -> None:
    pairs = pairs_of(FILMS[kind]()[1])
    assert [(pair.one, pair.other) for pair in pairs] == [(0, 4), (0, 10), (12, 16), (12, 22)]
    assert kind in {pair.kind for pair in pairs}
    for pair in pairs:
        assert 20 <= len(pair.uv_one) == len(pair.uv_other) <= 80
    ways = [pair.way_px for pair in pairs]
    assert ways[0] < ways[1]


@pytest.mark.parametrize("kind", FILMS)
def test_the_true_camera_shows_points_where_they_went(kind: str) -> None:
    Ts, pictures = FILMS[kind]()
    assert off_px(pairs_of(pictures), Ts) < 0.5


WRONG: dict[str, Callable[[Array], Array]] = {
    "turned the other way": lambda Ts: np.swapaxes(Ts, 1, 2),
    "that stands still": lambda Ts: np.broadcast_to(np.eye(4), Ts.shape),
    "half as quick": lambda Ts: np.stack([Ts[k // 2] for k in range(len(Ts))]),
    "a second late": lambda Ts: Ts[np.maximum(np.arange(len(Ts)) - 8, 0)],
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_camera_that_turns_shows_them_elsewhere(name: str) -> None:
    Ts, pictures = turning()
    wrong = WRONG[name](Ts)
    assert off_px(pairs_of(pictures), wrong) > 5.0


def test_a_wrong_lens_shows_them_elsewhere() -> None:
    Ts, pictures = turning()
    longer = SMALL.model_copy(update={"fx": 1.5 * SMALL.fx, "fy": 1.5 * SMALL.fy})
    assert off_px(pairs_of(pictures), Ts, longer) > 5.0
    assert off_px(pairs_of(pictures), Ts, longer, zoom=1 / 1.5) < 0.5  # unless the zoom makes up


def test_the_length_of_the_way_does_not_matter_and_its_direction_does() -> None:
    Ts, pictures = moving()
    pairs = pairs_of(pictures)
    longer, upward = Ts.copy(), Ts.copy()
    longer[:, :3, 3] *= 7.0
    upward[:, :3, 3] = Ts[:, :3, 3][:, [1, 0, 2]]
    assert off_px(pairs, longer) < 0.5
    assert off_px(pairs, upward) > 3.0


FLICKER: list[Grey] = [texture(100 + k, 180, 320) for k in range(FRAMES)]
SILENT: dict[str, list[Grey | None]] = {
    "nothing": [],
    "black": [np.zeros((180, 320), np.uint8)] * FRAMES,
    "not readable": [None] * FRAMES,
    "of another size": [np.zeros((90, 160), np.uint8)] * FRAMES,
    "water": [*FLICKER],
}


@pytest.mark.parametrize("name", SILENT)
def test_pictures_without_a_background_tell_nothing(name: str) -> None:
    pairs = pairs_of(SILENT[name])
    assert pairs == []
    assert error_px(pairs, SMALL, CameraPath.standing_still(0)) is None


def test_where_only_one_pair_tells_nothing_is_said() -> None:
    Ts, pictures = turning()
    (first, *_) = pairs_of(pictures)
    assert error_px([first], SMALL, path_at([first], Ts)) is None


def test_of_a_camera_that_is_said_to_turn_points_that_tell_of_a_way_say_nothing() -> None:
    Ts, pictures = moving()
    deep = [pair for pair in pairs_of(pictures) if pair.kind == "moves"]
    assert len(deep) >= 2
    assert error_px(deep, SMALL, path_at(deep, Ts)) is not None
    still = np.broadcast_to(np.eye(4), Ts.shape)
    assert error_px(deep, SMALL, path_at(deep, still)) is None


def test_what_is_no_background_is_not_followed() -> None:
    left = np.ones((180, 320), bool)
    left[:, 160:] = False
    _, pictures = turning()
    pairs = followed_pairs(read(pictures), (320, 180), SPANS, lambda frame: left)
    assert pairs
    assert max(pair.uv_other[:, 0].max() for pair in pairs) < 160
