"""How far brightness leads a body astray in a segment, beside what it says of its own doubts.

The doubts of a step are those of one pair of pictures. What leads astray for many frames, such as a
shirt without texture, or an arm before the trunk, is not in them; but where the body, followed from
one keyframe, arrives beside the other, it is all there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.geometry.rotations import log_rotation, transpose
from keypose.tracker.solver.posed import by_dof

if TYPE_CHECKING:
    from keypose.tracker.body.pose import Pose
    from keypose.tracker.body.skeleton import Skeleton
    from keypose.tracker.geometry.rotations import Array
    from keypose.tracker.solver.smoothness import Increments
    from keypose.tracker.tracking.initial.chains import Chains
    from keypose.tracker.tracking.segment import Segment

USUAL, MOST = 2.0, 5.0
"""So many times as far as doubts say a body drifts that is followed well, and the most that is
believed."""
MEDIAN_OF_SIZES = 0.6745
"""Median of the sizes of what is normal with standard deviation 1."""


def increment_scale(segment: Segment, chains: Chains, measured: Increments) -> float:
    """Return how many times as far as usual the chains miss the keyframes, from 1.

    chains: the body followed from both keyframes.  measured: the steps between, with their doubts.
    The median over all degrees of freedom: one limb that was lost says nothing of the others.
    """
    known = measured.precision > 0
    variance = np.where(known, 1 / np.maximum(measured.precision, np.finfo(float).tiny), 0.0)
    expected = np.sqrt(variance.sum(axis=0))
    forward, backward = chains
    missed = np.stack([
        _apart(measured.skeleton, forward.pose(segment.last_frame), segment.end),
        _apart(measured.skeleton, backward.pose(segment.first_frame), segment.start),
    ])  # fmt: skip
    sizes = np.abs(missed[:, known.any(axis=0)]) / expected[known.any(axis=0)]
    if not sizes.size:
        return 1.0
    return float(np.clip(np.median(sizes) / (MEDIAN_OF_SIZES * USUAL), 1.0, MOST))


def _apart(skeleton: Skeleton, one: Pose, other: Pose) -> Array:
    """(D,) from one pose to another, by degrees of freedom."""
    R = one.Rs_parent_part
    turn = log_rotation(transpose(R) @ other.Rs_parent_part)
    return by_dof(skeleton, turn, R[0], other.p_camera_root - one.p_camera_root)
