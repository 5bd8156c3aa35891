"""Equations of many frames in banded form: the same as with every entry written out."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.solver.banded import (
    add_coupling_blocks,
    added,
    banded_diagonals,
    banded_step,
    bordered_step,
)

Floats = NDArray[np.float64]

FRAMES, DOFS = 6, 3
SIZE = FRAMES * DOFS


def dense(banded: Floats) -> Floats:
    """The symmetric matrix that LAPACK's upper banded form stands for."""
    width, size = banded.shape
    whole = np.zeros((size, size))
    for off in range(min(width, size)):
        diagonal = banded[width - 1 - off, off:]
        whole += np.diag(diagonal, off)
        if off:
            whole += np.diag(diagonal, -off)
    return whole


def random_banded(width: int, seed: int = 0) -> Floats:
    """Positive definite, with so many diagonals."""
    rng = np.random.default_rng(seed)
    banded = rng.normal(0, 1, (width, SIZE))
    banded[-1] = 4.0 * width
    return banded


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
    kept = before.copy()
    np.testing.assert_allclose(dense(add_coupling_blocks(before, off, blocks)), expected)
    np.testing.assert_array_equal(before, kept)


def test_equations_of_single_frames_are_blocks_on_the_diagonal() -> None:
    A = np.random.default_rng(2).normal(0, 1, (FRAMES, DOFS, DOFS))
    A += np.swapaxes(A, 1, 2)
    found = dense(add_coupling_blocks(np.zeros((DOFS, SIZE)), 0, A))
    for j, block in enumerate(A):
        rows = slice(j * DOFS, (j + 1) * DOFS)
        np.testing.assert_array_equal(found[rows, rows], block)
        found[rows, rows] = 0
    assert not found.any()


@pytest.mark.parametrize(
    "unknown",
    [slice(None), slice(1, -1), slice(1, None), slice(2, 4), slice(3, 4)],
    ids=["all", "inner", "from the second", "two", "one"],
)
def test_diagonals_between_frames_are_those_of_the_unknown_frames(unknown: slice) -> None:
    rng = np.random.default_rng(3)
    diagonals = [rng.normal(0, 1, (FRAMES - off, DOFS)) for off in range(4)]
    whole = np.zeros((SIZE, SIZE))
    for off, rows in enumerate(diagonals):
        for j, row in enumerate(rows):
            one, other = np.arange(DOFS) + j * DOFS, np.arange(DOFS) + (j + off) * DOFS
            whole[one, other] = row
            whole[other, one] = row
    of = np.arange(SIZE).reshape(FRAMES, DOFS)[unknown].ravel()
    found = banded_diagonals(diagonals, unknown)
    assert found.shape == (4 * DOFS, len(of))
    np.testing.assert_array_equal(dense(found), whole[np.ix_(of, of)])


def test_a_sum_has_the_diagonals_of_both_whichever_has_more() -> None:
    wide, narrow = random_banded(3 * DOFS, 1), random_banded(DOFS, 2)
    expected = dense(wide) + dense(narrow)
    np.testing.assert_allclose(dense(added(wide, narrow)), expected)
    np.testing.assert_allclose(dense(added(narrow, wide)), expected)


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
    banded[-1, 5] = -8.0
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
