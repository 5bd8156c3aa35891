"""Whole-segment refinement: the normal equations of all inner poses at once.

Unknown are the poses of the frames between two keyframes. Each is compared with the texture that
both keyframes put on the body (weights 1 − s and s along the segment, Tukey, a gain and a bias for
each part), and the motion is smooth: its second differences cost. The matrix is banded, three
blocks wide.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.kernels import compiled
from keypose.tracker.kernels.chain import (
    camera_twists,
    move,
    normal_equations,
    place_parts,
    sum_subtrees,
)
from keypose.tracker.kernels.noise import BINS, robust_sigma
from keypose.tracker.kernels.rigid import logarithm, turned_back
from keypose.tracker.kernels.seeing import room, see
from keypose.tracker.kernels.sums import BLOCK, TUKEY, TUKEY_WIDTH, sum_points


@compiled
def see_all(body, lens, visibility, width, height, R, t, seen):
    """seen (n + 1, S) uint8 ← which surface points every pose shows."""
    HR, Ho, uvz, _, depth, owner = room(body, visibility, width, height)[:6]
    for j in range(R.shape[0]):
        place_parts(body, R[j], t[j], HR, Ho)
        see(body, HR, Ho, lens, visibility, width, height, uvz, seen[j], depth, owner)


@compiled
def add_frame(banded, gradient, place, A, b, dofs):
    """Add one frame's A (D, D) and b (D,) at its place in the upper banded form."""
    width = banded.shape[0]
    for d in range(dofs):
        gradient[place * dofs + d] += b[d]
        for e in range(d, dofs):
            banded[width - 1 + d - e, place * dofs + e] += A[d, e]


@compiled
def add_smoothness(body, R, t, precision, banded, gradient):
    """Second differences of the motion between frames: precision (D,) is 1/σ² of each."""
    n, dofs = R.shape[0] - 1, precision.shape[0]
    width = banded.shape[0]
    turn, v = np.empty((3, 3)), np.empty((n, R.shape[1], 3))
    r = np.zeros((n, 3))
    for j in range(n):
        for i in range(R.shape[1]):
            turned_back(R[j, i], R[j + 1, i], turn)
            logarithm(turn, v[j, i])
        for a in range(3):
            for b in range(3):
                r[j, a] += R[j, 0, b, a] * (t[j + 1, b] - t[j, b])
    share = np.array([1.0, -2.0, 1.0])
    for d in range(dofs):
        i, axis = body.dof_part[d], body.dof_axis[d]
        for c in range(1, n):
            if body.dof_turns[d] == 1:
                bend = v[c, i, axis] - v[c - 1, i, axis]
            else:
                bend = r[c, axis] - r[c - 1, axis]
            for first in range(3):
                row = c - 2 + first
                if row < 0 or row > n - 2:
                    continue
                gradient[row * dofs + d] += share[first] * precision[d] * bend
                for second in range(first, 3):
                    column = c - 2 + second
                    if column > n - 2 or column < 0:
                        continue
                    banded[width - 1 + (row - column) * dofs, column * dofs + d] += (
                        share[first] * share[second] * precision[d]
                    )


@compiled
def whole_segment(
    body, lens, pictures, slots, R, t, chosen, grey, starts, seen, information,
    smoothness, sigma, banded, gradient,
):  # fmt: skip
    """Fill banded (3D, (n − 1)D), upper form, and gradient for the inner poses of R, t.

    chosen, grey, starts: the followed points of keyframe 0 and n, stacked on a first axis of 2.
    seen (n + 1, S): points that each present pose shows. sigma (2, n + 1): noise of the residuals
    to each keyframe, updated.
    """
    n, parts, dofs = R.shape[0] - 1, body.parents.shape[0], body.dof_part.shape[0]
    HR, Ho = np.empty((parts, 3, 3)), np.empty((parts, 3))
    N, both = np.empty((parts, 7, 7)), np.empty((parts, 7, 7))
    S, A, b = np.empty((dofs, 6)), np.empty((dofs, dofs)), np.empty(dofs)
    histogram, rows = np.empty(BINS, np.int32), np.empty((9, BLOCK), np.float32)
    banded[:] = 0.0
    gradient[:] = 0.0
    for j in range(1, n):
        place_parts(body, R[j], t[j], HR, Ho)
        centre = Ho[0].copy()
        both[:] = 0.0
        for end in range(2):
            share = j / n if end == 1 else 1 - j / n
            points = sum_points(
                body, chosen[end], grey[end], starts[end], HR, Ho, centre, pictures[slots[j]],
                lens, seen[j], True, TUKEY, TUKEY_WIDTH * sigma[end, j], True, N, histogram, rows,
            )  # fmt: skip
            sigma[end, j] = robust_sigma(histogram, points)
            both += N * (share * information / sigma[end, j] ** 2)
        for i in range(parts):
            Ho[i] -= centre
        camera_twists(body, HR, Ho, S)
        sum_subtrees(body, both)
        normal_equations(body, both, S, A, b)
        add_frame(banded, gradient, j - 1, A, b, dofs)
    add_smoothness(body, R, t, smoothness, banded, gradient)


@compiled
def move_inner(body, R, t, steps):
    """Move every inner pose by its row of steps (n − 1, D)."""
    for j in range(steps.shape[0]):
        move(body, R[j + 1], t[j + 1], steps[j])
