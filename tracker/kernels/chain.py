"""The articulated chain: forward kinematics, twists, and normal equations over subtrees.

A row of DRIFT's A for a point p of part i is g·J = Σ_d [g, p × g]·S_d over the degrees of freedom
d above i, with S_d the camera-frame twist. So AᵀA needs only the 6×6 sums of each part,
N_i = Σ w [g, p×g]ᵀ[g, p×g]: summed over subtrees, AᵀA[d, e] = S_dᵀ N(deeper of d and e) S_e.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.kernels import compiled
from keypose.tracker.kernels.rigid import compose, product, put, put_place


@compiled
def place_parts(body, R, t, HR, Ho):
    """HR (P, 3, 3), Ho (P, 3): every part in the camera frame, of R (P, 3, 3), t (3).  DRIFT (1)"""
    for i in range(body.parents.shape[0]):
        parent = body.parents[i]
        if parent < 0:
            put(R[i], HR[i])
            put_place(t, Ho[i])
            continue
        product(HR[parent], R[i], HR[i])
        for a in range(3):
            Ho[i, a] = (
                Ho[parent, a]
                + HR[parent, a, 0] * body.joints[i, 0]
                + HR[parent, a, 1] * body.joints[i, 1]
                + HR[parent, a, 2] * body.joints[i, 2]
            )


@compiled
def camera_twists(body, HR, Ho, S):
    """S (D, 6): camera-frame twist [velocity at the camera's origin, turn] of every dof."""
    for d in range(body.dof_part.shape[0]):
        i, axis = body.dof_part[d], body.dof_axis[d]
        x, y, z = HR[i, 0, axis], HR[i, 1, axis], HR[i, 2, axis]
        if body.dof_turns[d] == 1:
            S[d, 0] = Ho[i, 1] * z - Ho[i, 2] * y
            S[d, 1] = Ho[i, 2] * x - Ho[i, 0] * z
            S[d, 2] = Ho[i, 0] * y - Ho[i, 1] * x
            S[d, 3], S[d, 4], S[d, 5] = x, y, z
        else:
            S[d, 0], S[d, 1], S[d, 2] = x, y, z
            S[d, 3] = S[d, 4] = S[d, 5] = 0.0


@compiled
def sum_subtrees(body, N):
    """Add every part's sums N (P, 7, 7) to its parent's, leaves first."""
    for i in range(body.parents.shape[0] - 1, 0, -1):
        parent = body.parents[i]
        for a in range(7):
            for b in range(7):
                N[parent, a, b] += N[i, a, b]


@compiled
def normal_equations(body, N, S, A, b):
    """A (D, D) = AᵀA and b (D,) = Aᵀr from subtree sums N (P, 7, 7), column 6 holding Σ w r row."""
    y = np.empty(6)
    for d in range(body.dof_part.shape[0]):
        i = body.dof_part[d]
        s = 0.0
        for a in range(6):
            s += S[d, a] * N[i, a, 6]
            y[a] = 0.0
            for c in range(6):
                y[a] += N[i, a, c] * S[d, c]
        b[d] = s
        for e in range(d + 1):
            # dofs are sorted parents first, so the deeper of d and e ≤ d is d's own part
            s = 0.0
            if body.deeper[d, e] >= 0:
                for a in range(6):
                    s += y[a] * S[e, a]
            A[d, e] = s
            A[e, d] = s


@compiled
def solve_positive(A, b):
    """b ← A⁻¹ b by Cholesky, A (D, D) overwritten; False where A is not positive definite."""
    n = b.shape[0]
    for j in range(n):
        for k in range(j):
            s = A[j, k]
            for m in range(k):
                s -= A[j, m] * A[k, m]
            A[j, k] = s / A[k, k]
        s = A[j, j]
        for m in range(j):
            s -= A[j, m] * A[j, m]
        if not s > 0.0:
            return False
        A[j, j] = np.sqrt(s)
    for j in range(n):
        s = b[j]
        for k in range(j):
            s -= A[j, k] * b[k]
        b[j] = s / A[j, j]
    for j in range(n - 1, -1, -1):
        s = b[j]
        for k in range(j + 1, n):
            s -= A[k, j] * b[k]
        b[j] = s / A[j, j]
    return True


@compiled
def inverse_diagonal(L, out):
    """out (D,) ← diagonal of (L Lᵀ)⁻¹, L (D, D) being the lower triangle solve_positive left."""
    n = out.shape[0]
    column = np.empty(n)
    out[:] = 0.0
    for d in range(n):
        for j in range(d, n):
            s = 1.0 if j == d else 0.0
            for k in range(d, j):
                s -= L[j, k] * column[k]
            column[j] = s / L[j, j]
            out[d] += column[j] * column[j]


@compiled
def move(body, R, t, motion):
    """R, t ← the pose after `motion` (D,), on the right, in the parts' frames.  DRIFT (2)"""
    parts = R.shape[0]
    turn = np.zeros((parts, 3))
    shift = np.zeros(3)
    scratch = np.empty((2, 3, 3))
    for d in range(motion.shape[0]):
        if body.dof_turns[d] == 1:
            turn[body.dof_part[d], body.dof_axis[d]] = motion[d]
        else:
            shift[body.dof_axis[d]] = motion[d]
    for a in range(3):
        t[a] += R[0, a, 0] * shift[0] + R[0, a, 1] * shift[1] + R[0, a, 2] * shift[2]
    for i in range(parts):
        if turn[i, 0] != 0 or turn[i, 1] != 0 or turn[i, 2] != 0:
            compose(R[i], turn[i], scratch)
