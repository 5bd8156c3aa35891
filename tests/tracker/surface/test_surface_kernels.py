"""The compiled loops of surface fitting agree with their plain twins."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.kernels.cells import grid_of, nearest
from keypose.tracker.kernels.surface import distance_to_others, pose_surface, pull


def _cloud(seed: int, count: int = 300):
    rng = np.random.default_rng(seed)
    points, normals = rng.normal(size=(2, count, 3))
    return points, normals / np.linalg.norm(normals, axis=1, keepdims=True)


@pytest.mark.parametrize("cell", [0.05, 0.3, 5.0])
@pytest.mark.parametrize("least", [-2.0, 0.5])
def test_the_nearest_point_is_that_of_a_search_through_all(cell: float, least: float) -> None:
    points, normals = _cloud(1)
    queries, toward = _cloud(2)
    queries[:5] += 2.5  # outside the grid
    found, square = np.empty(300, np.int64), np.empty(300)
    nearest(queries, toward, points, normals, grid_of(points, cell), 1.5, least, found, square)
    apart = ((queries[:, None] - points) ** 2).sum(axis=2)
    apart[toward @ normals.T < least] = np.inf
    within = apart.min(axis=1) < 1.5**2
    np.testing.assert_array_equal(found[within], apart.argmin(axis=1)[within])
    np.testing.assert_allclose(square[within], apart.min(axis=1)[within])
    assert (found[~within] == -1).all()
    assert within.any()


def test_all_points_are_in_their_cells_however_many_there_would_be() -> None:
    points = np.array([[0.0, 0.0, 0.0], [1e4, 1e4, 1e4], [0.1, 0.0, 0.0]])
    *_, starts, order = grid_of(points, 1e-3)
    assert sorted(order.tolist()) == [0, 1, 2]
    assert starts[-1] == 3


def test_distances_to_other_parts_are_those_of_a_search_through_all() -> None:
    points, normals = _cloud(3)
    part = np.arange(300) % 4
    apart = np.ones((300, 4), dtype=bool)
    apart[part == 0, 1] = False
    distance = np.empty(300)
    grid = grid_of(points, 0.4)
    distance_to_others(points, normals, part, apart, grid, 0.6, distance)
    away = np.linalg.norm(points[:, None] - points, axis=2)
    away[(part[:, None] == part) | ~apart[:, part]] = np.inf
    other = away.argmin(axis=1)
    side = ((points - points[other]) * normals[other]).sum(axis=1)
    expected = np.where(side >= 0, 1.0, -1.0) * away.min(axis=1)
    expected[away.min(axis=1) > 0.6] = np.inf
    np.testing.assert_allclose(distance, expected)
    assert np.isfinite(distance).any()
    assert np.isinf(distance).any()


def _carried(seed: int):
    """Points that two parts carry, in two groups."""
    rng = np.random.default_rng(seed)
    p_each = rng.normal(size=(40, 2, 3))
    first = rng.uniform(0.5, 1.0, size=40)
    first[::3] = 1.0
    return p_each, np.stack([first, 1 - first], axis=1), np.arange(40) % 2


def _products(n):
    """The products of coordinates whose sums of squares are the same however n is turned."""
    return np.concatenate([n * n, np.sqrt(2.0) * n * np.roll(n, -1)])


@pytest.mark.parametrize("plane", [0.0, 0.7, 1.0])
def test_the_pull_is_the_sum_over_pairs_of_rows_and_residuals(plane: float) -> None:
    p_each, shares, groups = _carried(4)
    rng = np.random.default_rng(5)
    model = rng.integers(0, 40, size=90)
    target, normals = rng.normal(size=(2, 90, 3))
    weights = rng.uniform(size=90)
    n_model = rng.normal(size=(40, 3))
    A, b = np.empty((2, 18, 18)), np.empty((2, 18))
    total = pull(p_each, shares, groups, model, target, normals, weights, n_model, plane, A, b)
    A_plain, b_plain, total_plain = np.zeros_like(A), np.zeros_like(b), 0.0
    for v, q, n, w in zip(model, target, normals, weights, strict=True):
        axes = [(n, plane), *((axis, 1 - plane) for axis in np.eye(3))]
        for axis, share in axes:
            twists = [
                s * np.r_[axis, np.cross(p, axis)]
                for s, p in zip(shares[v], p_each[v], strict=True)
            ]
            row = np.concatenate([axis @ n_model[v] * _products(n_model[v]), *twists])
            r = axis @ (shares[v] @ p_each[v] - q)
            A_plain[groups[v]] += w * share * np.outer(row, row)
            b_plain[groups[v]] += w * share * row * r
            total_plain += w * share * r * r
    np.testing.assert_allclose(A, A_plain, atol=1e-12)
    np.testing.assert_allclose(b, b_plain, atol=1e-12)
    assert total == pytest.approx(total_plain)


def test_a_posed_surface_is_where_the_parts_carry_it_by_their_shares() -> None:
    rng = np.random.default_rng(6)
    _, shares, _ = _carried(7)
    p_part, n_part = rng.normal(size=(2, 40, 2, 3))
    parts = rng.integers(0, 3, size=(40, 2))
    Ts = rng.normal(size=(3, 4, 4))
    each, p, n = np.empty((40, 2, 3)), np.empty((40, 3)), np.empty((40, 3))
    pose_surface(p_part, n_part, parts, shares, Ts, each, p, n)
    expected = np.einsum("vkij,vkj->vki", Ts[parts][..., :3, :3], p_part) + Ts[parts][..., :3, 3]
    np.testing.assert_allclose(each, expected)
    np.testing.assert_allclose(p, np.einsum("vk,vki->vi", shares, expected))
    turned = np.einsum("vkij,vkj->vki", Ts[parts][..., :3, :3], n_part)
    np.testing.assert_allclose(n, np.einsum("vk,vki->vi", shares, turned))
