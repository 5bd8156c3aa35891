"""Drift correction of one segment: the motions made to meet the second keyframe (DRIFT §3).

One small rotation X is found for each part with R_1 X R_2 X … R_n X = T_0⁻¹ T_n. In the tangent
space the paper's nine equations are three: (Σ_j G_jᵀ) ξ = log(F_nᵀ T), G_j = R_{j+1} … R_n. The
printed I + Y is not a rotation and cannot meet T to 1e-10; X = exp(ξ) does in a few rounds.

The paper gives every step the same X. Drift gathers where the picture shows least, so a step may
take a larger or smaller share of it: R_j X^w_j, with w_j of mean 1.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.kernels import compiled
from keypose.tracker.kernels.rigid import (
    cleaned,
    compose,
    exponential,
    logarithm,
    product,
    put,
    put_place,
    turned_back,
)

MOST_ROUNDS = 20
MET = 1e-11
"""Radians within which the end counts as met."""


@compiled
def solve_three(J, b, least, x):
    """x ← J⁻¹ b for a 3×3 J by its cofactors; False where |det J| is below `least`."""
    cofactors = np.empty((3, 3))
    for i in range(3):
        for k in range(3):
            i1, i2, k1, k2 = (i + 1) % 3, (i + 2) % 3, (k + 1) % 3, (k + 2) % 3
            cofactors[i, k] = J[i1, k1] * J[i2, k2] - J[i1, k2] * J[i2, k1]
    det = J[0, 0] * cofactors[0, 0] + J[0, 1] * cofactors[0, 1] + J[0, 2] * cofactors[0, 2]
    if not abs(det) >= least:
        return False
    for k in range(3):
        x[k] = 0.0
        for i in range(3):
            x[k] += cofactors[i, k] * b[i] / det
    return True


@compiled
def find_correction(M, T, shares):
    """Multiply the motions M (n, 3, 3) by powers of one X until their product is T (3, 3).

    Motion j takes X to the power shares[j] (n,), whose mean is 1.

    Rounds needed, or −1 where the system is singular (the motions make a full turn in between) or
    the rounds run out; the caller then closes the gap in another way.
    """
    n = M.shape[0]
    tail, J, gap = np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    step, scratch, xi = np.empty((3, 3)), np.empty((2, 3, 3)), np.empty(3)
    for rounds in range(MOST_ROUNDS):
        tail[:] = 0.0
        for a in range(3):
            tail[a, a] = 1.0
        J[:] = 0.0
        for j in range(n - 1, -1, -1):
            for a in range(3):
                for b in range(3):
                    J[a, b] += shares[j] * tail[b, a]
            product(M[j], tail, step)
            put(step, tail)
        turned_back(tail, T, step)
        logarithm(step, gap)
        if max(abs(gap[0]), abs(gap[1]), abs(gap[2])) < MET:
            return rounds
        if not solve_three(J, gap, 1e-3 * n**3, xi):
            return -1
        for j in range(n):
            compose(M[j], xi * shares[j], scratch)
    return -1


@compiled
def spread_gap(R, R_end, shares):
    """Close R (n + 1, 3, 3) on R_end: each frame is turned by its part of what is missing."""
    n = R.shape[0] - 1
    gap, step, scratch = np.empty(3), np.empty((3, 3)), np.empty((2, 3, 3))
    turned_back(R[n], R_end, step)
    logarithm(step, gap)
    done = 0.0
    for j in range(1, n + 1):
        done += shares[j - 1] / n
        compose(R[j], gap * done, scratch)


@compiled
def root_path(R, t, R_next, t_next, t_end, shares, path):
    """path (n + 1, 3) ← accumulated root positions, then shifted by a part of what is missing.

    The part is (k/n) as printed where all shares (n,) are 1.

    Accumulated with the uncorrected rotations, as printed: t_0 + T_0 r_1 + T_0 R_1 r_2 + … (24).
    """
    n = R_next.shape[0]
    turned, step, r = R[0, 0].copy(), np.empty((3, 3)), np.empty(3)
    put_place(t[0], path[0])
    motion = np.empty((3, 3))
    for j in range(n):
        for a in range(3):
            r[a] = 0.0
            for b in range(3):
                r[a] += R[j, 0, b, a] * (t_next[j, b] - t[j, b])
        for a in range(3):
            path[j + 1, a] = (
                path[j, a] + turned[a, 0] * r[0] + turned[a, 1] * r[1] + turned[a, 2] * r[2]
            )
        turned_back(R[j, 0], R_next[j, 0], motion)
        product(turned, motion, step)
        put(step, turned)
        cleaned(turned)
    missing = t_end - path[n]
    done = 0.0
    for j in range(1, n):
        done += shares[j - 1] / n
        for a in range(3):
            path[j, a] += missing[a] * done
    put_place(t_end, path[n])


@compiled
def close_segment(R, t, R_next, t_next, turned, shifted, R_end, t_end, R_out, t_out, rounds, gaps):
    """Accumulate a pass's motions from the first keyframe and correct their drift.

    turned (n, P), shifted (n,): shares of the correction that every step takes, of mean 1.

    R, t: trajectory the motions start from; R_next, t_next (n, …): where each leads. R_out, t_out
    (n + 1, …) ← the corrected trajectory, its ends exactly the keyframes; rounds (P,) ← rounds per
    part, −1 where the gap was spread along its own axis instead; gaps (P,) ← radians that were
    still missing at the end before it was set.
    """
    n = R_next.shape[0]
    root_path(R, t, R_next, t_next, t_end, shifted, t_out)
    M, T, missing = np.empty((n, 3, 3)), np.empty((3, 3)), np.empty(3)
    for i in range(R.shape[1]):
        for j in range(n):
            turned_back(R[j, i], R_next[j, i], M[j])
        turned_back(R[0, i], R_end[i], T)
        whole = M.copy()
        rounds[i] = find_correction(M, T, turned[:, i])
        if rounds[i] < 0:
            for j in range(n):
                put(whole[j], M[j])
        put(R[0, i], R_out[0, i])
        for j in range(n):
            product(R_out[j, i], M[j], R_out[j + 1, i])
            cleaned(R_out[j + 1, i])
        if rounds[i] < 0:
            spread_gap(R_out[:, i], R_end[i], turned[:, i])
        turned_back(R_out[n, i], R_end[i], T)
        logarithm(T, missing)
        gaps[i] = np.sqrt(missing[0] ** 2 + missing[1] ** 2 + missing[2] ** 2)
        put(R_end[i], R_out[n, i])


@compiled
def blend(R_forward, t_forward, R_backward, t_backward, turned, shifted, R, t):
    """R, t ← from the forward chain to the backward one, each part along one axis.

    All in the order of the frames, (n + 1, P, 3, 3) and (n + 1, 3). turned (n + 1, P) and
    shifted (n + 1,): share of the way to the backward chain, of every part and of the root's place.
    """
    turn, gap, step = np.empty((3, 3)), np.empty(3), np.empty((3, 3))
    for j in range(R.shape[0]):
        for i in range(R.shape[1]):
            turned_back(R_forward[j, i], R_backward[j, i], turn)
            logarithm(turn, gap)
            exponential(gap * turned[j, i], step)
            product(R_forward[j, i], step, R[j, i])
            cleaned(R[j, i])
        put_place((1 - shifted[j]) * t_forward[j] + shifted[j] * t_backward[j], t[j])
