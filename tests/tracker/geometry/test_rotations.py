"""Rotations: every way to write one leads back to it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import (
    apply_transform,
    euler_from_rotation,
    exp_rotation,
    frozen,
    log_rotation,
    nearest_rotation,
    quaternion_wxyz,
    rotation_between,
    rotation_from_euler,
    rotation_from_quaternion,
    transform,
)

Floats = NDArray[np.float64]

steady = settings(derandomize=True, deadline=None, max_examples=80)
components = st.floats(-1, 1)
directions = (
    st.tuples(components, components, components)
    .map(np.array)
    .filter(lambda v: np.linalg.norm(v) > 0.1)
    .map(lambda v: v / np.linalg.norm(v))
)
angles = st.one_of(
    st.floats(0, math.pi),
    st.floats(0, 1e-6),
    st.floats(-9, -1).map(lambda k: math.pi - 10**k),
    st.sampled_from([0.0, math.pi, math.pi / 2]),
)


def is_rotation(R: Floats) -> None:
    np.testing.assert_allclose(R @ np.swapaxes(R, -1, -2), np.broadcast_to(np.eye(3), R.shape),
                               atol=1e-12)  # fmt: skip
    np.testing.assert_allclose(np.linalg.det(R), 1.0, atol=1e-12)


@steady
@given(directions, angles)
def test_the_logarithm_undoes_the_exponential_up_to_a_half_turn(axis: Floats, angle: float) -> None:
    R = exp_rotation(angle * axis)
    is_rotation(R)
    vector = log_rotation(R)
    np.testing.assert_allclose(exp_rotation(vector), R, atol=1e-12)
    if angle < math.pi - 1e-5:
        np.testing.assert_allclose(vector, angle * axis, atol=1e-9)
    assert np.linalg.norm(vector) <= math.pi + 1e-12


@pytest.mark.parametrize("turns", [1, 2, -3])
def test_whole_turns_are_no_turn_and_more_than_half_a_turn_is_the_shorter_way(turns: int) -> None:
    axis = np.array([0.6, 0.0, 0.8])
    np.testing.assert_allclose(exp_rotation(2 * np.pi * turns * axis), np.eye(3), atol=1e-12)
    vector = log_rotation(exp_rotation((2 * np.pi * turns + 4.0) * axis))
    np.testing.assert_allclose(vector, (4.0 - 2 * np.pi) * axis, atol=1e-12)


def test_a_tiny_rotation_keeps_all_its_digits() -> None:
    vector = np.array([1e-9, -2e-9, 3e-9])
    np.testing.assert_allclose(log_rotation(exp_rotation(vector)), vector, rtol=1e-7)


@pytest.mark.parametrize("shape", [(), (4,), (2, 3), (0,), (2, 0, 3)])
def test_batches_are_the_single_results_stacked(shape: tuple[int, ...]) -> None:
    vectors = np.random.default_rng(1).normal(0, 0.8, (*shape, 3))
    R = exp_rotation(vectors)
    assert R.shape == (*shape, 3, 3)
    np.testing.assert_allclose(log_rotation(R), vectors, atol=1e-12)
    assert euler_from_rotation(R).shape == (*shape, 3)
    assert quaternion_wxyz(R).shape == (*shape, 4)
    np.testing.assert_allclose(rotation_from_quaternion(quaternion_wxyz(R)), R, atol=1e-12)
    for place in np.ndindex(shape):
        np.testing.assert_allclose(exp_rotation(vectors[place]), R[place], atol=1e-15)


@steady
@given(st.floats(-math.pi, math.pi), st.floats(-1.57, 1.57), st.floats(-math.pi, math.pi))
def test_euler_angles_lead_back_to_their_rotation(z: float, y: float, x: float) -> None:
    R = rotation_from_euler(z, y, x)
    is_rotation(R)
    again = euler_from_rotation(R)
    assert abs(again[1]) <= math.pi / 2 + 1e-12
    np.testing.assert_allclose(rotation_from_euler(*again), R, atol=1e-9)


def test_euler_angles_turn_about_z_then_y_then_x_of_the_turned_frame() -> None:
    a, b, c = 0.3, -0.4, 0.5
    Qz = [[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]]
    Qy = [[math.cos(b), 0, math.sin(b)], [0, 1, 0], [-math.sin(b), 0, math.cos(b)]]
    Qx = [[1, 0, 0], [0, math.cos(c), -math.sin(c)], [0, math.sin(c), math.cos(c)]]
    expected = np.array(Qz) @ np.array(Qy) @ np.array(Qx)
    np.testing.assert_allclose(rotation_from_euler(a, b, c), expected, atol=1e-15)


@pytest.mark.parametrize("y", [math.pi / 2, -math.pi / 2])
def test_at_the_poles_the_euler_angles_still_give_the_rotation(y: float) -> None:
    R = rotation_from_euler(0.7, y, -0.2)
    np.testing.assert_allclose(rotation_from_euler(*euler_from_rotation(R)), R, atol=1e-7)


@steady
@given(directions, angles, st.floats(0.01, 100))
def test_quaternions_are_units_with_the_scalar_first_and_any_length_is_read(
    axis: Floats, angle: float, length: float
) -> None:
    R = exp_rotation(angle * axis)
    q = quaternion_wxyz(R)
    assert np.linalg.norm(q) == pytest.approx(1.0)
    assert q[0] >= 0
    assert q[0] == pytest.approx(math.cos(angle / 2), abs=1e-7)
    np.testing.assert_allclose(rotation_from_quaternion(length * q), R, atol=1e-12)
    np.testing.assert_allclose(rotation_from_quaternion(-q), R, atol=1e-12)


@steady
@given(directions, angles, st.floats(0, 0.2))
def test_the_nearest_rotation_mends_a_disturbed_one(
    axis: Floats, angle: float, size: float
) -> None:
    R = exp_rotation(angle * axis)
    is_rotation(nearest_rotation(R + size * np.outer(axis, axis[::-1])))
    np.testing.assert_allclose(nearest_rotation(R), R, atol=1e-12)
    np.testing.assert_allclose(nearest_rotation((1 + size) * R), R, atol=1e-12)


def test_no_other_rotation_is_nearer_than_the_nearest_also_for_a_reflection() -> None:
    rng = np.random.default_rng(3)
    matrices = rng.normal(size=(20, 3, 3))
    assert (np.linalg.det(matrices) < 0).any()
    nearest = nearest_rotation(matrices)
    is_rotation(nearest)
    distance = np.linalg.norm(matrices - nearest, axis=(1, 2))
    for turn in rng.normal(0, 0.1, (50, 1, 3)):
        others = np.linalg.norm(matrices - nearest @ exp_rotation(turn), axis=(1, 2))
        assert (others >= distance).all()


@steady
@given(directions, angles, directions, angles)
def test_the_path_between_two_rotations_meets_both_and_turns_about_one_axis(
    axis: Floats, angle: float, other: Floats, more: float
) -> None:
    start, end = exp_rotation(angle * axis), exp_rotation(more * other)
    path = rotation_between(start, end, np.linspace(0, 1, 5))
    np.testing.assert_allclose(path[0], start, atol=1e-12)
    np.testing.assert_allclose(path[-1], end, atol=1e-12)
    steps = np.swapaxes(path[:-1], -1, -2) @ path[1:]
    np.testing.assert_allclose(steps, np.broadcast_to(steps[0], steps.shape), atol=1e-9)


def test_the_path_of_a_whole_body_is_each_parts_own() -> None:
    rng = np.random.default_rng(4)
    start, end = exp_rotation(rng.normal(size=(2, 6, 3)))
    path = rotation_between(start, end, [0.25, 0.5])
    assert path.shape == (2, 6, 3, 3)
    for i in range(6):
        np.testing.assert_allclose(path[:, i], rotation_between(start[i], end[i], [0.25, 0.5]))


def test_transforms_turn_then_shift_points_of_every_batch() -> None:
    rng = np.random.default_rng(5)
    R, p, points = exp_rotation(rng.normal(size=(4, 3))), rng.normal(size=(4, 3)), rng.normal(
        size=(4, 7, 3)
    )  # fmt: skip
    T = transform(R, p)
    for k in range(4):
        expected = [R[k] @ point + p[k] for point in points[k]]
        np.testing.assert_allclose(apply_transform(T, points)[k], expected)
    np.testing.assert_array_equal(T[:, 3], np.tile([0, 0, 0, 1], (4, 1)))


def test_a_frozen_array_is_a_copy_that_cannot_be_written() -> None:
    source = np.arange(3.0)
    kept = frozen(source)
    source[0] = 9
    assert kept[0] == 0
    with pytest.raises(ValueError, match="read-only"):
        kept[0] = 1
