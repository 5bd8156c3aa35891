"""Small rotations in place: the loops against the geometry of whole arrays."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import exp_rotation, nearest_rotation
from keypose.tracker.kernels.rigid import (
    cleaned,
    compose,
    exponential,
    logarithm,
    product,
    turned_back,
)
from tests.tracker.geometry.test_rotations import angles, directions

Floats = NDArray[np.float64]

steady = settings(derandomize=True, deadline=None, max_examples=80)


def log_of(R: Floats) -> Floats:
    out = np.empty(3)
    logarithm(np.ascontiguousarray(R), out)
    return out


def test_products_are_those_of_matrices() -> None:
    a, b = np.random.default_rng(0).normal(size=(2, 3, 3))
    out = np.empty((3, 3))
    product(a, b, out)
    np.testing.assert_allclose(out, a @ b, atol=1e-14)
    turned_back(a, b, out)
    np.testing.assert_allclose(out, a.T @ b, atol=1e-14)


@steady
@given(directions, st.one_of(angles, st.floats(0, 12)))
def test_the_exponential_is_that_of_geometry(axis: Floats, angle: float) -> None:
    out = np.empty((3, 3))
    exponential(angle * axis, out)
    np.testing.assert_allclose(out, exp_rotation(angle * axis), atol=1e-14)


@steady
@given(directions, angles)
def test_the_logarithm_leads_back_to_the_rotation(axis: Floats, angle: float) -> None:
    R = exp_rotation(angle * axis)
    vector = log_of(R)
    assert np.linalg.norm(vector) <= math.pi + 1e-12
    np.testing.assert_allclose(exp_rotation(vector), R, atol=2e-12)
    if angle < math.pi - 1e-9:
        np.testing.assert_allclose(vector, angle * axis, atol=1e-7)


@pytest.mark.parametrize("short_of", [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-4, 0.0099, 0.0101])
def test_near_a_half_turn_the_logarithm_keeps_axis_and_side(short_of: float) -> None:
    rng = np.random.default_rng(1)
    axes = np.vstack([np.eye(3), -np.eye(3), [[0, 1, 1], [1, -1, 0]], rng.normal(size=(20, 3))])
    for axis in axes / np.linalg.norm(axes, axis=1, keepdims=True):
        for angle in (math.pi - short_of, math.pi + short_of):
            vector = log_of(exp_rotation(angle * axis))
            expected = axis * (angle if angle <= math.pi else angle - 2 * math.pi)
            if short_of < 1e-8:  # at a half turn both sides are right
                expected = expected * np.sign(expected @ vector)
            np.testing.assert_allclose(vector, expected, atol=1e-9)


def test_the_logarithm_of_no_turn_is_nothing_and_small_ones_keep_their_digits() -> None:
    np.testing.assert_array_equal(log_of(np.eye(3)), 0.0)
    vector = np.array([1e-9, -2e-9, 3e-9])
    np.testing.assert_allclose(log_of(exp_rotation(vector)), vector, rtol=1e-6)


def test_the_logarithm_of_numbers_that_are_none_is_none() -> None:
    assert np.isnan(log_of(np.full((3, 3), np.nan))).any()


def test_cleaning_brings_a_disturbed_rotation_back_to_the_nearest_one() -> None:
    rng = np.random.default_rng(2)
    for R in exp_rotation(rng.normal(size=(20, 3))):
        disturbed = R + rng.normal(0, 1e-5, (3, 3))
        mended = disturbed.copy()
        cleaned(mended)
        np.testing.assert_allclose(mended, nearest_rotation(disturbed), atol=1e-8)


def test_ten_thousand_compositions_leave_a_rotation() -> None:
    rng = np.random.default_rng(3)
    R, scratch = np.eye(3), np.empty((2, 3, 3))
    expected = np.eye(3)
    for v in rng.normal(0, 0.2, (10_000, 3)):
        compose(R, v, scratch)
        expected = expected @ exp_rotation(v)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-14)
    np.testing.assert_allclose(R, nearest_rotation(expected), atol=1e-10)
