"""Whole-segment refinement: the normal equations of all inner poses at once.

Each pose between two keyframes is compared with the texture that both put on the body (weights
1 − s and s along the segment, Tukey, a gain and a bias for each part).
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.kernels import compiled
from keypose.tracker.kernels.chain import (
    camera_twists,
    normal_equations,
    place_parts,
    sum_subtrees,
)
from keypose.tracker.kernels.noise import BINS, robust_sigma
from keypose.tracker.kernels.robust import TUKEY
from keypose.tracker.kernels.seeing import room, see
from keypose.tracker.kernels.sums import BLOCK, TUKEY_WIDTH, sum_points


@compiled
def see_all(body, lens, visibility, width, height, R, t, seen):
    """seen (n, S) uint8 ← which surface points every pose shows."""
    HR, Ho, uvz, _, depth, owner = room(body, visibility, width, height)[:6]
    for j in range(R.shape[0]):
        place_parts(body, R[j], t[j], HR, Ho)
        see(body, HR, Ho, lens, visibility, width, height, uvz, seen[j], depth, owner)


@compiled
def compare_textures(
    body,
    lens,
    pictures,
    slots,
    R,
    t,
    chosen,
    grey,
    starts,
    seen,
    information,
    sigma,
    A,
    b,
):
    """Fill A (n, D, D) and b (n, D) of the n inner poses R, t.

    slots (n,): where their pictures are.
    chosen, grey, starts: the followed points of both keyframes, stacked on a first axis of 2.
    seen (n, S): points that each present pose shows. sigma (2, n): noise of the residuals to each
    keyframe, updated.
    """
    n, parts, dofs = R.shape[0], body.parents.shape[0], body.dof_part.shape[0]
    HR, Ho = np.empty((parts, 3, 3)), np.empty((parts, 3))
    N, both = np.empty((parts, 7, 7)), np.empty((parts, 7, 7))
    S = np.empty((dofs, 6))
    histogram, rows = np.empty(BINS, np.int32), np.empty((9, BLOCK), np.float32)
    for j in range(n):
        place_parts(body, R[j], t[j], HR, Ho)
        centre = Ho[0].copy()
        both[:] = 0.0
        for end in range(2):
            share = (j + 1) / (n + 1) if end == 1 else 1 - (j + 1) / (n + 1)
            points = sum_points(
                body,
                chosen[end],
                grey[end],
                starts[end],
                HR,
                Ho,
                centre,
                pictures[slots[j]],
                lens,
                seen[j],
                True,
                TUKEY,
                TUKEY_WIDTH * sigma[end, j],
                True,
                N,
                histogram,
                rows,
            )
            sigma[end, j] = robust_sigma(histogram, points)
            both += N * (share * information / sigma[end, j] ** 2)
        for i in range(parts):
            for a in range(3):
                Ho[i, a] -= centre[a]
        camera_twists(body, HR, Ho, S)
        sum_subtrees(body, both)
        normal_equations(body, both, S, A[j], b[j])
