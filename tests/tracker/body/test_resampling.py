"""A motion at other times: right at its frames, and between them."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.resampling import resampled
from keypose.tracker.geometry.rotations import exp_rotation, log_rotation, transpose

AXIS = np.array([0.6, 0.64, 0.48])
RNG = np.random.default_rng(1)
UNEVEN_S = np.cumsum(RNG.uniform(0.02, 0.06, 60))


def test_at_its_own_times_a_motion_is_itself() -> None:
    Rs = exp_rotation(np.cumsum(RNG.normal(0, 0.4, (60, 5, 3)), axis=0))
    ps = RNG.normal(size=(60, 3))
    found = resampled(Rs, ps, UNEVEN_S, UNEVEN_S)
    np.testing.assert_allclose(found[0], Rs, atol=1e-12)
    np.testing.assert_allclose(found[1], ps, atol=1e-12)


@pytest.mark.parametrize("speed", [0.5, 10.0, 60.0])
def test_a_steady_motion_of_uneven_frames_stays_steady(speed: float) -> None:
    wanted = np.linspace(UNEVEN_S[0], UNEVEN_S[-1], 333)

    def at(times_s: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
        return exp_rotation(np.outer(times_s * min(speed, np.pi / 0.07), AXIS))[:, None]

    ps = np.outer(UNEVEN_S, [1.0, 2.0, 3.0])
    Rs, places = resampled(at(UNEVEN_S), ps, UNEVEN_S, wanted)
    np.testing.assert_allclose(Rs, at(wanted), atol=1e-9)
    np.testing.assert_allclose(places, np.outer(wanted, [1.0, 2.0, 3.0]), atol=1e-9)


def test_between_frames_a_swing_is_met_better_than_by_even_turns() -> None:
    def swing(times_s: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
        return exp_rotation(np.outer(np.sin(2 * np.pi * 1.5 * times_s), AXIS))

    own = np.arange(60) / 25
    wanted = own[1:-2] + 0.5 / 25
    found, _ = resampled(swing(own), np.zeros((60, 3)), own, wanted)
    off = np.linalg.norm(log_rotation(transpose(swing(wanted)) @ found), axis=-1)
    assert off.max() < np.radians(0.2)


@pytest.mark.parametrize("count", [2, 3])
def test_two_frames_are_enough(count: int) -> None:
    own = np.arange(count) / 25
    Rs = exp_rotation(np.outer(own, AXIS))
    found, _ = resampled(Rs, np.zeros((count, 3)), own, np.array([0.013]))
    np.testing.assert_allclose(found, exp_rotation(0.013 * AXIS)[None], atol=1e-12)
