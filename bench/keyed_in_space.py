"""Keyframes as somebody has them who also knows about where joints are in space, as from the side
views of a careful hand or from further cameras.

Sizes are those of the reference's bones, poses lie on the marks and near its joints. With them a
benchmark tells what tracking adds to depth; keyframes posed on one picture hide that by their own
error.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bench.clips import Clip, place
from bench.keyed import Keyed, keyed
from bench.posing import sized
from keypose.tracker.body.body import Body
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.fit_joints import (
    CRITERIA,
    LIMIT_SIGMA_RAD,
    NEAREST_M,
    PIXEL_SIGMA,
    fit_motion,
)
from keypose.tracker.solver.least_squares import least_squares
from keypose.tracker.solver.one_pose import OnePose
from keypose.tracker.solver.pose_terms import JointLimits, PointsInPicture, PointsInSpace, PosePrior
from keypose.tracker.solver.posed import BodyPoints, free_skeleton

SPACE_M = 0.02
"""How well the reference's joints are known."""
HELD_RAD = np.radians(30.0)
BONES = {
    "upper_arm": ("Shoulder", "Elbow"),
    "forearm": ("Elbow", "Wrist"),
    "thigh": ("Hip", "Knee"),
    "shin": ("Knee", "Ankle"),
}


def keyed_in_space(clip: Clip, keyframes: Sequence[int]) -> Keyed:
    """The body with the reference's bones, posed on marks and reference together."""
    assert clip.space is not None
    names, joints = clip.space
    skeleton = Skeleton.of(_sized(clip, names, joints))
    places = [place(skeleton.body, name) for name in names]
    start = fit_motion(skeleton.body, places, joints[list(keyframes)], 0).trajectory
    near = keyed(clip, keyframes).poses
    poses = {
        frame: _posed(clip, skeleton, frame, near[frame], start.pose(row))
        for row, frame in enumerate(keyframes)
    }
    return Keyed(skeleton, poses)


def _sized(clip: Clip, names: Sequence[str], joints: Array) -> Body:
    """The preset with the reference's mean bones."""
    body, at = clip.body, {name: joints[:, i] for i, name in enumerate(names)}
    skeleton = Skeleton.of(body)
    points = BodyPoints(skeleton, tuple(place(body, name) for name in names))
    rest = pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))
    ours = dict(zip(names, points.at(rest), strict=True))

    def ratio(pairs: Sequence[tuple[str, str]]) -> float:
        theirs = np.mean([np.nanmean(np.linalg.norm(at[a] - at[b], axis=-1)) for a, b in pairs])
        mine = np.mean([np.linalg.norm(ours[a] - ours[b]) for a, b in pairs])
        return float(theirs / mine)

    limbs = [ratio([(s + a, s + b) for s in "LR"]) for a, b in BONES.values()]
    trunk = ratio([("LShoulder", "LHip"), ("RShoulder", "RHip")])
    shoulders, hips = ratio([("LShoulder", "RShoulder")]), ratio([("LHip", "RHip")])
    return sized(body, (1.0, *limbs, trunk, shoulders, hips)).body


def _posed(clip: Clip, skeleton: Skeleton, frame: int, near: Pose, start: Pose) -> Pose:
    assert clip.space is not None
    names, joints = clip.space
    free, ideal = free_skeleton(skeleton.body), clip.camera.without_distortion()
    marks = clip.posed_on(frame)
    uv = ideal.project(clip.camera.back_project(np.array(list(marks.values())), 1.0))
    seen = BodyPoints(free, tuple(place(skeleton.body, name) for name in marks))
    known = np.isfinite(joints[frame]).all(axis=-1)
    there = BodyPoints(
        free, tuple(place(skeleton.body, n) for n, k in zip(names, known, strict=True) if k)
    )
    turns = (free.dof_turns == 1) & (free.dof_part > 0)
    usual = PosePrior.of(near, np.where(turns, HELD_RAD**-2.0, 0.0))
    terms = [
        PointsInPicture(seen, ideal, uv, np.full(len(uv), 1 / PIXEL_SIGMA), NEAREST_M),
        PointsInSpace(there, joints[frame][known], SPACE_M),
        JointLimits(Limits.of(skeleton.body), LIMIT_SIGMA_RAD),
        usual,
    ]
    return least_squares(OnePose(free, terms, floor=1.0), start, CRITERIA).state
