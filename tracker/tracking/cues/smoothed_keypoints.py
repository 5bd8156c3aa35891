"""Keypoints without their shaking: what they say of a motion slowly, the picture says quickly.

Where a detector puts a joint is off by two amounts: one that lasts for many frames, and one that is
another in every frame. Brightness is the other way round: it shows each step closely, and leads
astray slowly. So keypoints count by where they lie beside the present motion in the mean over some
frames, and not in each frame by itself: their shaking does not reach the motion, and what is left
of them is so much surer.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import image_points
from keypose.tracker.solver.robust import Cauchy
from keypose.tracker.tracking.cues.anchors import Anchors
from keypose.tracker.tracking.scene import Scene

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
