"""The zero-phase low-pass: what is slow stays, what is fast goes, nothing is late."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import butter, sosfiltfilt

from keypose.tracker.body.resampling import (
    filtered_positions,
    filtered_rotations,
    least_frames,
    low_pass_kernel,
)
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation, transpose

RATE = 30.0
CUTOFF = 6.0
KERNEL = low_pass_kernel(CUTOFF, RATE)
TIMES_S = np.arange(300) / RATE
INNER = slice(40, -40)
AXIS = np.array([0.6, 0.64, 0.48])


def shaking(rng: np.random.Generator, size: float, count: int = 300) -> Array:
    """Rotations that shake about a swing."""
    swing = np.outer(np.sin(2 * np.pi * 0.8 * TIMES_S[:count]), 0.7 * AXIS)
    return exp_rotation(swing) @ exp_rotation(rng.normal(0.0, size, (count, 3)))


@pytest.mark.parametrize("rate", [25.0, 29.97, 60.0, 240.0])
@pytest.mark.parametrize("cutoff", [1.0, 6.0, 12.0])
def test_at_the_cutoff_it_is_3_dB_down(cutoff: float, rate: float) -> None:
    kernel = low_pass_kernel(cutoff, rate)
    offsets = np.arange(len(kernel)) - len(kernel) // 2
    gain = (kernel * np.cos(2 * np.pi * cutoff / rate * offsets)).sum()
    assert gain == pytest.approx(np.sqrt(0.5), abs=0.003)


def test_it_is_the_butterworth_filter_forward_and_back() -> None:
    one_pass = 2 / np.pi * np.arctan(np.tan(np.pi * CUTOFF / RATE) / (np.sqrt(2) - 1) ** 0.25)
    sections = butter(2, one_pass, output="sos")
    wave = np.random.default_rng(1).normal(size=300)
    expected = sosfiltfilt(sections, wave, padtype="odd", padlen=100)
    np.testing.assert_allclose(filtered_positions(wave, KERNEL), expected, atol=2e-3)


@pytest.mark.parametrize(("rate", "same_hz"), [(30.0, 5.0), (100.0, 4.8), (240.0, 4.8)])
def test_a_filter_of_6_Hz_run_forward_and_back_is_one_of_less_here(
    rate: float, same_hz: float
) -> None:
    """As `--filter` says of other programs."""
    impulse = np.zeros(2001)
    impulse[1000] = 1.0
    twice = sosfiltfilt(butter(2, 6.0, fs=rate, output="sos"), impulse, padlen=0)
    gain = np.abs(np.fft.rfft(twice))
    hz = np.fft.rfftfreq(len(twice), 1 / rate)
    assert np.interp(6.0, hz, gain) == pytest.approx(0.5, abs=0.001)  # 6 dB down
    kernel = low_pass_kernel(same_hz, rate)
    padded = np.pad(kernel, (2001 - len(kernel)) // 2)
    np.testing.assert_allclose(np.abs(np.fft.rfft(padded)), gain, atol=0.015)


@pytest.mark.parametrize("turns", [0.3, 5.0, 60.0])
def test_a_steady_turn_stays_itself_however_often_it_goes_round(turns: float) -> None:
    Rs = exp_rotation(np.outer(np.linspace(0, 2 * np.pi * turns, 300), AXIS))
    np.testing.assert_allclose(filtered_rotations(Rs, KERNEL), Rs, atol=1e-9)


def test_a_turn_that_shakes_is_filtered_past_whole_turns_as_well() -> None:
    angle = np.linspace(0, 14 * np.pi, 300) + 0.3 * np.sin(2 * np.pi * 9 * TIMES_S)
    found = filtered_rotations(exp_rotation(np.outer(angle, AXIS)), KERNEL)
    expected = exp_rotation(np.outer(filtered_positions(angle, KERNEL), AXIS))
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_near_the_identity_a_rotation_is_filtered_as_its_rotation_vector() -> None:
    vectors = np.random.default_rng(2).normal(0.0, 1e-4, (300, 3))
    found = log_rotation(filtered_rotations(exp_rotation(vectors), KERNEL))
    np.testing.assert_allclose(found, filtered_positions(vectors, KERNEL), atol=1e-9)


@given(st.integers(0, 1000))
def test_no_frame_of_reference_is_preferred(seed: int) -> None:
    rng = np.random.default_rng(seed)
    Rs = shaking(rng, 0.1, 60)
    left, right = exp_rotation(rng.normal(0.0, 1.5, (2, 3)))
    turned = filtered_rotations(left @ Rs @ right, KERNEL)
    np.testing.assert_allclose(turned, left @ filtered_rotations(Rs, KERNEL) @ right, atol=1e-8)


def test_the_filtered_motion_is_neither_late_nor_early() -> None:
    slow = np.sin(2 * np.pi * 1.0 * TIMES_S)
    fast = slow + 0.2 * np.sin(2 * np.pi * 12.0 * TIMES_S + 0.5)
    found = filtered_positions(fast, KERNEL)
    late = [np.corrcoef(np.roll(found, k)[INNER], slow[INNER])[0, 1] for k in range(-3, 4)]
    assert int(np.argmax(late)) == 3
    backward = filtered_rotations(exp_rotation(np.outer(fast, AXIS))[::-1], KERNEL)[::-1]
    forward = filtered_rotations(exp_rotation(np.outer(fast, AXIS)), KERNEL)
    np.testing.assert_allclose(forward, backward, atol=1e-9)


def test_the_ends_stay_where_they_are() -> None:
    Rs = shaking(np.random.default_rng(3), 0.05)
    found = filtered_rotations(Rs, KERNEL)
    np.testing.assert_allclose(found[[0, -1]], Rs[[0, -1]], atol=1e-9)
    ps = np.cumsum(np.random.default_rng(4).normal(size=(300, 3)), axis=0)
    np.testing.assert_allclose(filtered_positions(ps, KERNEL)[[0, -1]], ps[[0, -1]], atol=1e-9)


def test_shaking_goes_and_the_swing_stays() -> None:
    Rs = shaking(np.random.default_rng(5), 0.05)
    swing = shaking(np.random.default_rng(5), 0.0)
    found = filtered_rotations(Rs, KERNEL)
    off = np.linalg.norm(log_rotation(transpose(swing) @ found), axis=-1)
    assert np.sqrt(np.square(off).mean()) < 0.75 * 0.05 * np.sqrt(3)
    jerk = np.diff(log_rotation(transpose(found[:-1]) @ found[1:]), n=2, axis=0)
    jerk_before = np.diff(log_rotation(transpose(Rs[:-1]) @ Rs[1:]), n=2, axis=0)
    assert np.square(jerk).mean() < 0.03 * np.square(jerk_before).mean()


@pytest.mark.parametrize("count", [2, 6, 9])
def test_few_frames_are_filtered_as_if_their_trend_went_on(count: int) -> None:
    assert least_frames(CUTOFF, RATE) == 6
    angle = np.random.default_rng(6).normal(0.0, 0.2, count)
    found = filtered_rotations(exp_rotation(np.outer(angle, AXIS)), KERNEL)
    expected = exp_rotation(np.outer(filtered_positions(angle, KERNEL), AXIS))
    np.testing.assert_allclose(found, expected, atol=1e-9)
    np.testing.assert_allclose(found[[0, -1]], exp_rotation(np.outer(angle[[0, -1]], AXIS)))


@pytest.mark.parametrize("cutoff", [0.0, -1.0, 15.0, 40.0, np.nan])
def test_a_cutoff_that_the_rate_does_not_hold_is_refused(cutoff: float) -> None:
    with pytest.raises(ValueError, match="half the rate"):
        low_pass_kernel(cutoff, RATE)
