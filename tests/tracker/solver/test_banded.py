"""Equations of many frames in banded form: the same as with every entry written out."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from keypose.tracker.kernels.steps import add_blocks, solve_banded
from keypose.tracker.solver.banded import banded_step, bordered_step

Floats = NDArray[np.float64]

FRAMES = 6
DOFS = 3
SIZE = FRAMES * DOFS


def dense(rows: Floats) -> Floats:
    """The symmetric matrix that rows from the diagonal on stand for."""
    size, width = rows.shape
    whole = np.zeros((size, size))
    for off in range(min(width, size)):
        diagonal = rows[: size - off, off]
        whole += np.diag(diagonal, off)
        if off:
            whole += np.diag(diagonal, -off)
    return whole


def random_banded(width: int, seed: int = 0) -> Floats:
    """Positive definite, with so many diagonals."""
    rng = np.random.default_rng(seed)
    rows = rng.normal(0, 1, (SIZE, width))
    rows[:, 0] = 4.0 * width
    return rows


def damped(A: Floats, damping: float) -> Floats:
    return A + np.diag(np.diag(A) * damping + 1e-6)


@pytest.mark.parametrize("off", [0, 1, 2, 5])
def test_blocks_between_frames_are_put_where_they_belong(off: int) -> None:
    rng = np.random.default_rng(off)
    blocks = rng.normal(0, 1, (FRAMES - off, DOFS, DOFS))
    if off == 0:
        blocks += np.swapaxes(blocks, 1, 2)
    before = random_banded((off + 1) * DOFS)
    expected = dense(before)
    for j, block in enumerate(blocks):
        one, other = (slice(k * DOFS, (k + 1) * DOFS) for k in (j, j + off))
        expected[one, other] += block
        if off:
            expected[other, one] += block.T
    add_blocks(blocks, off, before)
    np.testing.assert_allclose(dense(before), expected)


def test_equations_of_single_frames_are_blocks_on_the_diagonal() -> None:
    A = np.random.default_rng(2).normal(0, 1, (FRAMES, DOFS, DOFS))
    A += np.swapaxes(A, 1, 2)
    rows = np.zeros((SIZE, DOFS))
    add_blocks(A, 0, rows)
    found = dense(rows)
    for j, block in enumerate(A):
        own = slice(j * DOFS, (j + 1) * DOFS)
        np.testing.assert_array_equal(found[own, own], block)
        found[own, own] = 0
    assert not found.any()


@pytest.mark.parametrize("damping", [0.0, 1e-3, 10.0])
def test_a_step_is_that_of_the_equations_written_out(damping: float) -> None:
    banded, b = random_banded(2 * DOFS), np.random.default_rng(4).normal(0, 1, SIZE)
    expected = -np.linalg.solve(damped(dense(banded), damping), b)
    found = banded_step(banded, b, damping)
    assert found is not None
    np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("damping", [0.0, 1e-3, 10.0])
@pytest.mark.parametrize("shared", [0, 1, 7])
def test_a_step_with_shared_unknowns_is_that_of_the_equations_written_out(
    shared: int, damping: float
) -> None:
    rng = np.random.default_rng(shared)
    banded, border = random_banded(4 * DOFS), rng.normal(0, 1, (SIZE, shared))
    corner = rng.normal(0, 1, (shared, shared))
    corner = corner @ corner.T + 60.0 * np.eye(shared)
    b, c = rng.normal(0, 1, SIZE), rng.normal(0, 1, shared)
    own = damped(dense(banded), damping)
    whole = np.block([[own, border], [border.T, corner + np.diag(np.diag(corner)) * damping]])
    expected = -np.linalg.solve(whole, np.concatenate([b, c]))
    found = bordered_step(banded, border, corner, b, c, damping)
    assert found is not None
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_equations_that_are_not_positive_definite_have_no_step() -> None:
    banded = random_banded(2 * DOFS)
    banded[5, 0] = -8.0
    b, border = np.ones(SIZE), np.ones((SIZE, 2))
    assert banded_step(banded, b, 0.0) is None
    assert bordered_step(banded, border, np.eye(2), b, np.ones(2), 0.0) is None


def test_a_step_leaves_its_equations_as_they_are() -> None:
    banded, border, corner = random_banded(DOFS), np.ones((SIZE, 2)), 9.0 * np.eye(2)
    b, c = np.ones(SIZE), np.ones(2)
    given = [array.copy() for array in (banded, border, corner, b, c)]
    assert bordered_step(banded, border, corner, b, c, 1.0) is not None
    for array, before in zip((banded, border, corner, b, c), given, strict=True):
        np.testing.assert_array_equal(array, before)


@pytest.mark.parametrize("sides", [0, 1, 4])
@pytest.mark.parametrize(("width", "size"), [(1, 4), (3, 1), (6, 2), (6, 12), (9, 30), (3, 0)])
def test_a_banded_system_is_solved_as_by_lapack(width: int, size: int, sides: int) -> None:
    rng = np.random.default_rng(size)
    rows, b = rng.normal(size=(size, width)), rng.normal(size=(size, 1 + sides))
    rows[:, 0] = 2.0 * width
    for k in range(1, width):
        rows[max(size - k, 0) :, k] = 0.0  # outside the matrix
    one, others = b[:, 0].copy(), b[:, 1:].copy()
    assert solve_banded(rows.copy(), one, others)
    x = np.column_stack([one, others])
    np.testing.assert_allclose(dense(rows) @ x, b, atol=1e-12)
    if width <= size:
        np.testing.assert_allclose(x, solveh_banded(rows.T, b, lower=True), atol=1e-12)


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan])
def test_a_banded_system_that_is_not_positive_is_said_to_be_none(value: float) -> None:
    rows = np.array([[1.0, 0.1], [1.0, 0.1], [value, 0.1], [1.0, 0.0]])
    assert not solve_banded(rows, np.ones(4), np.ones((4, 2)))
