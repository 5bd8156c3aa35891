"""Motions between poses, what links neighbouring ones, and the banded equations of them all.

Equations of N frames with D degrees of freedom, of which each is coupled with the next ones, are
rows (N D, w) of a symmetric matrix from the diagonal on: rows[i, k] is A[i, i + k]. LAPACK takes
four times as long for the same with several right sides: it goes through the factor for each.
"""

from __future__ import annotations

import math

import numpy as np

from keypose.tracker.kernels import compiled
from keypose.tracker.kernels.chain import move
from keypose.tracker.kernels.rigid import logarithm, turned_back
from keypose.tracker.kernels.robust import robust_loss, robust_weight


@compiled
def motions_between(chain, R, t, R_to, t_to, backward, out):
    """out (N, D) ← the tracked part of the motions from poses R, t to others, turns in the parts'
    own frames. backward: the root's shift in its frame there, otherwise in its frame here."""
    turn, vector, shift = np.empty((3, 3)), np.zeros(3), np.empty(3)
    for n in range(out.shape[0]):
        frame = R_to[n, 0] if backward else R[n, 0]
        for a in range(3):
            shift[a] = t_to[n, a] - t[n, a]
        part = -1
        for d in range(out.shape[1]):
            i, axis = chain.dof_part[d], chain.dof_axis[d]
            if chain.dof_turns[d] == 0:
                out[n, d] = 0.0
                for a in range(3):
                    out[n, d] += frame[a, axis] * shift[a]
                continue
            if i != part:
                turned_back(R[n, i], R_to[n, i], turn)
                logarithm(turn, vector)
                part = i
            out[n, d] = vector[axis]


@compiled
def link_cost(differences, wanted, precision, kind, width):
    """The cost of differences (m, D) that should be others, precision (m, D) being 1/σ²."""
    total = 0.0
    for m in range(wanted.shape[0]):
        for d in range(wanted.shape[1]):
            away = abs(differences[m, d] - wanted[m, d])
            total += robust_loss(kind, width, math.sqrt(precision[m, d]) * away)
    return 0.5 * total


@compiled
def add_link(differences, wanted, precision, kind, width, stencil, first, rows, b):
    """rows (u D, w), b (u D,) += the equations of such differences.

    stencil (s,): how often each of s neighbouring frames counts.  first: the frame from which on u
    are unknown.
    """
    count, dofs = wanted.shape
    unknown, reach = b.shape[0] // dofs, stencil.shape[0]
    for m in range(count):
        for d in range(dofs):
            if precision[m, d] == 0:
                continue
            away = differences[m, d] - wanted[m, d]
            size = math.sqrt(precision[m, d]) * abs(away)
            stiff = precision[m, d] * robust_weight(kind, width, size)
            for i in range(reach):
                j = m + i - first
                if j < 0 or j >= unknown:
                    continue
                b[j * dofs + d] += stencil[i] * stiff * away
                for k in range(i, min(reach, unknown - j + i)):
                    rows[j * dofs + d, (k - i) * dofs] += stencil[i] * stencil[k] * stiff


@compiled
def add_blocks(blocks, off, rows):
    """rows += blocks (n, D, D) that couple frame j with frame j + off."""
    n, dofs = blocks.shape[0], blocks.shape[1]
    for j in range(n):
        for d in range(dofs):
            for e in range(0 if off > 0 else d, dofs):
                rows[j * dofs + d, off * dofs + e - d] += blocks[j, d, e]


@compiled
def solve_banded(rows, b, border):
    """b (n,), border (n, m) ← A⁻¹ of them by Cholesky, rows (n, w) of A overwritten; False where A
    is not positive definite."""
    n, width = rows.shape
    sides = border.shape[1]
    for i in range(n):
        if not rows[i, 0] > 0.0:
            return False
        root = 1.0 / np.sqrt(rows[i, 0])
        for k in range(width):
            rows[i, k] *= root
        b[i] *= root
        for c in range(sides):
            border[i, c] *= root
        for k in range(1, min(width, n - i)):
            share = rows[i, k]
            if share != 0.0:
                b[i + k] -= share * b[i]
                for c in range(sides):
                    border[i + k, c] -= share * border[i, c]
                for m in range(width - k):
                    rows[i + k, m] -= share * rows[i, k + m]
    for i in range(n - 1, -1, -1):
        last, s = min(width, n - i), b[i]
        for k in range(1, last):
            s -= rows[i, k] * b[i + k]
        b[i] = s / rows[i, 0]
        if sides > 0:
            for k in range(1, last):
                for c in range(sides):
                    border[i, c] -= rows[i, k] * border[i + k, c]
            for c in range(sides):
                border[i, c] /= rows[i, 0]
    return True


@compiled
def move_poses(chain, R, t, steps):
    """Move every pose by its row of steps (n, D)."""
    for j in range(steps.shape[0]):
        move(chain, R[j], t[j], steps[j])
