"""Left and right over a whole stretch, without a keyframe that says which is which.

Arms and legs stand in each frame in one of three ways: as detected; exchanged; or with their outer
joints exchanged in the picture alone. That last a network does where one leg passes before the
other: hips, depths and visibility stay with their side, knees and feet are seen on the other one's.
What joints jump from frame to frame, in the picture and in depth, is least along one way through
these states, found by dynamic programming. The left shoulder and the left hip are on one side of a
body, and most of what is detected is right. Where both legs coincide the way may still be wrong: so
it stands beside what was detected, and all terms of the poses decide between the two.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any, Final, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.fitting.draft.limbs import LIMBS, POINTS, SIDES, place_of
from keypose.tracker.fitting.draft.observed import Observed
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.jumps import trunk_straightness
from keypose.tracker.keypoints.keypoints import JOINTS

CHANGE: Final = 0.05
"""What an exchange costs on the way, as a share of the body's height."""
AGAINST: Final = np.array([0.0, 0.01, 0.02])
"""What a frame costs in each way: outer joints alone are never exchanged for long."""
CROSSED: Final = 0.1
"""What a frame costs whose hips are turned against its shoulders."""
_ARMS, _LEGS = ([place_of(side, joint) for joint in limb for side in SIDES] for limb in LIMBS)
_LEGS += [POINTS.index(f"{side}_{end}") for end in ("heel", "foot_index") for side in SIDES]
"""From the trunk outward, left and right beside each other."""

Way: TypeAlias = Literal[0, 1, 2]
"""As detected, exchanged, or the outer joints exchanged in the picture alone."""
WAYS: Final[tuple[Way, ...]] = get_args(Way)
EXCHANGED, OUTER = WAYS[1:]
_STATES = np.array(list(product(WAYS, repeat=2)))
"""(9, 2) the ways of arms and legs."""


def consistent_sides(seen: Observed, height_px: float, height_m: float) -> Observed | None:
    """With arms and legs exchanged where they jump from side to side; None where they do not.

    height_px, height_m: of the body.
    """
    where = np.concatenate([seen.uv / height_px, seen.p_hips[..., 2:] / height_m], axis=-1)
    where[~seen.known] = np.nan
    own = AGAINST[_STATES].sum(axis=1) + _crossed(seen)
    steps = np.zeros((len(seen) - 1, len(_STATES), len(_STATES)))
    for k, group in enumerate((_ARMS, _LEGS)):
        before, now = _STATES[:, None, k], _STATES[None, :, k]
        steps += CHANGE * (before != now) + _group_jumps(where, group)[:, before, now]
    states = _STATES[_least_way(own, steps)]
    return _exchanged(seen, states) if states.any() else None


def _crossed(seen: Observed) -> Array:
    """(N, 9) by frame and state."""
    straight = trunk_straightness(JOINTS, seen.p_hips[:, : len(JOINTS)])
    assert straight is not None
    cosine = np.nan_to_num(straight)
    turned = _STATES == EXCHANGED
    sign = np.where(turned[:, 0] == turned[:, 1], 1.0, -1.0)
    return np.asarray(CROSSED * np.maximum(-cosine[:, None] * sign, 0.0))


def _group_jumps(where: Array, group: list[int]) -> Array:
    """(N − 1, 3 before, 3) mean distance from a group's joints to those of the frame before, each
    in one of the ways; 0 where nothing is known in both."""
    ways = np.stack([_in_way(where[:, group], way) for way in WAYS])
    return np.stack(
        [
            np.stack([_mean_distance(now[1:], before[:-1]) for now in ways], axis=-1)
            for before in ways
        ],
        axis=1,
    )


def _in_way(where: Array, way: Way) -> Array:
    """Joints (N, J, 3), pixels and depth, of one group in one of the ways."""
    if way == EXCHANGED:
        return _other(where)
    if way != OUTER:
        return where
    out = where.copy()
    out[:, len(SIDES) :, :2] = _other(where)[:, len(SIDES) :, :2]
    return out


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


def _exchanged(seen: Observed, states: NDArray[np.int64]) -> Observed:
    """With arms and legs in the ways that states (N, 2) say."""
    places = np.tile(np.arange(len(POINTS)), (len(seen), 1))
    labels = places.copy()
    for group, ways in zip((_ARMS, _LEGS), states.T, strict=True):
        for order, joints, rows in (
            (places, group, ways == EXCHANGED),
            (labels, group, ways == EXCHANGED),
            (places, group[len(SIDES) :], ways == OUTER),
        ):
            here = np.ix_(rows, joints)
            order[here] = _other(order[here])
    every = np.arange(len(seen))[:, None]
    known = seen.known[every, places] & seen.known[every, labels]
    return replace(
        seen, uv=seen.uv[every, places], known=known,
        visibility=np.where(known, seen.visibility[every, labels], 0.0),
        p_hips=seen.p_hips[every, labels],
    )  # fmt: skip
