"""Keeping a moving body on the ground."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import joint_names, joint_positions, part_transforms
from keypose.tracker.body.skeleton import Skeleton

SOLES = ("left_toe", "left_heel", "right_toe", "right_heel")


def lowest_sole(skeleton: Skeleton, Rs_parent_part: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far (N,), metres, the lowest sole of each pose lies below the root (y points down).

    A smooth maximum over toes and heels, so that the root does not jerk when the foot changes.
    """
    T = part_transforms(skeleton, Rs_parent_part, np.zeros((len(Rs_parent_part), 3)))
    names = joint_names(skeleton)
    y = joint_positions(skeleton, T)[:, [names.index(sole) for sole in SOLES], 1]
    softness = 0.015
    highest = y.max(axis=1)
    return highest + softness * np.log(np.exp((y - highest[:, None]) / softness).sum(axis=1))
