"""By how much each joint of a tracked motion is expected to be off, from what tracking saw.

Three things go together with the error of a joint beyond that of the keyframes. How far brightness
leads from the motion at its part: where pictures say otherwise than keypoints and keyframes,
something is wrong. How far the motions lie apart that two different starts led to. And how far the
nearer keyframe is. Errors last longer than a frame, so a few frames show more than one. How far a
joint lies from its keypoint, and how well that is seen, say little besides: brightness puts many a
joint right whose keypoint is elsewhere. Where keypoints alone were followed there is nothing else.

The error is taken to be log-logistic about its median, which is a product of powers of the three:
at once by how much a joint is off, and how likely that is more than a given length. Of ten clips,
one filmed by four cameras, two filmed and marked by hand, seven rendered, each judged by the
others: the area under the curve of joints more than 10 px off on a person 400 px tall is 0.87 over
all joints and 0.82 to 0.98 by clip, but 0.68 on one whose marks are good to 5 px there; of those
more than 15 px off 0.89, and 0.83 to 0.99. By tenths of all joints, what is expected in the mean is
1.0 to 1.5 times what they are off by.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array

WRONG = 0.0375
"""Of the body's height in the picture: a joint farther off is wrong. Marks by hand tell no less."""
LEAST, LEAST_DRIFT = 0.003, 0.0001
"""Below them differences between motions, and those of a step from what brightness says, say
nothing."""
NEAR = 5
"""Frames on either side that count for a joint as well."""
BASE, BY_APART, BY_DRIFT, BY_AWAY, SPREAD = 0.28, 0.15, 0.77, 0.29, 0.351
"""Median error = e^BASE · apart^BY_APART · drift^BY_DRIFT · away^BY_AWAY, a share of the height,
away in frames; SPREAD is the scale of its logarithm. Errors up to 1.5 % counted as no more than
that when this was fitted: marks by hand are good to no less."""
ALONE_BASE, ALONE_BY_DISTANCE, ALONE_BY_HIDDEN, ALONE_SPREAD = -2.64, 0.35, 0.07, 0.365
"""The same where there was one start only, as from keypoints alone: by the distance of keypoints
and how little they are seen."""
MOST = 0.5
"""Nothing is expected to be off by more."""
TINY = 1e-9
"""A share of the height that stands for none, so that it has odds."""
FEW, LITTLE_PX, TALL_PX = 0.05, 4.7, 288.0
"""A segment is good where all joints at all frames but so few are expected to be off by so little,
in the picture or on a person so tall: marks in a larger one are no finer. With 400 for
288 a third of the segments between marked keyframes are said to be good, with 288 half: all within
6 px of their marks in the mean on a person 400 px tall, where marks differ by 3 to 4 px from one
person to the next (`python -m bench evidence`)."""
KEYED_WRONG, KEYED_SURE = 0.04, 0.8
"""A joint of a keyframe is doubted that lies this far from a keypoint which is seen so well."""
BACK, COMES_BACK = slice(1, 4), 0.5
"""In these frames after the one that follows a keyframe, a joint is back at its keypoint to so much
of its distance. Where it is not, it is the keypoint that is elsewhere, and the joint goes on."""
KEYED_ERROR = 0.015
"""Nor is a keyframe doubted where pictures do not contradict the motion beside it: of 38 keypoints
elsewhere on right keyframes 4 are reported still, of limbs turned by 30°, where keypoints showed
it, 8 of 8."""
UNKNOWN = 0.05
"""How far a joint is taken to be from its keypoint where there is none."""


