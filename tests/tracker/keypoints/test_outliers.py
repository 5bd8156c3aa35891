"""Keypoints that are for a few frames elsewhere are found, and fast limbs are not."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.keypoints.outliers import excursions

HEIGHT_PX = 400.0
FRAMES = 30
HIP = 0
KNEE = 1
ANKLE = 2


def walking() -> NDArray[np.float64]:
    """(N, 3, 2) a leg that swings while it goes to the right, 20 px a frame at its end."""
    n = np.arange(FRAMES)[:, None]
    swing = np.sin(n / 5) * np.array([0.0, 40.0, 75.0])
    across = 300 + 4 * n + swing
    down = np.tile([200.0, 300.0, 390.0], (FRAMES, 1))
    return np.stack([across, down], axis=-1)


def reported(uv: NDArray[np.float64]) -> NDArray[np.bool_]:
    known = np.isfinite(uv).all(axis=-1)
    return excursions(np.nan_to_num(uv), known, HEIGHT_PX)


def test_a_foot_seen_elsewhere_that_comes_back_is_reported_with_the_knee_that_goes_along() -> None:
    uv = walking()
    uv[12:16, ANKLE] -= (90, 30)
    uv[12:16, KNEE] -= (40, 0)
    found = reported(uv)
    assert found[12:16, [KNEE, ANKLE]].all()
    assert found.sum() == 8


def test_a_foot_that_comes_back_to_where_it_has_walked_meanwhile_was_away() -> None:
    uv = walking()
    uv[12:16, ANKLE, 0] -= 75
    uv[16:, ANKLE, 0] -= 25
    found = reported(uv)
    assert found[12:16, ANKLE].all()
    assert found.sum() == 4


@pytest.mark.parametrize("width", [1.0, 1.5, 2.0, 3.0])
def test_a_punch_and_a_walk_are_believed_however_fast(width: float) -> None:
    uv = walking()
    assert not reported(uv).any()
    away = np.exp(-(((np.arange(FRAMES) - 15) / width) ** 2))
    uv[:, ANKLE, 1] -= 150 * away
    assert not reported(uv).any()


def test_who_stays_away_was_followed_there() -> None:
    uv = walking()
    uv[12:, ANKLE] += (80, 0)
    assert not reported(uv).any()
    long = walking()
    long[8:22, ANKLE] += (80, 0)
    assert not reported(long).any()


def test_frames_that_show_nothing_are_no_step() -> None:
    uv = walking()
    uv[12:16, ANKLE] = np.nan
    assert not reported(uv).any()


TRUNK = ("left_shoulder", "right_shoulder", "left_hip", "right_hip", "left_wrist", "right_wrist")


def facing() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(N, 6, 2) pixels and (N, 6, 3) metres of a trunk and two hands that stand still."""
    across = np.array([0.2, -0.2, 0.12, -0.12, 0.4, -0.4])
    down = np.array([-0.5, -0.5, 0.0, 0.0, 0.0, 0.0])
    p = np.tile(np.stack([across, down, np.zeros(6)], axis=-1), (FRAMES, 1, 1))
    return 300 + 200 * p[..., :2], p


def with_arms_exchanged(values: NDArray[np.float64], frames: list[int]) -> NDArray[np.float64]:
    changed = values.copy()
    changed[frames] = values[frames][:, [1, 0, 2, 3, 5, 4]]
    return changed


def test_frames_that_tell_left_from_right_are_believed_among_such_as_exchange_the_arms() -> None:
    uv, p = facing()
    mostly = [n for n in range(FRAMES) if n not in (14, 15)]
    known = np.ones(uv.shape[:2], np.bool_)
    crossed = with_arms_exchanged(uv, mostly), with_arms_exchanged(p, mostly)
    assert excursions(crossed[0], known, HEIGHT_PX)[14:16].any()
    assert not excursions(crossed[0], known, HEIGHT_PX, TRUNK, crossed[1]).any()


def test_arms_exchanged_for_two_frames_are_elsewhere() -> None:
    uv, p = facing()
    known = np.ones(uv.shape[:2], np.bool_)
    crossed = with_arms_exchanged(uv, [14, 15]), with_arms_exchanged(p, [14, 15])
    found = excursions(crossed[0], known, HEIGHT_PX, TRUNK, crossed[1])
    assert found[14:16][:, [0, 1, 4, 5]].all()
    assert found.sum() == 8


def test_a_hand_that_jumps_alone_is_elsewhere_however_the_trunk_turns() -> None:
    uv, p = facing()
    uv[14:16, 5] += (0, 120)
    p = with_arms_exchanged(p, [n for n in range(FRAMES) if n not in (14, 15)])
    found = excursions(uv, np.ones(uv.shape[:2], np.bool_), HEIGHT_PX, TRUNK, p)
    assert found[14:16, 5].all()
    assert found.sum() == 2
