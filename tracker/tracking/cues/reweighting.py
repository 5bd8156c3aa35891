"""Weigh brightness against keypoints: scale increments that lead astray, smooth keypoints.

Where a detector puts a joint is off by two amounts: one that lasts for many frames, and one that is
another in every frame. Brightness is the other way round: it shows each step closely, and leads
astray slowly. So keypoints count by where they lie beside the present motion in the mean over some
frames, and not in each frame by itself: their shaking does not reach the motion, and what is left
of them is so much surer.

The doubts of a step are those of one pair of pictures. What leads astray for many frames, such as a
shirt without texture, or an arm before the trunk, is not in them; but where the body, followed from
one keyframe, arrives beside the other, it is all there.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.projection import image_points
from keypose.tracker.solver.robust import Cauchy
from keypose.tracker.tracking.cues.anchors import Anchors
from keypose.tracker.tracking.scene import Scene

if TYPE_CHECKING:
    from keypose.tracker.solver.smoothness import Increments
    from keypose.tracker.tracking.segment import Segment


FRAMES = 4.0
"""Standard deviation of the frames that count, as a Gaussian."""


def smoothed_keypoints(anchors: Anchors, scene: Scene, present: Trajectory) -> Anchors:
    """The anchors as far from a motion of the same frames as they are in the mean about each frame,
    by their weights: what a detector is less sure of, and what lies far off, counts less.

    What a person set stays where it is.
    """
    here = image_points(scene.camera, anchors.where(present.transforms(scene.skeleton)))
    away = anchors.uv - here
    size = np.linalg.norm(away, axis=-1) * anchors.scale
    weight = anchors.scale**2 * Cauchy().weight(size)
    total = np.maximum(_near(weight), np.finfo(np.float64).tiny)
    uv = here + _near(away * weight[..., None]) / total[..., None]
    return replace(anchors, uv=np.where((anchors.scale > 0)[..., None], uv, anchors.uv))


def _near(values: Array) -> Array:
    """(N, …) the sums over the frames near each."""
    from scipy.ndimage import gaussian_filter1d  # scipy: loads longer than a page needs to start

    return np.asarray(gaussian_filter1d(values, FRAMES, axis=0, mode="constant"))


USUAL = 2.0
MOST = 5.0
"""So many times as far as doubts say a body drifts that is followed well, and the most that is
believed."""
MEDIAN_OF_SIZES = 0.6745
"""Median of the sizes of what is normal with standard deviation 1."""


def increment_scale(
    segment: Segment, chains: tuple[Trajectory, Trajectory], measured: Increments
) -> float:
    """How many times as far as usual the chains miss the keyframes, from 1.

    chains: the body followed from both keyframes.  measured: the steps between, with their doubts.
    The median over all degrees of freedom: one limb that was lost says nothing of the others.
    """
    is_measured = measured.precision > 0
    variance = np.where(is_measured, 1 / np.maximum(measured.precision, np.finfo(float).tiny), 0.0)
    expected = np.sqrt(variance.sum(axis=0))
    forward, backward = chains
    missed = np.stack(
        [
            Posed.of(measured.skeleton, to).motion_from(*at.writable(), backward=False)
            for at, to in (
                (forward.pose(segment.last_frame), segment.end),
                (backward.pose(segment.first_frame), segment.start),
            )
        ]
    )
    sizes = np.abs(missed[:, is_measured.any(axis=0)]) / expected[is_measured.any(axis=0)]
    if not sizes.size:
        return 1.0
    return float(np.clip(np.median(sizes) / (MEDIAN_OF_SIZES * USUAL), 1.0, MOST))