@dataclass(frozen=True, eq=False)
class JointEvidence:
    """K joints in the N frames of a segment; distances are shares of the body's height.

    parts (K,): the part that carries each.  distance (N, K): of its keypoint, NaN without one.
    visibility (N, K).  apart (N, K): of the motions from different starts, NaN where there was one.
    drift (N, K): how far brightness leads from the motion in one step, at the part's worst mark.
    height_px: of the body, in pixels of the pictures worked on.
    keyed: rows that are keyframes.
    """

    parts: NDArray[np.int64]
    distance: Array
    visibility: Array
    apart: Array
    drift: Array
    height_px: float
    keyed: tuple[int, ...] = (0, -1)

    @property
    def error(self) -> Array:
        """(N, K) the median of what a joint is expected to be off by; 0 at keyframes."""
        return self._expected[0]

    @property
    def wrong(self) -> Array:
        """(N, K) probability that a joint is off by more than WRONG; 0 at keyframes."""
        error, spread = self._expected
        return np.asarray(1 / (1 + (WRONG / np.maximum(error, TINY)) ** (1 / spread)))

    @property
    def is_good(self) -> bool:
        """Return whether all joints but few are expected to be off by little."""
        between = np.delete(self.error, list(self.keyed), axis=0)
        px = between * min(self.height_px, TALL_PX)
        return not between.size or bool(np.quantile(px, 1 - FEW) <= LITTLE_PX)

    def expected_error(self, parts: int) -> Array:
        """(N, P) shares of the body's height by which a part's worst joint is expected to be off,
        in the mean; NaN for parts that carry none."""
        error, spread = self._expected
        by_joint = error * (np.pi * spread / np.sin(np.pi * spread))  # mean of a log-logistic
        expected = np.full((len(by_joint), parts), np.nan)
        for joint, part in enumerate(self.parts):
            expected[:, part] = np.fmax(expected[:, part], by_joint[:, joint])
        return expected

    @property
    def _away(self) -> Array:
        """(N,) frames to the nearest keyframe."""
        rows = np.arange(len(self.distance), dtype=float)
        return np.asarray(np.abs(rows[:, None] - rows[list(self.keyed)]).min(axis=1))

    @property
    def _expected(self) -> tuple[Array, Array]:
        """(N, K) the median of every error, and (N, K) the spread of its logarithm."""
        from scipy.ndimage import maximum_filter1d  # scipy: loads longer than a page needs to start

        # of one start: the farthest keypoint near by
        farthest = np.where(np.isfinite(self.distance), self.distance, -1.0)
        farthest = maximum_filter1d(farthest, 2 * NEAR + 1, axis=0, mode="nearest")
        distance = np.log(np.where(farthest < 0, UNKNOWN, farthest) + LEAST)
        hidden = np.log(1 - _mean_near(self.visibility) + LEAST)
        alone = ALONE_BASE + ALONE_BY_DISTANCE * distance + ALONE_BY_HIDDEN * hidden
        # of two: what they and the pictures say
        apart, drift = _mean_near(self.apart), _mean_near(self.drift)
        both = BASE + BY_APART * np.log(apart + LEAST) + BY_DRIFT * np.log(drift + LEAST_DRIFT)
        both += BY_AWAY * np.log(self._away + 1)[:, None]
        is_both = np.isfinite(apart)
        error = np.minimum(np.exp(np.where(is_both, both, alone)), MOST)
        error[list(self.keyed)] = 0.0
        return error, np.where(is_both, SPREAD, ALONE_SPREAD)

    def keyed_wrong(self, limbs: NDArray[np.bool_]) -> tuple[int, int] | None:
        """The row of a keyframe, 0 or N − 1, and its joint that lies farthest from a keypoint which
        is seen well, and is back at it soon, against what pictures say; None where all lie near.

        limbs (P,): the parts whose joints are asked. On a stiff trunk shoulders and hips of a right
        pose lie off by as much.
        """
        rows = np.array([0, len(self.distance) - 1])
        distance, error = np.nan_to_num(self.distance), self.error
        after = [distance[1:-1][BACK], distance[-2:0:-1][BACK]]
        back = np.array([some.max(axis=0, initial=0.0) for some in after])
        beside = [error[1:-1][:NEAR], error[-2:0:-1][:NEAR]]
        moved = np.array([some.max(axis=0, initial=0.0) for some in beside]) > KEYED_ERROR
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
