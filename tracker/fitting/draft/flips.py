"""Whether a limb may point the other way: toward the camera instead of away from it.

In the picture both look the same: the far joint of a bone lies on its ray, at either of the two
places as far from the near joint as the bone is long. `depth_signs` decides by the whole stretch;
the network's depths then say how far that is to be believed. A bone is doubted where the
network does not see it point clearly the way it was drafted, over the frames near by in which it
points the same way: a bone that is mirrored stays so until it passes through the picture's plane.
"""

from __future__ import annotations

import numpy as np
from scipy.special import expit

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.draft.depth_signs import PLANE, tilt
from keypose.tracker.fitting.draft.limbs import Bone, Joints
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array

NEAR_FRAMES = 10
"""Before and after a frame, in which a bone that points the same way is asked as well."""
BASE, BY_ALONG, BY_APART, OF_LEG = -1.1, -16.3, 10.3, -3.0
"""Logistic regression of mirrored bones, distances in metres: four cameras around a filmed man
whose joints in space are known, area under the curve 0.91, each camera judged by the other three.
Joint limits, visibility and distances from keypoints add nothing, nor does what the
network finds in turned and larger pictures. Solved for with a bone the other way, of 68 stretches
that were right 29 cost no more, of five that were mirrored four."""
HALF = 0.05
"""Probability at which a limb is doubted by half. On these cameras 75 of the 82 limbs that are
still mirrored are, and of seven limbs that are, one is mirrored."""


def flip_doubts(joints: Joints, camera: Camera, network_m: Array, motion: Trajectory) -> Array:
    """(N, 4) by limb how doubtful it is that it points the right way in depth, from 0 to 1.

    network_m (N, 12): how much farther than the root the network sees each joint of the N frames.
    camera: without distortion.
    """
    p = joints.seen.at(motion.transforms(joints.skeleton))
    doubts = [
        np.maximum(
            _mirrored(joints, limb.upper, camera, p, network_m, is_leg=k > 1),
            _mirrored(joints, limb.lower, camera, p, network_m, is_leg=k > 1),
        )
        for k, limb in enumerate(joints.limbs)
    ]
    mirrored = np.stack(doubts, axis=1)
    return np.asarray(mirrored / (mirrored + HALF))


def _mirrored(
    joints: Joints, bone: Bone, camera: Camera, p: Array, network_m: Array, *, is_leg: bool
) -> Array:
    """(N,) probability that a bone is mirrored; 0 where it is in the picture's plane."""
    length = joints.seen_length_m(bone)
    drafted = tilt(camera, p, bone)
    network = np.clip(network_m[:, bone.far] - network_m[:, bone.near], -length, length)
    along = _near_mean(np.sign(drafted) * network, drafted)
    apart = _near_mean(np.abs(length * drafted - network), drafted)
    odds = BASE + BY_ALONG * along + BY_APART * apart + OF_LEG * is_leg
    return np.where(np.abs(drafted) >= PLANE, expit(odds), 0.0)


def _near_mean(values: Array, drafted: Array) -> Array:
    """(N,) the mean over near frames in which the bone points the same way."""
    out = np.empty(len(values))
    for n, here in enumerate(drafted):
        rows = slice(max(0, n - NEAR_FRAMES), n + NEAR_FRAMES + 1)
        out[n] = values[rows][drafted[rows] * here >= 0].mean()
    return out
