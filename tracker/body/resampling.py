"""A motion at other times than those of its frames.

Between two frames it follows the cubic through them and one neighbour on each side, by the times
they are shown at: of positions, and of rotations as rotation vectors from the earlier of the two.
It meets every frame exactly, and a steady motion stays steady. Where a part turns so far from frame
to frame that neighbours determine nothing, it turns evenly about one axis.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation, transpose

FARTHEST_RAD = 3.0
"""Where neighbours turn by more than this, frame by frame, together, cubics do not resolve them:
half a turn has no direction."""


def resampled(
    Rs: Array, ps: Array, times_s: Array, wanted_s: Array
) -> tuple[Array, Array]:  # fmt: skip
    """Rotations (M, ..., 3, 3) and positions (M, 3) at `wanted_s` (M,), within the N times.

    Rs (N, ..., 3, 3), ps (N, 3), times_s (N,) ascending; N is at least two.
    """
    before = np.clip(np.searchsorted(times_s, wanted_s, side="right") - 1, 0, len(times_s) - 2)
    near = _neighbours(before, len(times_s))
    cubic = _weights(times_s[near], wanted_s)
    positions = np.einsum("mk,mk...->m...", cubic, ps[near])
    start = Rs[before]
    turns = log_rotation(transpose(start)[:, None] @ Rs[near])
    steps = np.linalg.norm(log_rotation(transpose(Rs[:-1]) @ Rs[1:]), axis=-1)
    far = steps[near[:, :-1]].sum(axis=1) > FARTHEST_RAD
    pair = np.stack([before, before + 1], axis=1)
    linear = _weights(times_s[pair], wanted_s)[:, 1]
    straight = log_rotation(transpose(start) @ Rs[before + 1])
    share = linear.reshape(-1, *(1,) * (straight.ndim - 1))
    curved = np.einsum("mk,mk...->m...", cubic, turns)
    return start @ exp_rotation(np.where(far[..., None], share * straight, curved)), positions


def _neighbours(before: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """(M, 4) the frames that a cubic goes through, or as many as there are."""
    width = min(4, count)
    first = np.clip(before - 1, 0, count - width)
    return np.asarray(first[:, None] + np.arange(width))


def _weights(times_s: Array, wanted_s: Array) -> Array:
    """(M, K) Lagrange's weights of K times (M, K)."""
    width = times_s.shape[1]
    weights = np.ones_like(times_s)
    for k in range(width):
        for i in range(width):
            if i != k:
                weights[:, k] *= (wanted_s - times_s[:, i]) / (times_s[:, k] - times_s[:, i])
    return weights
