"""Left and right: a detector may exchange a body's sides suddenly, a body does not.

Arms and legs are looked at by themselves. In each frame their keypoints are as detected or
exchanged; what they jump from frame to frame is least along one of all these ways, found by dynamic
programming, and the posed keyframes say which side is which there. That way is not always right: of
a walk seen from the side both legs coincide. So it is one candidate beside what was detected, and
the evidence as a whole decides between the two.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import Keypoints

ARMS: Final = ("shoulder", "elbow", "wrist")
LEGS: Final = ("hip", "knee", "ankle")
CHANGE = 0.05
"""Of the body's height: what an exchange costs on the way, so that ties stay as detected."""
KEYED = 3.0
"""How much more a keyframe's distance counts than a jump between frames."""


def exchanged_sides(
    keypoints: Keypoints, used: NDArray[np.int64], keyed: Mapping[int, Array], height_px: float
) -> Keypoints | None:
    """Set left and right right; None where they are as detected in every frame.

    used (K,): keypoints that the body has.  keyed: by row, their pixels (K, 2) on the posed body.
    """
    mirrored, changed = keypoints.exchanged(), False
    uv, visibility, p_hips = (
        keypoints.uv.copy(),
        keypoints.visibility.copy(),
        _copy(keypoints.p_hips),
    )
    names = [keypoints.names[k] for k in used]
    for joints in (ARMS, LEGS):
        at = [k for k, name in enumerate(names) if name.split("_", 1)[-1] in joints]
        if not at:
            continue
        here = used[at]
        both = np.stack([keypoints.uv[:, here], mirrored.uv[:, here]], axis=1) / height_px
        posed = {n: places[at] / height_px for n, places in keyed.items()}
        swapped = _least_jumps(both, posed)
        rows = np.ix_(swapped, here)
        changed |= bool(swapped.any())
        uv[rows], visibility[rows] = mirrored.uv[rows], mirrored.visibility[rows]
        if p_hips is not None and mirrored.p_hips is not None:
            p_hips[rows] = mirrored.p_hips[rows]
    return replace(keypoints, uv=uv, visibility=visibility, p_hips=p_hips) if changed else None


def _least_jumps(both: Array, keyed: Mapping[int, Array]) -> NDArray[np.bool_]:
    """(N,) whether to exchange. both (N, 2, K, 2): as detected, exchanged; keyed: (K, 2) by row."""
    count = len(both)
    cost, came_from = np.zeros(2), np.zeros((count, 2), np.int64)
    for n in range(count):
        if n:
            jump = mean_distance(both[n][:, None], both[n - 1][None])  # [now, before]
            totals = cost[None] + jump + CHANGE * (1 - np.eye(2))
            came_from[n] = totals.argmin(axis=1)
            cost = totals.min(axis=1)
        if n in keyed:
            cost = cost + KEYED * mean_distance(both[n], keyed[n])
    state, swapped = int(cost.argmin()), np.zeros(count, np.bool_)
    for n in range(count - 1, -1, -1):
        swapped[n] = bool(state)
        state = int(came_from[n, state])
    return swapped


def mean_distance(a: Array, b: Array) -> Array:
    """Mean over the points known in both; 0 where there are none."""
    away = np.linalg.norm(a - b, axis=-1)
    is_known = np.isfinite(away)
    return np.asarray(np.where(is_known, away, 0.0).sum(-1) / np.maximum(is_known.sum(-1), 1))


def _copy(values: Array | None) -> Array | None:
    return None if values is None else values.copy()
