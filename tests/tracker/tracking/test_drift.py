"""Drift correction: the accumulated motion meets the second keyframe, always and exactly."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import exp_rotation, log_rotation, transpose
from keypose.tracker.kernels.closing import find_correction
from keypose.tracker.tracking.drift import Motions, closing_error, correct_drift
from tests.tracker import reference_loops as plain
from tests.tracker.tracking_cases import random_body, random_pose, random_trajectory

Floats = NDArray[np.float64]

steady = settings(derandomize=True, deadline=None, max_examples=150)


def unit(seed: int) -> Floats:
    v = np.random.default_rng(seed).normal(size=3)
    return v / np.linalg.norm(v)


def product_of(M: Floats) -> Floats:
    total = np.eye(3)
    for step in M:
        total = total @ step
    return total


@steady
@given(
    st.integers(2, 180), st.floats(0, np.deg2rad(150)), st.floats(0, np.deg2rad(120)),
    st.integers(0, 10**6),
)  # fmt: skip
def test_the_common_correction_is_found_in_few_rounds(
    n: int, drift: float, turn: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    steps = turn / n * unit(seed) + rng.normal(0, 0.02, (n, 3))
    M = exp_rotation(steps)
    T = product_of(M) @ exp_rotation(drift * unit(seed + 1))
    before = M.copy()
    rounds = find_correction(M, T, np.ones(len(M)))
    assert 0 <= rounds <= 8
    np.testing.assert_allclose(product_of(M), T, atol=1e-10)
    X = transpose(before) @ M
    np.testing.assert_allclose(X, np.broadcast_to(X[0], X.shape), atol=1e-10)


@steady
@given(st.integers(2, 120), st.floats(0, np.deg2rad(1.2)), st.integers(0, 10**6))
def test_an_error_that_every_motion_shares_is_removed_entirely(
    n: int, bias: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    true = exp_rotation(rng.normal(0, 0.02, (n, 3)))
    biased = true @ exp_rotation(bias * unit(seed))
    assert find_correction(biased, product_of(true), np.ones(len(biased))) >= 0
    np.testing.assert_allclose(biased, true, atol=1e-9)


@pytest.mark.parametrize("n", [10, 40, 180])
def test_the_printed_form_with_one_plus_y_does_not_get_there(n: int) -> None:
    rng = np.random.default_rng(n)
    M = exp_rotation(rng.normal(0, 0.03, (n, 3)))
    T = product_of(M) @ exp_rotation(0.5 * unit(n))
    printed = plain.printed_correction(M, T, rounds=20)
    assert min(printed) > 1e-8
    rounds = find_correction(M, T, np.ones(len(M)))
    assert 0 <= rounds <= 8
    assert np.linalg.norm(product_of(M) - T) < 1e-10


def disturbed(path: Trajectory, seed: int, size: float) -> Motions:
    """Motions that lead from every pose of a path a little beside the next one."""
    rng = np.random.default_rng([seed, 8])
    n, parts = len(path) - 1, path.Rs_parent_part.shape[1]
    turns = exp_rotation(rng.normal(0, size, (n, parts, 3)))
    shifts = rng.normal(0, size, (n, 3))
    return Motions(path.Rs_parent_part[1:] @ turns, path.ps_camera_root[1:] + shifts)


@pytest.mark.parametrize("n", [1, 2, 3, 17, 180])
def test_both_keyframes_are_met_whatever_the_motions_were(n: int) -> None:
    skeleton = random_body(n, parts=6)
    path, end = random_trajectory(skeleton, n, n + 1), random_pose(skeleton, n + 1, size=0.8)
    closed = correct_drift(path, disturbed(path, n, 0.05), end)
    assert closing_error(closed.trajectory, path.pose(0), end) <= 1e-9
    R = closed.trajectory.Rs_parent_part
    np.testing.assert_allclose(R @ transpose(R), np.broadcast_to(np.eye(3), R.shape), atol=1e-12)


@pytest.mark.parametrize("n", [2, 17])
def test_every_motion_of_a_part_is_corrected_by_the_same_turn(n: int) -> None:
    skeleton = random_body(n, parts=6)
    path, end = random_trajectory(skeleton, n, n + 1), random_pose(skeleton, n + 1, size=0.8)
    motions = disturbed(path, n, 0.05)
    closed = correct_drift(path, motions, end)
    assert (closed.rounds >= 0).all()
    R, before = closed.trajectory.Rs_parent_part, path.Rs_parent_part
    found = transpose(motions.Rs_parent_part) @ before[:-1] @ transpose(R[:-1]) @ R[1:]
    np.testing.assert_allclose(found, np.broadcast_to(found[0], found.shape), atol=1e-8)


@pytest.mark.parametrize("turns", [1, 2])
@pytest.mark.parametrize("n", [8, 30, 90])
def test_a_segment_with_a_full_turn_inside_is_closed_along_one_axis(n: int, turns: int) -> None:
    angles = np.linspace(0, 2 * np.pi * turns, n + 1)
    R = exp_rotation(angles[:, None] * unit(n))[:, None]
    path = Trajectory(0, R, np.zeros((n + 1, 3)))
    end = Pose(R[-1] @ exp_rotation([0.2, -0.1, 0.15]), np.zeros(3))
    closed = correct_drift(path, Motions(R[1:].copy(), np.zeros((n, 3))), end)
    assert closed.rounds[0] == -1
    assert closing_error(closed.trajectory, path.pose(0), end) <= 1e-9
    apart = log_rotation(transpose(R[:, 0]) @ closed.trajectory.Rs_parent_part[:, 0])
    shares = np.arange(n + 1)[:, None] / n
    np.testing.assert_allclose(apart, shares * apart[-1], atol=1e-9)


@pytest.mark.parametrize("turn", [0.9, 0.95, 0.963, 0.97, 0.985, 0.995, 0.9999, 1.003, 1.02, 1.1])
def test_near_a_full_turn_the_correction_does_not_run_away(turn: float) -> None:
    n, axis = 40, unit(1)
    R = exp_rotation(np.linspace(0, 2 * np.pi * turn, n + 1)[:, None] * axis)[:, None]
    path = Trajectory(0, R, np.zeros((n + 1, 3)))
    gap = np.array([0.05, -0.04, 0.06])
    end = Pose(R[-1] @ exp_rotation(gap), np.zeros(3))
    closed = correct_drift(path, Motions(R[1:].copy(), np.zeros((n, 3))), end)
    assert closing_error(closed.trajectory, path.pose(0), end) <= 1e-9
    apart = log_rotation(transpose(R[:, 0]) @ closed.trajectory.Rs_parent_part[:, 0])
    assert np.linalg.norm(apart, axis=1).max() < 4 * np.linalg.norm(gap)


def test_nothing_is_changed_where_nothing_has_drifted() -> None:
    skeleton = random_body(3)
    path = random_trajectory(skeleton, 3, 20)
    motions = Motions(path.Rs_parent_part[1:].copy(), path.ps_camera_root[1:].copy())
    closed = correct_drift(path, motions, path.pose(19))
    np.testing.assert_allclose(closed.trajectory.Rs_parent_part, path.Rs_parent_part, atol=1e-11)
    np.testing.assert_allclose(closed.trajectory.ps_camera_root, path.ps_camera_root, atol=1e-12)
    assert (closed.rounds == 0).all()


def test_the_roots_gap_is_shared_out_evenly_over_the_frames() -> None:
    skeleton = random_body(4, parts=2)
    path = random_trajectory(skeleton, 4, 11)
    motions = Motions(path.Rs_parent_part[1:].copy(), path.ps_camera_root[1:].copy())
    gap = np.array([0.3, -0.1, 0.2])
    end = Pose(path.Rs_parent_part[-1], path.ps_camera_root[-1] + gap)
    closed = correct_drift(path, motions, end).trajectory
    shares = np.arange(11)[:, None] / 10
    np.testing.assert_allclose(closed.ps_camera_root - path.ps_camera_root, shares * gap, atol=1e-9)


def test_the_roots_steps_are_added_up_in_the_roots_own_frame() -> None:
    n, step = 6, np.array([0.1, 0.0, 0.0])
    R = exp_rotation(np.linspace(0, np.pi / 2, n + 1)[:, None] * np.array([0.0, 1.0, 0.0]))[:, None]
    still = Trajectory(0, R, np.zeros((n + 1, 3)))
    motions = Motions(R[1:].copy(), (R[:-1, 0] @ step[:, None])[..., 0].copy())
    ahead = np.cumsum((R[:-1, 0] @ step[:, None])[..., 0], axis=0)
    closed = correct_drift(still, motions, Pose(R[-1], ahead[-1])).trajectory
    np.testing.assert_allclose(closed.ps_camera_root[1:], ahead, atol=1e-12)


def test_the_closing_error_sees_every_kind_of_miss() -> None:
    skeleton = random_body(5)
    path = random_trajectory(skeleton, 5, 4)
    start, end = path.pose(0), path.pose(3)
    assert closing_error(path, start, end) == 0.0
    aside = Pose(end.Rs_parent_part, end.p_camera_root + np.array([0.0, 0.25, 0.0]))
    assert closing_error(path, start, aside) == pytest.approx(0.25)
    turned = Pose(end.Rs_parent_part @ exp_rotation([0.0, 0.0, 0.3]), end.p_camera_root)
    assert closing_error(path, start, turned) > 0.1
    assert closing_error(path, turned, end) > 0.1
