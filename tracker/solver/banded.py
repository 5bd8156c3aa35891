"""Equations of a whole segment: every frame's own, and those between neighbouring frames."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.chain import solve_banded


def banded_step(banded: Array, gradient: Array, damping: float) -> Array | None:
    """−A⁻¹ b of a symmetric A in LAPACK's upper banded form (w, N), its diagonal damped by a share.

    None where A is not positive definite. The arguments are not changed.
    """
    damped, step = banded.copy(), -gradient
    damped[-1] = damped[-1] * (1 + damping) + 1e-6
    return step if solve_banded(damped, step) else None


def bordered_step(
    banded: Array, border: Array, corner: Array, gradient: Array, shared: Array, damping: float
) -> Array | None:
    """The same where S unknowns are shared by all frames: border (N, S), corner (S, S), their
    gradient shared (S,). They are eliminated exactly; alternating with them would creep.

    None where the equations are not positive definite. Returned are (N + S,), the shared ones last.
    """
    damped = banded.copy()
    damped[-1] = damped[-1] * (1 + damping) + 1e-6
    try:
        factor = cholesky_banded(damped, check_finite=False)
        solved = cho_solve_banded((factor, False), np.column_stack([gradient, border]))
        own = corner + np.diag(np.diag(corner)) * damping - border.T @ solved[:, 1:]
        step = -np.linalg.solve(own, shared - border.T @ solved[:, 0])
    except (np.linalg.LinAlgError, ValueError):
        return None
    return np.append(-(solved[:, 0] + solved[:, 1:] @ step), step)


def banded_diagonals(diagonals: Sequence[Array], unknown: slice) -> Array:
    """Upper banded (kD, uD) of the u unknown frames among n: diagonals[o] (n − o, D) couple each
    degree of freedom of frame j with its own of frame j + o."""
    count, dofs = diagonals[0].shape
    start, stop, _ = unknown.indices(count)
    banded = np.zeros((len(diagonals) * dofs, (stop - start) * dofs))
    for off, diagonal in enumerate(diagonals[: stop - start]):
        banded[-1 - off * dofs, off * dofs :] = diagonal[start : stop - off].ravel()
    return banded


def add_coupling_blocks(banded: Array, off: int, blocks: Array) -> Array:
    """A banded matrix with blocks (n, D, D) put in that couple frame j with frame j + off."""
    n, dofs = blocks.shape[:2]
    both = banded.copy()
    d, e = np.indices((dofs, dofs)).reshape(2, -1)
    upper = off * dofs + e >= d
    d, e = d[upper], e[upper]
    columns = (np.arange(n)[:, None] + off) * dofs + e
    both[len(both) - 1 - (off * dofs + e - d), columns] += blocks[:, d, e]
    return both


def added(one: Array, other: Array) -> Array:
    """The sum of two banded matrices, one perhaps with fewer diagonals."""
    wide, narrow = (one, other) if len(one) >= len(other) else (other, one)
    both = wide.copy()
    both[len(wide) - len(narrow) :] += narrow
    return both
