"""A camera that moves is turned only until it is seen to move; then every frame has a pose."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.camera_motion.findings import LOST_FRAMES
from keypose.tracker.camera_motion.moving_odometry import (
    BETWEEN,
    LONGEST,
    PATIENCE,
    RETRY,
    MovingOdometry,
)
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import rigid_inverse
from keypose.tracker.geometry.rotations import Array
from tests.tracker.camera_cases import Grey, off_deg, planes, turned

CAMERA = Camera(width=320, height=180, fx=250.0, fy=250.0, cx=159.5, cy=89.5)
BLACK = np.zeros((180, 320), np.uint8)
STEP = np.array([0.12, -0.01, 0.05])
FRAMES = 36


@cache
def filmed(frames: int = FRAMES, step: float = 1.0) -> list[Grey]:
    """A camera that goes aside before a wall, pillars and a floor, and turns by 0.2° a frame."""
    return [planes(CAMERA, rotation(k), step * k * STEP) for k in range(frames)]


def rotation(frame: int) -> Array:
    return turned(0.2 * frame)


def over(
    pictures: Sequence[Grey | None], usable: NDArray[np.bool_] | None = None
) -> MovingOdometry:
    odometry = MovingOdometry(CAMERA)
    for picture in pictures:
        odometry.take(picture, usable)
    return odometry


def ways_off(Ts: Array, frames: Sequence[int] | None = None) -> Array:
    """By how much places are off, as a share of the way, by the scale that fits best."""
    rows = np.arange(len(Ts)) if frames is None else np.array(frames)
    p, true = rigid_inverse(Ts)[rows, :3, 3], rows[:, None] * STEP
    scale = (p * true).sum() / (p * p).sum()
    return np.asarray(np.linalg.norm(scale * p - true, axis=1) / np.linalg.norm(true[-1]))


def test_the_camera_is_found_to_move_and_where_it_went() -> None:
    odometry = over(filmed())
    Ts = odometry.finished()
    assert odometry.has_depths
    assert Ts.shape == (FRAMES, 4, 4)
    np.testing.assert_array_equal(Ts[0], np.eye(4))
    assert ways_off(Ts).max() < 0.03
    assert off_deg(Ts, [rotation(k) for k in range(FRAMES)]).max() < 0.3
    assert odometry.causes == [""] * FRAMES
    assert np.median(odometry.errors_px) < 0.5


def test_after_a_while_less_parallax_will_do() -> None:
    before, after = (over(filmed(frames)) for frames in (PATIENCE, PATIENCE + RETRY))
    assert not before.has_depths
    assert after.has_depths
    Ts = after.finished()
    assert ways_off(Ts).max() < 0.05


def test_a_short_way_is_told_at_the_end_when_no_more_can_come() -> None:
    short = filmed(14, 0.3)
    odometry = over(short)
    assert not odometry.has_depths
    Ts = odometry.finished()
    assert odometry.has_depths
    assert ways_off(Ts).max() < 0.2


def test_a_camera_that_only_turns_stays_in_its_place() -> None:
    odometry = over([planes(CAMERA, turned(0.5 * k), np.zeros(3)) for k in range(20)])
    Ts = odometry.finished()
    assert not odometry.has_depths
    assert off_deg(Ts, [turned(0.5 * k) for k in range(20)]).max() < 0.1
    assert np.abs(rigid_inverse(Ts)[:, :3, 3]).max() < 0.02


def test_keyframes_are_set_as_often_as_said() -> None:
    slowly = over(filmed(60, 0.05))
    frames = [keyframe.frame for keyframe in slowly._map.keyframes]
    picked = [slowly._map.keyframes[number].frame for number in np.unique(slowly._map.anchor)]
    assert np.diff(frames).max() == BETWEEN
    assert np.diff(picked).max() == LONGEST


def test_a_frame_that_cannot_be_read_has_no_pose_of_its_own() -> None:
    pictures: list[Grey | None] = [*filmed()]
    pictures[20] = None
    odometry = over(pictures)
    Ts = odometry.finished()
    assert odometry.causes[20] == "no_picture"
    assert np.isnan(odometry.errors_px[20])
    assert ways_off(Ts, [k for k in range(FRAMES) if k != 20]).max() < 0.03


def test_a_camera_that_is_lost_for_a_while_is_found_again() -> None:
    pictures = [*filmed()]
    pictures[20:23] = [BLACK] * 3
    odometry = over(pictures)
    Ts = odometry.finished()
    assert not odometry.ended
    assert odometry.causes[20:23] == ["no_texture"] * 3
    assert odometry.causes[23:] == [""] * (FRAMES - 23)
    assert ways_off(Ts, [*range(20), *range(23, FRAMES)]).max() < 0.03


def test_another_scene_ends_it() -> None:
    elsewhere = [np.ascontiguousarray(picture[::-1, ::-1]) for picture in filmed()]
    odometry = MovingOdometry(CAMERA)
    taken = 0
    for picture in [*filmed(), *elsewhere]:
        odometry.take(picture, None)
        taken += 1
        if odometry.ended:
            break
    assert FRAMES < taken <= FRAMES + 2 * LOST_FRAMES
    odometry.drop_last()
    assert len(odometry.finished()) == len(odometry.causes) == taken - 1


CAUSES = {
    "black": (BLACK, None, "no_texture"),
    "hidden": (planes(CAMERA, np.eye(3), np.zeros(3)), np.zeros((180, 320), bool), "body_fills"),
}


@pytest.mark.parametrize("name", CAUSES)
def test_where_there_is_nothing_to_follow_the_cause_is_said(name: str) -> None:
    picture, usable, cause = CAUSES[name]
    odometry = over([picture] * 4, usable)
    assert set(odometry.causes) == {cause}
    assert not odometry.has_depths
    np.testing.assert_array_equal(odometry.finished(), np.stack([np.eye(4)] * 4))
