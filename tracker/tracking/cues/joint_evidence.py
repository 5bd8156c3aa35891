"""What keypoints tell of a tracked motion: how likely each joint is wrong, and by how much.

Three things go together with the error of a joint: how far its keypoint lies from it, how well the
keypoint is seen, and how far the motions apart lie that two different starts led to. On filmed
people whose joints were marked by hand they tell a wrong joint from a right one (area under the
curve 0.88, each clip judged by the others); on rendered people, whose joints are known exactly and
who were not used, 0.86.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array

WRONG = 0.025
"""Of the body's height in the picture: a joint farther off is wrong."""
LEAST = 0.003
"""Below it differences say nothing."""
BASE, BY_DISTANCE, BY_HIDDEN, BY_APART = 9.2, 1.04, 0.30, 1.33
"""Logistic regression of wrong joints on the logarithms of the three."""
RIGHT_ERROR, WRONG_ERROR = 0.012, 0.05
"""Mean error of joints that are right, and of those that are wrong: shares of the body's height."""
KEYED_WRONG, KEYED_SURE = 0.04, 0.8
"""A joint of a keyframe is doubted that lies this far from a keypoint which is seen so well."""
UNKNOWN = 0.05
"""How far a joint is taken to be from its keypoint where there is none."""


@dataclass(frozen=True, eq=False)
class JointEvidence:
    """K joints in the N frames of a segment; distances are shares of the body's height.

    parts (K,): the part that carries each.  distance (N, K): of its keypoint, NaN without one.
    visibility (N, K).  apart (N, K): of the motions from different starts.
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
        distance = np.where(np.isfinite(self.distance), self.distance, UNKNOWN)
        logit = (
            BASE
            + BY_DISTANCE * np.log(distance + LEAST)
            + BY_HIDDEN * np.log(1 - self.visibility + LEAST)
            + BY_APART * np.log(self.apart + LEAST)
        )
        wrong = 1 / (1 + np.exp(-logit))
        wrong[list(self.keyed)] = 0.0
        return np.asarray(wrong)

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
        is seen well; None where all lie near.

        limbs (P,): the parts whose joints are asked. On a stiff trunk shoulders and hips of a right
        pose lie off by as much.
        """
        rows = np.array([0, len(self.distance) - 1])
        asked = (self.visibility[rows] >= KEYED_SURE) & limbs[self.parts]
        away = np.nan_to_num(self.distance[rows]) * asked
        k, joint = np.unravel_index(int(away.argmax()), away.shape)
        return (int(rows[k]), int(joint)) if away[k, joint] > KEYED_WRONG else None
