"""A person in random poses, as a perfect detector would list its keypoints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.formats.joint_names import matched
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.keypoints.layouts import LAYOUTS
from keypose.tracker.solver.posed import BodyPoints

SKELETON = Skeleton.of(preset("adult_female"))


def seen_person(
    layout: str,
    rng: np.random.Generator,
    frames: int = 1,
    missing: float = 0.0,
    noise_px: float = 2.0,
) -> NDArray[np.float64]:
    """(N, L, 2) pixels of a person about 500 px tall, NaN where missing or not on the body.

    The first frame's pose and view are random, the next ones are near it.
    """
    known = matched(SKELETON, LAYOUTS[layout], "a.json")
    points = BodyPoints(SKELETON, tuple(known.places))
    start = rng.normal(0, 0.6, (SKELETON.part_count, 3))
    start[0] = rng.uniform(-np.pi, np.pi, 3) * (0.3, 1.0, 0.3)
    uv = np.full((frames, len(LAYOUTS[layout]), 2), np.nan)
    for row in uv:
        turns = start + rng.normal(0, 0.15, start.shape)
        p = points.at(pose_transforms(SKELETON, Pose(exp_rotation(turns), np.array([0, 0, 4.0]))))
        row[known.indices] = 600 + 1200 * p[:, :2] / p[:, 2:] + rng.normal(0, noise_px, (len(p), 2))
    uv[rng.random(uv.shape[:2]) < missing] = np.nan
    return uv
