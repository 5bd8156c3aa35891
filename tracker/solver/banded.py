"""Equations of a whole segment: every frame's own, and those between neighbouring frames."""

from __future__ import annotations

import numpy as np

from tracker.geometry.rotations import Array
from tracker.kernels.chain import solve_banded


def banded_step(banded: Array, gradient: Array, damping: float) -> Array | None:
    """−A⁻¹ b of a symmetric A in LAPACK's upper banded form (w, N), its diagonal damped by a share.

    None where A is not positive definite. The arguments are not changed.
    """
    damped, step = banded.copy(), -gradient
    damped[-1] = damped[-1] * (1 + damping) + 1e-6
    return step if solve_banded(damped, step) else None


def with_frames(banded: Array, A: Array) -> Array:
    """A banded matrix with the equations A (n, D, D) of every frame by itself put in."""
    n, dofs = A.shape[:2]
    both = banded.copy()
    d, e = np.triu_indices(dofs)
    columns = np.arange(n)[:, None] * dofs + e
    both[len(both) - 1 + d - e, columns] += A[:, d, e]
    return both
