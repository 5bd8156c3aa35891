"""Keypoints that are elsewhere for a few frames: a limb that a network sees on another thing.

Where a limb is hidden, a network may see it for a while on the other limb or on something behind
the person. That shows in how it gets there: in one step out and in one step back, and hardly moving
before, between and after. A limb is heavy: it needs frames to gain speed, and frames to lose it.

Where a network mostly exchanges left and right of the arms, or of the legs alone, what jumps may be
what is right: for a few frames the sides are as they are. Its depths show that: the line between
the shoulders lies along that between the hips there, and across it before and after.

Measured on six clips, three of them filmed, whose joints are known: of 108 such runs of one joint
all were wrong, by 40 px in the median, and 9 px where the frames around bridge them. The depths
speak for 14 others, all of them right. Keypoints without depth have these among the wrong ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array

STEP: Final = 0.06
"""What is a step, as a share of the body's height."""
WITHIN: Final = 0.5
"""How far, of the smaller step, anything moves in a frame before, between and after. It comes back
nearer to where it was than it went away: meanwhile the limb has moved on."""
LONGEST: Final = 8
"""Frames that it is elsewhere at most."""
STRAIGHTER: Final = 0.12
"""By how much the cosine between the lines of shoulders and hips is greater in frames whose sides
are right than before and after in the mean: at least 0.17 where that was so, 0.08 elsewhere."""
TRUNK: Final = ("left_shoulder", "right_shoulder", "left_hip", "right_hip")


def jumped_away(
    uv: Array,
    known: NDArray[np.bool_],
    height_px: float,
    names: Sequence[str] = (),
    p_hips: Array | None = None,
) -> NDArray[np.bool_]:
    """(N, K) of keypoints in consecutive frames which are for a few of them elsewhere.

    uv (N, K, 2): pixels, those that are not `known` of any value.  height_px: of the body.
    names, p_hips (N, K, 3): of the keypoints, and where they are in space, NaN where unknown.
    """
    found = np.zeros(known.shape, np.bool_)
    straight = None if p_hips is None else trunk_straightness(names, p_hips)
    trunk = [k for k, name in enumerate(names) if name in TRUNK]
    places = np.where(known[..., None], uv, np.nan) / height_px
    moved = np.linalg.norm(np.diff(places, axis=0), axis=-1)
    for k in range(known.shape[1]):
        # at the ends nobody knows what was before, or comes after
        steps = np.flatnonzero(moved[1:-1, k] > STEP) + 1
        for out, back in combinations(steps.tolist(), 2):
            if back - out <= LONGEST and _is_there_and_back(places[:, k], moved[:, k], out, back):
                along = _goes_along(moved, out, back)
                if along[trunk].any() and _sides_are_right(straight, out, back):
                    continue
                run = slice(out + 1, back + 1)
                found[run] |= known[run] & along
    return found


def trunk_straightness(names: Sequence[str], p_hips: Array) -> Array | None:
    """(N,) the cosine of the angle in space between the lines from the right to the left shoulder
    and hip, below 0 where the sides of one of the two are exchanged; NaN where it is unknown. None
    where the names lack one of the four."""
    if not set(TRUNK) <= set(names):
        return None
    at = [names.index(name) for name in TRUNK]
    shoulders, hips = p_hips[:, at[0]] - p_hips[:, at[1]], p_hips[:, at[2]] - p_hips[:, at[3]]
    lengths = np.linalg.norm(shoulders, axis=1) * np.linalg.norm(hips, axis=1)
    return np.asarray((shoulders * hips).sum(axis=1) / np.maximum(lengths, 1e-9))


def _sides_are_right(straight: Array | None, out: int, back: int) -> bool:
    """Whether the trunk is less twisted between two steps than before and after."""
    if straight is None:
        return False
    beside = (straight[out] + straight[back + 1]) / 2
    return bool(straight[out + 1 : back + 1].mean() > beside + STRAIGHTER)


def _is_there_and_back(places: Array, moved: Array, out: int, back: int) -> bool:
    """Whether the steps after the frames `out` and `back` are all that one keypoint moves there."""
    step, farther = sorted((moved[out], moved[back]))
    apart = float(np.linalg.norm(places[back + 1] - places[out]))
    return bool(apart < farther and _otherwise(moved, out, back) < WITHIN * step)


def _goes_along(moved: Array, out: int, back: int) -> NDArray[np.bool_]:
    """(K,) which keypoints take one of the steps, or both, such as the knee of that foot."""
    steps = np.sort(moved[[out, back]], axis=0)[::-1]
    returns = _otherwise(moved, out, back) < WITHIN * steps[0]
    once, twice = steps[1] < WITHIN * steps[0], steps[1] > STEP
    return np.asarray((steps[0] > STEP) & returns & (once | twice))


def _otherwise(moved: Array, out: int, back: int) -> Array:
    """The farthest that is moved in a frame before, between and after two steps."""
    beside = [moved[out - 1 : out], moved[out + 1 : back], moved[back + 1 : back + 2]]
    return np.asarray(np.max(np.concatenate(beside), axis=0, initial=0.0))
