"""Points that stay aside are told from noise: their residuals grow, and last."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.camera_motion.steadiness import FEWEST_FRAMES, FEWEST_POINTS, Steadiness
from keypose.tracker.camera_motion.turn import Solved, Turn
from keypose.tracker.geometry.rotations import Array

COUNT = 60
NEAR = 15
"""Of these points lie nearer than the others."""


def solved(residual_px: Array) -> Solved:
    none = np.zeros((4, 0))
    agrees = np.ones(len(residual_px), bool)
    empty = np.zeros(0), np.zeros((0, 0))
    return Solved(Turn.none(), residual_px, agrees, np.eye(4), 0.2, *empty, none)


def followed(frames: int, drift_px: float, noise_px: float = 0.2, count: int = COUNT) -> Steadiness:
    """Points of which the near ones drift aside by so much a frame."""
    steadiness, rng = Steadiness(count), np.random.default_rng(0)
    for k in range(frames):
        residual = rng.normal(0, noise_px, (count, 2))
        residual[:NEAR, 0] += drift_px * k
        steadiness.add(np.ones(count, bool), solved(residual))
    return steadiness


def test_points_that_drift_aside_are_counted_and_how_far_they_are() -> None:
    summary = followed(20, drift_px=0.3).summary()
    assert summary.points == COUNT
    assert summary.aside == pytest.approx(NEAR / COUNT)
    assert 2.0 < summary.aside_px < 6.0
    assert summary.noise_px < 0.2


@pytest.mark.parametrize("noise_px", [0.1, 1.0, 3.0])
def test_noise_alone_leaves_no_point_aside(noise_px: float) -> None:
    summary = followed(30, 0.0, noise_px).summary()
    assert summary.aside < 0.05
    # the length of a mean over nine frames: of both axes, a third of each
    assert summary.noise_px == pytest.approx(noise_px * np.sqrt(2) / 3, rel=0.1)


def test_a_small_way_that_all_frames_show_is_not_called_aside() -> None:
    assert followed(30, 0.01, noise_px=0.02).summary().aside == 0.0


@pytest.mark.parametrize(
    ("frames", "count"), [(FEWEST_FRAMES - 1, COUNT), (20, FEWEST_POINTS - 1)], ids=["few", "less"]
)
def test_too_few_frames_or_points_say_nothing(frames: int, count: int) -> None:
    summary = followed(frames, 1.0, count=count).summary()
    assert (summary.aside, summary.aside_px, summary.noise_px) == (0.0, 0.0, 0.0)
    assert summary.points < FEWEST_POINTS


def test_a_point_that_is_not_tracked_learns_nothing() -> None:
    steadiness, rng = Steadiness(COUNT), np.random.default_rng(0)
    tracked = np.arange(COUNT) >= NEAR
    for k in range(20):
        residual = rng.normal(0, 0.2, (COUNT, 2))
        residual[NEAR:30, 0] += 0.3 * k
        steadiness.add(tracked, solved(residual[tracked]))
    summary = steadiness.summary()
    assert summary.points == COUNT - NEAR
    assert summary.aside == pytest.approx((30 - NEAR) / (COUNT - NEAR))


def test_points_behind_the_camera_count_as_far_aside_and_break_nothing() -> None:
    steadiness = Steadiness(COUNT)
    residual = np.zeros((COUNT, 2))
    residual[:NEAR] = 1e3
    residual[NEAR : NEAR + 2] = np.nan
    for _ in range(10):
        steadiness.add(np.ones(COUNT, bool), solved(residual))
    summary = steadiness.summary()
    assert summary.aside == pytest.approx(NEAR / COUNT)
    assert summary.aside_px < 100
