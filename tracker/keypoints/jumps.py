"""Keypoints that are elsewhere for a few frames: a limb that a network sees on another thing.

Where a limb is hidden, a network may see it for a while on the other limb or on something behind
the person. That shows in how it gets there: in one step out and in one step back, and hardly moving
before, between and after. A limb is heavy: it needs frames to gain speed, and frames to lose it.
A step may take two frames, where the other side's keypoint does not move as well: the network is
in doubt in between.

Where a network mostly exchanges left and right of the arms, or of the legs alone, what jumps may be
what is right: for a few frames the sides are as they are. Its depths show that: the line between
the shoulders lies along that between the hips there, and across it before and after.

Measured on six clips, three of them filmed, whose joints are known: of 108 such runs of one joint
all were wrong, by 40 px in the median, and 9 px where the frames around bridge them. The depths
speak for 14 others, all of them right. Keypoints without depth have these among the wrong ones.
Steps of two frames are rare: a filmed foot, with its heel and toes, 100 px off for four frames,
and 4 px where the frames around bridge it. Where the other side moves as well half are right.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import other_side

STEP: Final = 0.06
"""What is a step, as a share of the body's height."""
WITHIN: Final = 0.5
"""How far, of the smaller step, anything moves in a frame before, between and after. It comes back
nearer to where it was than it went away: meanwhile the limb has moved on."""
SHARED, SLOW_FRAMES = 0.25, 3
"""What each of two frames has of a step that is made in both, at least, and the frames that a
keypoint is then elsewhere. It then comes back to nearer than either step is long."""
STILL: Final = 0.2
"""The same as `WITHIN` where both steps are made in two frames, and there must be a frame between:
what goes away and turns round at once is a fast limb."""
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
    other = _other_sides(names, known.shape[1])
    places = np.where(known[..., None], uv, np.nan) / height_px
    for k in range(known.shape[1]):
        for away in _excursions(places[:, k]):
            if not _is_there_and_back(places[:, k : k + 1], away):
                continue
            run, along = slice(away.before + 1, away.after), _goes_along(places, away)
            if along[trunk].any() and _sides_are_right(straight, away):
                continue
            if away.is_slow and (found[run, k].any() or _moves_either_way(places, away, other[k])):
                continue
            found[run] |= known[run] & along
    return found


@dataclass(frozen=True)
class _Excursion:
    """From the frame `before` to `first`, to `last`, and back to `after`."""

    before: int
    first: int
    last: int
    after: int

    @property
    def is_slow(self) -> bool:
        """Whether a step is made in two frames."""
        return self.first - self.before > 1 or self.after - self.last > 1

    @property
    def within(self) -> float:
        """How far, of the smaller step, anything moves beside the two."""
        if self.first - self.before == 1 or self.after - self.last == 1:
            return WITHIN
        return STILL if self.last > self.first else 0.0

    @property
    def frames(self) -> int:
        return self.after - self.before - 1


def _excursions(places: Array) -> Iterator[_Excursion]:
    """Where one keypoint (N, 2) may be elsewhere: between two steps; first those of which both are
    made in a single frame."""
    moved = np.linalg.norm(np.diff(places, axis=0), axis=-1)
    twice = np.linalg.norm(places[2:] - places[:-2], axis=-1)
    shared = np.minimum(moved[1:], moved[:-1]) > SHARED * twice
    # at the ends nobody knows what was before, or comes after
    at_once = np.flatnonzero(moved[1:-1] > STEP) + 1
    in_two = np.flatnonzero((twice > STEP)[1:-1] & shared[1:-1]) + 1
    single = [(n, n + 1) for n in at_once.tolist()]
    double = [(n, n + 2) for n in in_two.tolist()]
    pairs = ((single, single), (single, double), (double, single), (double, double))
    for outs, backs in pairs:
        for out, back in product(outs, backs):
            away = _Excursion(*out, *back)
            least = SLOW_FRAMES if away.is_slow else 1
            if away.first <= away.last and least <= away.frames <= LONGEST:
                yield away


def _other_sides(names: Sequence[str], count: int) -> list[int | None]:
    """For each keypoint the same on the other side of the body."""
    at = {name: k for k, name in enumerate(names)}
    others = [other_side(name, names) for name in names]
    found = [None if a == b else at[b] for a, b in zip(names, others, strict=True)]
    return found if names else [None] * count


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


def _sides_are_right(straight: Array | None, away: _Excursion) -> bool:
    """Whether the trunk is less twisted meanwhile than before and after."""
    if straight is None:
        return False
    beside = (straight[away.before] + straight[away.after]) / 2
    return bool(straight[away.before + 1 : away.after].mean() > beside + STRAIGHTER)


def _is_there_and_back(places: Array, away: _Excursion) -> bool:
    """Whether both steps are all that one keypoint (N, 1, 2) moves there."""
    step, farther = np.sort(_steps(places, away)[:, 0])
    apart = float(np.linalg.norm(places[away.after] - places[away.before]))
    is_back = apart < (step if away.is_slow else farther)
    return bool(is_back and _otherwise(places, away)[0] < away.within * step)


def _goes_along(places: Array, away: _Excursion) -> NDArray[np.bool_]:
    """(K,) which keypoints take one of the steps, or both, such as the knee of that foot."""
    steps = np.sort(_steps(places, away), axis=0)[::-1]
    returns = _otherwise(places, away) < WITHIN * steps[0]
    once, twice = steps[1] < WITHIN * steps[0], steps[1] > STEP
    return np.asarray((steps[0] > STEP) & returns & (once | twice))


def _moves_either_way(places: Array, away: _Excursion, k: int | None) -> bool:
    """Whether a keypoint (of N, K, 2) takes one of the steps as well: left and right are exchanged
    then, and either may be what is right."""
    return k is not None and bool(_steps(places, away)[:, k].max() > STEP)


def _steps(places: Array, away: _Excursion) -> Array:
    """(2, K) how far keypoints go away, and come back."""
    ways = np.stack(
        [places[away.first] - places[away.before], places[away.after] - places[away.last]]
    )
    return np.asarray(np.linalg.norm(ways, axis=-1))


def _otherwise(places: Array, away: _Excursion) -> Array:
    """(K,) the farthest that is moved in a frame before, between and after two steps."""
    rows = (
        slice(away.before - 1, away.before + 1),
        slice(away.first, away.last + 1),
        slice(away.after, away.after + 2),
    )
    moved = [np.linalg.norm(np.diff(places[row], axis=0), axis=-1) for row in rows]
    return np.asarray(np.max(np.concatenate(moved), axis=0, initial=0.0))
