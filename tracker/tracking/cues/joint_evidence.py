"""What keypoints show of a tracked motion: how likely each joint is wrong, and by how much.

Three things go together with the error of a joint: how far its keypoint lies from it at the worst
frame near by, how well the keypoint is seen, and how far the motions apart lie that two different
starts led to. Errors last longer than a frame and keypoints shake, so a few frames show more than
one. Within filmed clips whose joints were marked by hand, each judged by the others, the area under
the curve of joints more than 15 px off on a person 400 px tall is 0.82 in the mean, of single
frames 0.73. Of those more than 10 px off it is 0.73 (0.64): on the smallest person that is 5 px,
which is about what marks are good to. On rendered people, who are known exactly and were not used,
it is 0.89 for 15 px and 0.85 for 10. The covariance of the solve, how well a part is observed, its
residual and the distance from the nearest keyframe add up to 0.07 there, and take as much away on
filmed clips: none of them is used.

Of a segment as a whole the two motions alone say most: whether joints are off by less than 5 px in
the mean shows in how near they ended to one another (area 0.87 on nine clips; by the mean
probability 0.66).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array

WRONG = 0.0375
"""Of the body's height in the picture: a joint farther off is wrong. Marks by hand tell no less."""
LEAST = 0.003
"""Below it differences say nothing."""
NEAR = 5
"""Frames on either side that count for a joint as well."""
BASE, BY_DISTANCE, BY_HIDDEN, BY_APART = 7.0, 1.18, 0.08, 1.03
"""Logistic regression of wrong joints on the logarithms of the three; slopes common to errors of 7
to 20 px on a person 400 px tall (proportional odds), the base that of 15."""
ALONE_BASE, ALONE_BY_DISTANCE, ALONE_BY_HIDDEN = 1.9, 1.07, 0.31
"""The same where there was one start only, as from keypoints alone."""
RIGHT_ERROR, WRONG_ERROR = 0.012, 0.05
"""Mean error of joints that are right, and of those that are wrong: shares of the body's height."""
AGREED, BY_LENGTH = 0.0061, 0.1
"""A segment is taken to be right where the geometric mean of `apart` + LEAST, times its length in
frames to this power, is at most AGREED. Of 133 segments of nine clips, four of them filmed, 97 % of
those are right, and of the right ones 71 % are among them; with a limit for each clip that was set
on the others 97 % and 62 %."""
KEYED_WRONG, KEYED_SURE = 0.04, 0.8
"""A joint of a keyframe is doubted that lies this far from a keypoint which is seen so well."""
BACK, COMES_BACK = slice(1, 4), 0.5
"""In these frames after the one that follows a keyframe, a joint is back at its keypoint to so much
of its distance. Where it is not, it is the keypoint that is elsewhere, and the joint goes on."""
UNKNOWN = 0.05
"""How far a joint is taken to be from its keypoint where there is none."""


@dataclass(frozen=True, eq=False)
class JointEvidence:
    """K joints in the N frames of a segment; distances are shares of the body's height.

    parts (K,): the part that carries each.  distance (N, K): of its keypoint, NaN without one.
    visibility (N, K).  apart (N, K): of the motions from different starts, NaN where there was one.
    height_px: of the body, in pixels of the pictures worked on.
    keyed: rows that are keyframes.
    """

    parts: NDArray[np.int64]
    distance: Array
    visibility: Array
    apart: Array
    height_px: float
    keyed: tuple[int, ...] = (0, -1)

    @property
    def wrong(self) -> Array:
        """(N, K) probability that a joint is off by more than WRONG; 0 at keyframes."""
        from scipy.ndimage import maximum_filter1d  # scipy: loads longer than a page needs to start
        from scipy.special import expit

        farthest = np.where(np.isfinite(self.distance), self.distance, -1.0)
        farthest = maximum_filter1d(farthest, 2 * NEAR + 1, axis=0, mode="nearest")
        distance = np.log(np.where(farthest < 0, UNKNOWN, farthest) + LEAST)
        hidden = np.log(1 - _mean_near(self.visibility) + LEAST)
        apart = _mean_near(self.apart)
        alone = ALONE_BASE + ALONE_BY_DISTANCE * distance + ALONE_BY_HIDDEN * hidden
        both = BASE + BY_DISTANCE * distance + BY_HIDDEN * hidden + BY_APART * np.log(apart + LEAST)
        wrong = expit(np.where(np.isfinite(apart), both, alone))
        wrong[list(self.keyed)] = 0.0
        return np.asarray(wrong)

    @property
    def agreed(self) -> bool | None:
        """Whether both starts led to the same motion; None where there was one."""
        between = np.delete(self.apart, list(self.keyed), axis=0)
        if not np.isfinite(between).all():
            return None
        if not between.size:
            return True
        length = len(self.apart) - 1
        return bool(np.log(between + LEAST).mean() + BY_LENGTH * np.log(length) <= np.log(AGREED))

    def expected_error(self, parts: int) -> Array:
        """(N, P) shares of the body's height by which a part's worst joint is expected to be off;
        NaN for parts that carry none."""
        by_joint = RIGHT_ERROR + (WRONG_ERROR - RIGHT_ERROR) * self.wrong
        by_joint[list(self.keyed)] = 0.0
        expected = np.full((len(by_joint), parts), np.nan)
        for joint, part in enumerate(self.parts):
            expected[:, part] = np.fmax(expected[:, part], by_joint[:, joint])
        return expected

    def keyed_wrong(self, limbs: NDArray[np.bool_]) -> tuple[int, int] | None:
        """The row of a keyframe, 0 or N − 1, and its joint that lies farthest from a keypoint which
        is seen well, and is back at it soon; None where all lie near.

        limbs (P,): the parts whose joints are asked. On a stiff trunk shoulders and hips of a right
        pose lie off by as much.
        """
        rows = np.array([0, len(self.distance) - 1])
        distance = np.nan_to_num(self.distance)
        after = [distance[1:-1][BACK], distance[-2:0:-1][BACK]]
        back = np.array([some.max(axis=0, initial=0.0) for some in after])
        asked = (self.visibility[rows] >= KEYED_SURE) & limbs[self.parts]
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
