"""Closing a segment and blending two chains: the loops against their plain twins."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.kernels.closing import blend, close_segment, find_correction, solve_three
from tests.tracker import reference_loops as plain
from tests.tracker.tracking_cases import random_body, random_trajectory

Floats = NDArray[np.float64]


def test_three_equations_are_solved_as_by_lapack_and_singular_ones_refused() -> None:
    rng = np.random.default_rng(0)
    x = np.empty(3)
    for _ in range(20):
        J, b = rng.normal(size=(3, 3)), rng.normal(size=3)
        assert solve_three(J, b, 1e-9, x)
        np.testing.assert_allclose(x, np.linalg.solve(J, b), rtol=1e-6)
    assert not solve_three(np.outer(b, b), b, 1e-9, x)
    assert not solve_three(np.full((3, 3), np.nan), b, 1e-9, x)


@pytest.mark.parametrize("n", [1, 2, 5, 40])
@pytest.mark.parametrize("even", [True, False])
def test_the_common_correction_is_the_twins(n: int, even: bool) -> None:
    rng = np.random.default_rng(n)
    shares = np.ones(n) if even else of_mean_one(rng, n)
    M = exp_rotation(rng.normal(0, 0.06, (n, 3)))
    T = exp_rotation(rng.normal(0, 0.7, 3))
    expected, rounds = plain.find_correction(M, T, shares)
    found = M.copy()
    assert find_correction(found, T, shares) == rounds
    np.testing.assert_allclose(found, expected, atol=1e-10)


def of_mean_one(rng: np.random.Generator, *shape: int) -> Floats:
    """Shares of a correction, some steps taking many times what others take."""
    shares = rng.uniform(0.05, 1.0, shape)
    return np.asarray(shares / shares.mean(axis=0))


def pass_over(
    n: int, seed: int, size: float = 0.04
) -> tuple[Trajectory, Floats, Floats, Trajectory]:
    """A trajectory, where a pass's motions lead from it, and one that holds the second keyframe."""
    skeleton = random_body(seed, parts=4)
    before = random_trajectory(skeleton, seed, n + 1)
    rng = np.random.default_rng([seed, 5])
    R_next = before.Rs_parent_part[1:] @ exp_rotation(rng.normal(0, size, (n, 4, 3)))
    t_next = before.ps_camera_root[1:] + rng.normal(0, size, (n, 3))
    other = random_trajectory(skeleton, seed, n + 1, size=0.05)
    return before, R_next, t_next, other


def shares_of(R_next: Floats) -> tuple[Floats, Floats]:
    """Uneven shares of the correction for every step: of each part, and of the root's place."""
    rng, n = np.random.default_rng(len(R_next)), len(R_next)
    return of_mean_one(rng, n, R_next.shape[1]), of_mean_one(rng, n)


def closed(
    before: Trajectory, R_next: Floats, t_next: Floats, R_end: Floats, t_end: Floats
) -> tuple[Floats, Floats, NDArray[np.int64]]:
    R, t = before.Rs_parent_part, before.ps_camera_root
    R_out, t_out = np.empty_like(R), np.empty_like(t)
    rounds, gaps = np.empty(R.shape[1], np.int64), np.empty(R.shape[1])
    turned, shifted = shares_of(R_next)
    close_segment(
        R, t, R_next, t_next, turned, shifted, R_end, t_end, R_out, t_out, rounds, gaps
    )  # fmt: skip
    assert gaps.max() < 1e-9
    return R_out, t_out, rounds


@pytest.mark.parametrize("n", [1, 2, 3, 20])
def test_a_segment_is_closed_as_by_the_twin(n: int) -> None:
    before, R_next, t_next, other = pass_over(n, seed=n)
    end = (other.Rs_parent_part[-1], other.ps_camera_root[-1])
    R_out, t_out, rounds = closed(before, R_next, t_next, *end)
    R_twin, t_twin = plain.close_segment(
        before.Rs_parent_part, before.ps_camera_root, R_next, t_next, *shares_of(R_next), *end
    )
    np.testing.assert_allclose(R_out, R_twin, atol=1e-9)
    np.testing.assert_allclose(t_out, t_twin, atol=1e-10)
    assert (rounds >= 0).all()


def test_inputs_are_left_as_they_were() -> None:
    before, R_next, t_next, other = pass_over(6, seed=9)
    kept = [x.copy() for x in (R_next, t_next, other.Rs_parent_part[-1])]
    closed(before, R_next, t_next, other.Rs_parent_part[-1], other.ps_camera_root[-1])
    for now, then in zip((R_next, t_next, other.Rs_parent_part[-1]), kept, strict=True):
        np.testing.assert_array_equal(now, then)


@pytest.mark.parametrize("n", [1, 2, 9])
def test_chains_are_blended_as_by_the_twin_from_one_end_to_the_other(n: int) -> None:
    skeleton = random_body(3, parts=5)
    a, b = (random_trajectory(skeleton, seed, n + 1) for seed in (11, 12))
    R, t = np.empty_like(a.Rs_parent_part), np.empty_like(a.ps_camera_root)
    turned = np.linspace(0, 1, n + 1)[:, None] ** np.array([1.0, 0.5, 2.0, 1.0, 3.0])
    shifted = np.linspace(0, 1, n + 1) ** 2
    blend(*a.writable(), *b.writable(), turned, shifted, R, t)
    expected = plain.blend(a.Rs_parent_part, b.Rs_parent_part, turned)
    np.testing.assert_allclose(R, expected, atol=1e-9)
    shares = shifted[:, None]
    np.testing.assert_allclose(
        t, (1 - shares) * a.ps_camera_root + shares * b.ps_camera_root, atol=1e-13
    )
    np.testing.assert_allclose(R[0], a.Rs_parent_part[0], atol=1e-12)
    np.testing.assert_allclose(R[-1], b.Rs_parent_part[-1], atol=1e-12)
