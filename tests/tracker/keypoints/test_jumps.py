"""Keypoints that are for a few frames elsewhere are told, and fast limbs are not."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.keypoints.jumps import jumped_away

HEIGHT_PX = 400.0
FRAMES, HIP, KNEE, ANKLE = 30, 0, 1, 2


def walking() -> NDArray[np.float64]:
    """(N, 3, 2) a leg that swings while it goes to the right, 20 px a frame at its end."""
    n = np.arange(FRAMES)[:, None]
    swing = np.sin(n / 5) * np.array([0.0, 40.0, 75.0])
    across = 300 + 4 * n + swing
    down = np.tile([200.0, 300.0, 390.0], (FRAMES, 1))
    return np.stack([across, down], axis=-1)


def reported(uv: NDArray[np.float64]) -> NDArray[np.bool_]:
    known = np.isfinite(uv).all(axis=-1)
    return jumped_away(np.nan_to_num(uv), known, HEIGHT_PX)


def test_a_foot_seen_elsewhere_that_comes_back_is_reported_with_the_knee_that_goes_along() -> None:
    uv = walking()
    uv[12:16, ANKLE] -= (90, 30)
    uv[12:16, KNEE] -= (40, 0)
    found = reported(uv)
    assert found[12:16, [KNEE, ANKLE]].all()
    assert found.sum() == 8


@pytest.mark.parametrize("width", [1.0, 2.0, 3.0])
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
