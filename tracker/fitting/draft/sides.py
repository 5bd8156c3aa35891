"""Left and right over a whole stretch, without a keyframe that says which is which.

Arms and legs stand in each frame as told or exchanged: four states. What their joints jump from
frame to frame, in the picture and in depth, is least along one way through the states, found by
dynamic programming. The left shoulder and the left hip are on one side of a body, and most of what
is told is right. Where both legs coincide the way may still be wrong: so it stands beside what was
told, and all terms of the poses decide between the two.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.fitting.draft.limbs import LIMBS, POINTS, SIDES, place_of
from keypose.tracker.fitting.draft.observed import Observed
from keypose.tracker.geometry.rotations import Array

CHANGE: Final = 0.05
"""What an exchange costs on the way, as a share of the body's height."""
AGAINST: Final = 0.01
"""What a frame costs that is exchanged."""
CROSSED: Final = 0.1
"""What a frame costs whose hips are turned against its shoulders."""
_ARMS, _LEGS = ([place_of(side, joint) for joint in limb for side in SIDES] for limb in LIMBS)
_LEGS += [POINTS.index(f"{side}_{end}") for end in ("heel", "foot_index") for side in SIDES]
_STATES = np.array(list(product((False, True), repeat=2)))
"""(4, 2) whether arms and legs are exchanged."""


def consistent_sides(seen: Observed, height_px: float, height_m: float) -> Observed | None:
    """With arms and legs exchanged where they jump from side to side; None where they do not.

    height_px, height_m: of the body.
    """
    where = np.concatenate([seen.uv / height_px, seen.p_hips[..., 2:] / height_m], axis=-1)
    where[~seen.known] = np.nan
    own = AGAINST * _STATES.sum(1) + _crossed(seen)
    changes = (_STATES[:, None] != _STATES[None]).astype(np.int64)  # (4 before, 4, 2)
    steps = CHANGE * changes.sum(-1) + np.zeros((len(seen) - 1, 1, 1))
    for k, group in enumerate((_ARMS, _LEGS)):
        steps += _group_jumps(where, group)[:, changes[..., k]]
    states = _STATES[_least_way(own, steps)]
    return _exchanged(seen, states) if states.any() else None


def _crossed(seen: Observed) -> Array:
    """(N, 4) by frame and state."""
    p = seen.p_hips
    across = [
        p[:, place_of("left", joint)] - p[:, place_of("right", joint)]
        for joint in ("shoulder", "hip")
    ]
    lengths = [np.linalg.norm(v, axis=1) for v in across]
    cosine = np.nan_to_num(
        (across[0] * across[1]).sum(1) / np.maximum(lengths[0] * lengths[1], 1e-9)
    )
    sign = np.where(_STATES[:, 0] == _STATES[:, 1], 1.0, -1.0)
    return np.asarray(CROSSED * np.maximum(-cosine[:, None] * sign, 0.0))


def _group_jumps(where: Array, group: list[int]) -> Array:
    """(N − 1, 2) mean distance from each frame's joints to those of the frame before, as they are
    and with left and right of one of both exchanged; 0 where nothing is known in both."""
    here, before = where[1:, group], where[:-1, group]
    return np.stack([_mean_distance(here, before), _mean_distance(here, _other(before))], axis=1)


def _mean_distance(a: Array, b: Array) -> Array:
    away = np.linalg.norm(a - b, axis=-1)
    known = np.isfinite(away)
    return np.asarray(np.where(known, away, 0.0).sum(-1) / np.maximum(known.sum(-1), 1))


def _other(values: NDArray[Any]) -> NDArray[Any]:
    """Left and right, which lie beside each other, exchanged."""
    pairs = values.reshape(len(values), values.shape[1] // 2, 2, *values.shape[2:])
    return np.asarray(pairs[:, :, ::-1].reshape(values.shape))


def _least_way(own: Array, steps: Array) -> NDArray[np.int64]:
    """(N,) the states whose sum of own costs (N, S) and of steps (N − 1, S before, S) is least."""
    cost, came_from = own[0], np.zeros(own.shape, np.int64)
    for n in range(1, len(own)):
        way = cost[:, None] + steps[n - 1]
        came_from[n] = way.argmin(axis=0)
        cost = way.min(axis=0) + own[n]
    states = np.zeros(len(own), np.int64)
    states[-1] = int(cost.argmin())
    for n in range(len(own) - 1, 0, -1):
        states[n - 1] = came_from[n, states[n]]
    return states


def _exchanged(seen: Observed, states: NDArray[np.bool_]) -> Observed:
    """With arms and legs exchanged in the frames where states (N, 2) say so."""
    order = np.tile(np.arange(len(POINTS)), (len(seen), 1))
    for group, rows in zip((_ARMS, _LEGS), states.T, strict=True):
        here = np.ix_(rows, group)
        order[here] = _other(order[here])
    every = np.arange(len(seen))[:, None]
    return replace(
        seen, uv=seen.uv[every, order], known=seen.known[every, order],
        visibility=seen.visibility[every, order], p_hips=seen.p_hips[every, order],
    )  # fmt: skip
