"""Equations of a whole segment: rows of a symmetric banded matrix, see `kernels/steps.py`."""

from __future__ import annotations

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.steps import solve_banded

LEAST = 1e-6
"""Added to the diagonal: for what nothing is compared with."""


def banded_step(rows: Array, gradient: Array, damping: float) -> Array | None:
    """−A⁻¹ b of a symmetric A, its rows (N, w) from the diagonal on, damped by a share.

    None where A is not positive definite. The arguments are not changed.
    """
    step, nothing = -gradient, np.zeros((len(gradient), 0))
    return step if solve_banded(_damped(rows, damping), step, nothing) else None


def bordered_step(
    rows: Array, border: Array, corner: Array, gradient: Array, shared: Array, damping: float
) -> Array | None:
    """The same where S unknowns are shared by all frames: border (N, S), corner (S, S), their
    gradient shared (S,). They are eliminated exactly; alternating with them would creep.

    None where the equations are not positive definite. Returned are (N + S,), the shared ones last.
    """
    alone, led = gradient.copy(), np.array(border, order="C")
    if not solve_banded(_damped(rows, damping), alone, led):
        return None
    own = corner + np.diag(np.diag(corner)) * damping - border.T @ led
    try:
        step = -np.linalg.solve(own, shared - border.T @ alone)
    except np.linalg.LinAlgError:
        return None
    return np.append(-(alone + led @ step), step)


def _damped(rows: Array, damping: float) -> Array:
    damped = rows.copy()
    damped[:, 0] = damped[:, 0] * (1 + damping) + LEAST
    return damped
