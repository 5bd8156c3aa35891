"""Keypoints that are elsewhere for a few frames: a limb that a network sees on another thing.

Where a limb is hidden, a network may see it for a while on the other limb or on something behind
the person. That shows in how it gets there: in one step out and in one step back, and hardly moving
before, between and after. A limb is heavy: it needs frames to gain speed, and frames to lose it.

Measured on six clips, two of them filmed, whose joints are known: of 120 such runs of one joint 106
were wrong, by 40 px in the median, and 8 px where the frames around bridge them. The other 14 are
of a clip whose left and right the network exchanges most of the time: what jumps there is right.
"""

from __future__ import annotations

from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array

STEP: Final = 0.06
"""What is a step, as a share of the body's height."""
CALM: Final = 0.5
"""How far, of the smaller step, anything moves in a frame before, between and after. It comes back
to where it was up to one such step: meanwhile the limb has moved on."""
LONGEST: Final = 8
"""Frames that it is elsewhere at most."""


def jumped_away(uv: Array, known: NDArray[np.bool_], height_px: float) -> NDArray[np.bool_]:
    """(N, K) of keypoints in consecutive frames which are for a few of them elsewhere.

    uv (N, K, 2): pixels, those that are not `known` of any value.  height_px: of the body.
    """
    found = np.zeros(known.shape, np.bool_)
    places = np.where(known[..., None], uv, np.nan) / height_px
    moved = np.linalg.norm(np.diff(places, axis=0), axis=-1)
    for k in range(known.shape[1]):
        # at the ends nobody knows what was before, or comes after
        steps = np.flatnonzero(moved[1:-1, k] > STEP) + 1
        for out, back in combinations(steps.tolist(), 2):
            if back - out <= LONGEST and _is_there_and_back(places[:, k], moved[:, k], out, back):
                run = slice(out + 1, back + 1)
                found[run] |= known[run] & _goes_along(moved, out, back)
    return found


def _is_there_and_back(places: Array, moved: Array, out: int, back: int) -> bool:
    """Whether the steps after the frames `out` and `back` are all that one keypoint moves there."""
    step = min(moved[out], moved[back])
    apart = float(np.linalg.norm(places[back + 1] - places[out]))
    return bool(apart < step and _otherwise(moved, out, back) < CALM * step)


def _goes_along(moved: Array, out: int, back: int) -> NDArray[np.bool_]:
    """(K,) which keypoints take one of the steps, or both, such as the knee of that foot."""
    steps = np.sort(moved[[out, back]], axis=0)[::-1]
    calm = _otherwise(moved, out, back) < CALM * steps[0]
    once, twice = steps[1] < CALM * steps[0], steps[1] > STEP
    return np.asarray((steps[0] > STEP) & calm & (once | twice))


def _otherwise(moved: Array, out: int, back: int) -> Array:
    """The farthest that is moved in a frame before, between and after two steps."""
    beside = [moved[out - 1 : out], moved[out + 1 : back], moved[back + 1 : back + 2]]
    return np.asarray(np.max(np.concatenate(beside), axis=0, initial=0.0))
