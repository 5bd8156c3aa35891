"""Keypoints that are elsewhere for a few frames: a limb that a network sees on another thing.

It gets there in one step out and one step back, and hardly moves before, between and after. A limb
is heavy: it needs frames to gain speed, and frames to lose it.

Where a network mostly exchanges left and right of the arms, or of the legs alone, what jumps may be
what is right: for a few frames the sides are as they are. Its depths show that: the line between
the shoulders lies along that between the hips there, and across it before and after.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
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
are right than before and after in the mean: by 0.17 or more where that was so, by 0.08 at most
elsewhere."""
TRUNK: Final = ("left_shoulder", "right_shoulder", "left_hip", "right_hip")


def excursions(
    uv: Array,
    is_known: NDArray[np.bool_],
    height_px: float,
    names: Sequence[str] = (),
    p_hips: Array | None = None,
) -> NDArray[np.bool_]:
    """(N, K) which keypoints of consecutive frames are elsewhere for a few of these.

    uv (N, K, 2): pixels, those that are not `is_known` of any value.  height_px: of the body.
    names, p_hips (N, K, 3): of the keypoints, and where they are in space, NaN where unknown.
    """
    is_outlier = np.zeros(is_known.shape, np.bool_)
    straight = None if p_hips is None else trunk_straightness(names, p_hips)
    trunk = [k for k, name in enumerate(names) if name in TRUNK]
    places = np.where(is_known[..., None], uv, np.nan) / height_px
    for k in range(is_known.shape[1]):
        for excursion in _excursions(places[:, k]):
            if not _is_there_and_back(places[:, k : k + 1], excursion):
                continue
            run, along = slice(excursion.first, excursion.after), _goes_along(places, excursion)
            if along[trunk].any() and _sides_are_right(straight, excursion):
                continue
            is_outlier[run] |= is_known[run] & along
    return is_outlier


@dataclass(frozen=True)
class _Excursion:
    """Two steps: out from the frame `before` to the next one, and back to the frame `after`."""

    before: int
    after: int

    @property
    def first(self) -> int:
        return self.before + 1

    @property
    def last(self) -> int:
        return self.after - 1


def _excursions(places: Array) -> Iterator[_Excursion]:
    """Where one keypoint (N, 2) may be elsewhere: between two steps."""
    moved = np.linalg.norm(np.diff(places, axis=0), axis=-1)
    # at the ends nobody knows what was before, or comes after
    steps = np.flatnonzero(moved[1:-1] > STEP) + 1
    for out, back in combinations(steps.tolist(), 2):
        if back - out <= LONGEST:
            yield _Excursion(out, back + 1)


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


def _sides_are_right(straight: Array | None, excursion: _Excursion) -> bool:
    """Whether the trunk is less twisted meanwhile than before and after."""
    if straight is None:
        return False
    beside = (straight[excursion.before] + straight[excursion.after]) / 2
    return bool(straight[excursion.before + 1 : excursion.after].mean() > beside + STRAIGHTER)


def _is_there_and_back(places: Array, excursion: _Excursion) -> bool:
    """Whether both steps are all that one keypoint (N, 1, 2) moves there."""
    step, farther = np.sort(_steps(places, excursion)[:, 0])
    apart = float(np.linalg.norm(places[excursion.after] - places[excursion.before]))
    return bool(apart < farther and _other_motion(places, excursion)[0] < WITHIN * step)


def _goes_along(places: Array, excursion: _Excursion) -> NDArray[np.bool_]:
    """(K,) which keypoints take one of the steps, or both, such as the knee of that foot."""
    steps = np.sort(_steps(places, excursion), axis=0)[::-1]
    returns = _other_motion(places, excursion) < WITHIN * steps[0]
    once, twice = steps[1] < WITHIN * steps[0], steps[1] > STEP
    return np.asarray((steps[0] > STEP) & returns & (once | twice))


def _steps(places: Array, excursion: _Excursion) -> Array:
    """(2, K) how far keypoints go away, and come back."""
    out = places[excursion.first] - places[excursion.before]
    back = places[excursion.after] - places[excursion.last]
    return np.asarray(np.linalg.norm(np.stack([out, back]), axis=-1))


def _other_motion(places: Array, excursion: _Excursion) -> Array:
    """(K,) the farthest that a keypoint moves in a frame besides the two steps: in the one before
    them, in those between, and in the one after."""
    rows = (
        slice(excursion.before - 1, excursion.before + 1),
        slice(excursion.first, excursion.last + 1),
        slice(excursion.after, excursion.after + 2),
    )
    moved = [np.linalg.norm(np.diff(places[row], axis=0), axis=-1) for row in rows]
    return np.asarray(np.max(np.concatenate(moved), axis=0, initial=0.0))
