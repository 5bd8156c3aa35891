"""By how much each joint of a tracked motion is expected to be off, from what tracking saw.

Three things go together with the error of a joint beyond that of the keyframes. How far brightness
leads from the motion at its part: where pictures say otherwise than keypoints and keyframes,
something is wrong. How far the motions lie apart that two different starts led to. And how far the
nearer keyframe is. Errors last longer than a frame, so a few frames show more than one. How far a
joint lies from its keypoint, how well that is seen, how fast the joint is, and which it is, say
nothing besides on clips left out: brightness puts many a joint right whose keypoint is elsewhere.
Where keypoints alone were followed there is nothing else.

What is expected is the median: half of the joints of which it is predicted are off by less. It is a
product of powers of the three. Of ten rendered and four filmed clips, each judged by the others,
with what marks by hand are off themselves taken out, the median measured is 0.8 to 1.1 times the
predicted one in every band from 3 to 40 px on a person 400 px tall; on a single clip, over 3 px,
0.6 to 1.4 times (`python -m bench evidence`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.angle_errors import MEDIAN_OF_SIGMA
from keypose.tracker.geometry.rotations import Array

LEAST = 0.003
LEAST_DRIFT = 0.0001
"""Below them differences between motions, and those of a step from what brightness says, say
nothing."""


class Weights(NamedTuple):
    """What an error is expected by: e^base · apart^by_apart · drift^by_drift · away^by_away, a
    share of the height, away in frames. Below `floor`, as keyframes and keypoints are off
    themselves, its logarithm falls by a share `below` only."""

    base: float
    by_apart: float
    by_drift: float
    by_away: float
    floor: float
    below: float

    def median(self, apart: Array, drift: Array, away: Array) -> Array:
        """The median of the error of joints, as a share of the height, of any shape."""
        log_error = self.base + self.by_apart * np.log(apart + LEAST)
        log_error = log_error + self.by_drift * np.log(drift + LEAST_DRIFT)
        log_error = log_error + self.by_away * np.log(away + 1)
        under = np.minimum(log_error - np.log(self.floor), 0.0)
        return np.asarray(np.exp(log_error - (1 - self.below) * under))


FITTED: Final = Weights(1.74, 0.584, 0.700, 0.180, 0.00415, 0.147)
"""By which half of the joints of all clips are off by less (`python -m bench evidence`)."""
NEAR = 5
"""Frames on either side that count for a joint as well."""
ALONE_BASE = -2.68
ALONE_BY_DISTANCE = 0.415
"""The same where there was one start only, as from keypoints alone: by their distance."""
MOST = 0.5
"""Nothing is expected to be off by more."""
GOOD = 0.0065
GOOD_ALONE = 0.0125
GOOD_JOINT = 0.03
"""A segment is good whose joints are expected to be off by no more than this share of the height in
the mean, by the second of one start, and none at any frame by more than the third. So is three
quarters of those whose joints are at most 5 px off in the mean, on a person 400 px tall, and of the
good ones 98 % are like that (`python -m bench evidence`)."""
LOST = 0.10
LOST_SHARE = 0.15
"""It is lost where so many joints, more than a limb has, are expected to be off by so much at all
frames: half of these are off by more."""
KEYED_WRONG = 0.04
KEYED_SURE = 0.8
"""A joint of a keyframe is doubted that lies this far from a keypoint which is seen so well."""
BACK = slice(1, 4)
COMES_BACK = 0.5
"""In these frames after the one that follows a keyframe, a joint is back at its keypoint to so much
of its distance. Where it is not, it is the keypoint that is elsewhere, and the joint goes on."""
KEYED_ERROR = 0.0075
"""Nor is a keyframe doubted where pictures do not contradict the motion beside it: in no good
segment of 185 between right keyframes, and in 9 of 21 beside a keyframe with a limb turned by 30°.
"""
USUAL_M: Final = 0.04
SPREAD: Final = 0.6
"""What the lifting network says is far off is so less on film: above the first a median grows by
the second as a power of what the network says (`python -m bench angles`)."""
POSED_M: Final = 0.02
"""How well a person poses depth, the median."""
POSED_S: Final = 0.38
"""A depth that is off is off alike for a while. From a keyframe whose depth a person posed its
error grows evenly, and after so long is what the network is off by itself. Of four films with truth
0.27, 0.42 and 0.67 of it are left in the middle of keyframes 0.2, 0.3 and 0.5 s apart."""
FOOT_OWN: Final = 0.02
"""Share of the height by which heels and toes of a foot that is right are from their keypoints, as
a rule: three films, in the median 0.006 to 0.027."""
GOOD_FOOT: Final = 0.05
"""A foot that is off by so much is seen to hang."""
UNKNOWN = 0.05
"""How far a joint is taken to be from its keypoint where there is none."""


@dataclass(frozen=True, eq=False)
class Sight:
    """What a film's keypoints say of K joints in N frames.

    parts (K,), distance, visibility (N, K): as of `JointEvidence`.  depth_sigma_m (N, K): standard
    deviation of how far a joint is along the first film's view, infinite where this film does not
    see it, or looks the same way.
    """

    parts: NDArray[np.int64]
    distance: Array
    visibility: Array
    depth_sigma_m: Array


@dataclass(frozen=True, eq=False)
class JointEvidence:
    """K joints in the N frames of a segment; distances are shares of the body's height.

    parts (K,): the part that carries each.  distance (N, K): of its keypoint, NaN without one.
    visibility (N, K).  apart (N, K): of the motions from different starts, NaN where there was one.
    drift (N, K): how far brightness leads from the motion in one step, at the part's worst mark.
    height_px: of the body, in pixels of the pictures worked on.
    keyed: rows that are keyframes.
    depth_sigma_m (N, K): of how far a joint is from the hips along the view; NaN where no depth was
        lifted.
    foot_distance (N, F): of heels and toes from their keypoints, NaN without one.
    foot_parts (F,): which feet carry them.
    """

    parts: NDArray[np.int64]
    distance: Array
    visibility: Array
    apart: Array
    drift: Array
    height_px: float
    keyed: tuple[int, ...] = (0, -1)
    depth_sigma_m: Array | None = None
    foot_distance: Array | None = None
    foot_parts: NDArray[np.int64] | None = None

    def with_sight(self, sight: Sight) -> JointEvidence:
        """The same with what another film shows of the joints: one that is hidden in one film is
        held by the other, and what lies along the view of one lies across that of the other."""
        if not np.array_equal(sight.parts, self.parts):
            return self
        own, beside = self.visibility, sight.visibility
        distances = np.stack([self.distance, sight.distance])
        weights = np.stack([own, beside]) ** 2 * np.isfinite(distances)
        total = np.maximum(weights.sum(axis=0), np.finfo(np.float64).tiny)
        squares = (weights * np.nan_to_num(distances) ** 2).sum(axis=0) / total
        distance = np.where(weights.any(axis=0), np.sqrt(squares), np.nan)
        lifted = np.full(own.shape, np.nan) if self.depth_sigma_m is None else self.depth_sigma_m
        information = np.nan_to_num(lifted**-2.0) + sight.depth_sigma_m**-2.0
        with np.errstate(divide="ignore"):
            depth_sigma_m = np.where(information > 0, information**-0.5, np.nan)
        return replace(
            self,
            distance=distance,
            visibility=np.maximum(own, beside),
            depth_sigma_m=depth_sigma_m,
        )

    @property
    def error(self) -> Array:
        """(N, K) the median of what a joint is expected to be off by; 0 at keyframes."""
        from scipy.ndimage import maximum_filter1d  # scipy: loads longer than a page needs to start

        # of one start: the farthest keypoint near by
        farthest = np.where(np.isfinite(self.distance), self.distance, -1.0)
        farthest = maximum_filter1d(farthest, 2 * NEAR + 1, axis=0, mode="nearest")
        distance = np.log(np.where(farthest < 0, UNKNOWN, farthest) + LEAST)
        alone = np.exp(ALONE_BASE + ALONE_BY_DISTANCE * distance)
        # of two: what they and the pictures say
        apart, drift = _mean_near(self.apart), _mean_near(self.drift)
        both = FITTED.median(apart, drift, self._away[:, None])
        error = np.minimum(np.where(np.isfinite(apart), both, alone), MOST)
        error[list(self.keyed)] = 0.0
        return error

    @property
    def is_good(self) -> bool:
        """Whether joints are expected to be off by little, in the mean and each."""
        between, most = self._between, GOOD if np.isfinite(self.apart).any() else GOOD_ALONE
        return not between.size or bool(between.mean() <= most and between.max() <= GOOD_JOINT)

    @property
    def is_lost(self) -> bool:
        """Whether many joints are expected to be off by far."""
        between = self._between
        return bool(between.size and (between > LOST).mean() > LOST_SHARE)

    def expected_error(self, parts: int) -> Array:
        """(N, P) shares of the body's height by which a part's worst joint is expected to be off;
        NaN for parts that carry none."""
        return self._of_parts(self.error, parts)

    def expected_foot_error(self, parts: int) -> Array:
        """(N, P) shares of the height by which the farther of a foot's heel and toe is expected to
        be off; NaN for parts that are no feet. Feet follow shins: where they are seen elsewhere,
        they are."""
        errors = np.full((len(self.distance), parts), np.nan)
        if self.foot_distance is None or self.foot_parts is None:
            return errors
        for part, distance in zip(self.foot_parts, self.foot_distance.T, strict=True):
            near = _median_near(distance)
            beyond = np.sqrt(np.maximum(near**2 - FOOT_OWN**2, 0.0))
            beyond[list(self.keyed)] *= 0.0  # what was not seen stays unknown
            errors[:, part] = np.fmax(errors[:, part], beyond)
        return errors

    def expected_depth_m(self, parts: int, to_posed_s: Array | None = None) -> Array | None:
        """(N, P) metres along the view by which a part's worst joint is expected to be off, the
        median; NaN for parts that carry none. None where no depth was lifted.

        Of four films with truth in space, none of which the network was trained on, about half of
        the joints are off by less in every band above 3.5 cm (`python -m bench angles`).

        to_posed_s: see `Segment`.
        """
        if self.depth_sigma_m is None or not np.isfinite(self.depth_sigma_m).any():
            return None
        median_m = MEDIAN_OF_SIGMA * self.depth_sigma_m
        beyond = np.maximum(median_m / USUAL_M, 1.0)
        median_m = median_m * beyond ** (SPREAD - 1)
        worst_m = self._of_parts(median_m, parts)
        if to_posed_s is None:
            return worst_m
        share = np.minimum(to_posed_s / POSED_S, 1.0)
        return np.asarray(np.hypot(share * worst_m, (1 - share) * np.minimum(worst_m, POSED_M)))

    def _of_parts(self, of_joints: Array, parts: int) -> Array:
        """(N, P) the largest of a part's joints."""
        largest = np.full((len(of_joints), parts), np.nan)
        for joint, part in enumerate(self.parts):
            largest[:, part] = np.fmax(largest[:, part], of_joints[:, joint])
        return largest

    @property
    def _between(self) -> Array:
        """(N − 2, K) the errors at frames that are no keyframes."""
        return np.delete(self.error, list(self.keyed), axis=0)

    @property
    def _away(self) -> Array:
        """(N,) frames to the nearest keyframe."""
        rows = np.arange(len(self.distance), dtype=float)
        return np.asarray(np.abs(rows[:, None] - rows[list(self.keyed)]).min(axis=1))

    def keyed_wrong(self, limbs: NDArray[np.bool_]) -> tuple[int, int] | None:
        """The row of a keyframe, 0 or N − 1, and its joint that lies farthest from a keypoint which
        is seen well, and is back at it soon, against what pictures say; None where all lie near.

        limbs (P,): the parts whose joints are asked. On a stiff trunk shoulders and hips of a right
        pose lie off by as much.
        """
        rows = np.array([0, len(self.distance) - 1])
        distance, error = np.nan_to_num(self.distance), self.error
        after = [distance[1:-1][BACK], distance[-2:0:-1][BACK]]
        back = np.array([distances.max(axis=0, initial=0.0) for distances in after])
        beside = [error[1:-1][:NEAR], error[-2:0:-1][:NEAR]]
        moved = np.array([distances.max(axis=0, initial=0.0) for distances in beside]) > KEYED_ERROR
        asked = (self.visibility[rows] >= KEYED_SURE) & limbs[self.parts] & moved
        away = distance[rows] * (asked & (back < COMES_BACK * distance[rows]))
        k, joint = np.unravel_index(int(away.argmax()), away.shape)
        return (int(rows[k]), int(joint)) if away[k, joint] > KEYED_WRONG else None


def _mean_near(values: Array) -> Array:
    """(N, K) the mean over the frames near each that there are."""
    from scipy.ndimage import uniform_filter1d

    size = 2 * NEAR + 1
    there = uniform_filter1d(np.ones(len(values)), size, mode="constant")
    mean = uniform_filter1d(values, size, axis=0, mode="constant") / there[:, None]
    return np.asarray(mean)


def _median_near(values: Array) -> Array:
    """(N,) the median over the frames near each that have a value; NaN where none has."""
    padded = np.pad(values, NEAR, constant_values=np.nan)
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * NEAR + 1)
    is_known = np.isfinite(windows).any(axis=1)
    medians = np.full(len(values), np.nan)
    medians[is_known] = np.nanmedian(windows[is_known], axis=1)
    return medians
