"""Keyframes as somebody has them who sees nothing but the pictures they are posed on.

Used are: 2D marks of these keyframes, the camera, the preset that resembles the person, roughly
which way the person faces, and how people hold their limbs (`posing.HUMAN`, wide Gaussians about
joint angles). Not used are marks of other frames, other views, or any depth.

The product's solver (`tracker/solver`, the terms of `fit_joints.py` with those habits as prior)
poses every keyframe from several starts and keeps the likeliest pose, near the keyframe before
within a radian. Then lengths and poses are solved together (`tracker/fitting/sizes/shared.py`), the
preset's proportions the prior.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from bench.clips import Clip, place
from bench.keeping import ROOT, digest, place_for
from keypose.sample_videos.posing import HUMAN
from keypose.tracker.body.body import Body
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.fitting.sizes.proportions import Proportions
from keypose.tracker.fitting.sizes.shared import Residuals, Shared, SharedFit, solve
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.solver.fit_joints import NEAREST_M
from keypose.tracker.solver.least_squares import JOINTS, least_squares
from keypose.tracker.solver.one_pose import OnePose
from keypose.tracker.solver.pose_terms import JointLimits, PointsInPicture, PosePrior, RootPosition
from keypose.tracker.solver.posed import BodyPoint, BodyPoints, free_skeleton
from keypose.tracker.solver.sigmas import JOINT_PX, LIMIT_RAD
from keypose.tracker.solver.terms import Term

LENGTH_SHARE = 0.08
FIXED_SHARE = 1e-4
DISTANCE_SHARE = 0.1
"""Sigmas of the logarithms of lengths, of what marks do not show (thickness, lens), of distance."""
STEPS = 12
STARTS = 12
ASIDE_RAD = np.radians(25.0)
"""Poses that a keyframe is tried from, and how far they turn aside from where the person faces."""
TURN_RAD = 1.0
DEPTH_SHARE = 0.05
"""Sigmas of a part's turn and of the root's distance from one keyframe to the next."""
JITTER_RAD = np.radians(0.5)
JITTER_M = 0.003


@dataclass(frozen=True, eq=False)
class Keyed:
    """A body sized on the marks of keyframes, and its poses there."""

    skeleton: Skeleton
    poses: Mapping[int, Pose]


def keyed(clip: Clip, keyframes: Sequence[int]) -> Keyed:
    """The body sized and posed on the marks of these frames alone, or as kept of it."""
    here = Path(__file__).parent
    sources = [here / name for name in ("keyed.py", "clips.py", "real_marks.json")]
    used = ("sample_videos/posing.py", "tracker/body", "tracker/solver", "tracker/fitting/sizes")
    sources += [ROOT / name for name in used]
    name = "-".join(["keyed", clip.name, *map(str, keyframes)])
    kept = place_for(name, digest(*sources), ".npz")
    if not kept.is_file():
        found = _keyed(clip, keyframes)
        poses = [found.poses[frame] for frame in keyframes]
        np.savez(
            kept,
            body=found.skeleton.body.model_dump_json(),
            Rs=np.stack([pose.Rs_parent_part for pose in poses]),
            ps=np.stack([pose.p_camera_root for pose in poses]),
        )
    with np.load(kept) as known:
        skeleton = Skeleton.of(Body.model_validate_json(str(known["body"])))
        both = zip(keyframes, known["Rs"], known["ps"], strict=True)
        return Keyed(skeleton, {frame: Pose(R, p) for frame, R, p in both})


def _keyed(clip: Clip, keyframes: Sequence[int]) -> Keyed:
    ideal = clip.camera.without_distortion()
    marked = [_marked(clip, ideal, frame) for frame in keyframes]
    poses: list[Pose] = []
    for places, uv in marked:
        poses.append(_posed(clip, ideal, places, uv, poses[-1] if poses else None))
    skeleton, fitted = _sized(clip.body, ideal, marked, poses)
    return Keyed(skeleton, dict(zip(keyframes, fitted, strict=True)))


def jittered(skeleton: Skeleton, poses: Mapping[int, Pose], seed: int) -> dict[int, Pose]:
    """The poses disturbed as a hand would: each part turned by 0.5° and the root moved by 3 mm,
    standard deviations about and along every axis. A frame's disturbance is that of its seed."""
    return {frame: _jittered(skeleton, pose, (seed, frame)) for frame, pose in poses.items()}


def _jittered(skeleton: Skeleton, pose: Pose, seed: tuple[int, int]) -> Pose:
    rng = np.random.default_rng(seed)
    turns = rng.normal(0.0, JITTER_RAD, (skeleton.part_count, 3))
    shift = rng.normal(0.0, JITTER_M, 3)
    return Pose(pose.Rs_parent_part @ exp_rotation(turns), pose.p_camera_root + shift)


def _marked(clip: Clip, ideal: Camera, frame: int) -> tuple[list[BodyPoint], Array]:
    """Places and undistorted pixels (J, 2) of one frame's marks."""
    joints = clip.posed_on(frame)
    uv = np.array(list(joints.values()))
    return [place(clip.body, name) for name in joints], ideal.project(
        clip.camera.back_project(uv, 1.0)
    )


def _posed(
    clip: Clip, ideal: Camera, places: list[BodyPoint], uv: Array, before: Pose | None
) -> Pose:
    """The likeliest pose of one frame."""
    skeleton = free_skeleton(clip.body)
    points = BodyPoints(skeleton, tuple(places))
    usual, sigma = _habits(skeleton)
    precision = np.zeros(skeleton.dof_count)
    turns = (skeleton.dof_turns == 1) & (skeleton.dof_part > 0)
    precision[turns] = sigma[skeleton.dof_part, skeleton.dof_axis][turns] ** -2.0
    terms: list[Term] = [
        PointsInPicture(points, ideal, uv, np.full(len(uv), 1 / JOINT_PX), NEAREST_M),
        JointLimits(Limits.of(clip.body), LIMIT_RAD),
        PosePrior.of(Pose(usual, np.zeros(3)), precision),
    ]
    if before is not None:
        terms.append(PosePrior.of(before, np.where(skeleton.dof_turns == 1, TURN_RAD**-2.0, 0.0)))
        terms.append(RootPosition.depth(before.p_camera_root, DEPTH_SHARE))
    starts = [_start(clip, points, ideal, uv, (usual, sigma), seed) for seed in range(STARTS)]
    starts += [] if before is None else [before]
    problem = OnePose(skeleton, terms, floor=1.0)
    ends = [least_squares(problem, start, JOINTS) for start in starts]
    return min(ends, key=lambda end: end.cost).state


def _habits(skeleton: Skeleton) -> tuple[Array, Array]:
    """Rs_parent_part (P, 3, 3) as people usually hold their parts, and sigmas (P, 3) about x, y, z;
    turns about z and y are mirrored on the right."""
    Rs, sigma = np.tile(np.eye(3), (skeleton.part_count, 1, 1)), np.ones((skeleton.part_count, 3))
    for i, name in enumerate(skeleton.body.names[1:], start=1):
        usual, strays = HUMAN[name.removeprefix("left_").removeprefix("right_")]
        side = -1.0 if name.startswith("right_") else 1.0
        angles = np.array(usual) * (side, side, 1.0)
        Rs[i] = Rotation.from_euler("ZYX", angles, degrees=True).as_matrix()
        sigma[i] = np.radians(strays[::-1])
    return Rs, sigma


def _start(
    clip: Clip,
    points: BodyPoints,
    camera: Camera,
    uv: Array,
    habits: tuple[Array, Array],
    seed: int,
) -> Pose:
    """A pose drawn from the habits, facing about as known, where and as large as the marks are; the
    first one is usual in every way."""
    usual, sigma = habits
    draw = np.random.default_rng(seed).normal(size=(len(usual), 3)) * (seed > 0)
    Rs = usual @ exp_rotation(draw * sigma)
    Rs[0] = exp_rotation((0.0, np.radians(clip.facing_deg) + ASIDE_RAD * draw[0, 1], 0.0))
    rest = pose_transforms(points.skeleton, Pose.rest(points.skeleton, (0.0, 0.0, 0.0)))
    there = points.at(rest)
    depth = camera.fy * float(np.std(there[:, 1]) / np.std(uv[:, 1]))
    middle = points.at(pose_transforms(points.skeleton, Pose(Rs, np.zeros(3)))).mean(axis=0)
    return Pose(Rs, camera.back_project(uv.mean(axis=0), depth) - middle)


def _sized(
    body: Body, ideal: Camera, marked: Sequence[tuple[list[BodyPoint], Array]], poses: list[Pose]
) -> tuple[Skeleton, tuple[Pose, ...]]:
    """Lengths and poses together, the poses near where they are."""
    proportions = Proportions.of(body)
    free = np.ones(proportions.count + 2, dtype=np.bool_)
    free[1::2] = False  # thickness, and of the two last values the distance stays free
    free[-2:] = False, True
    share = np.where(free, LENGTH_SHARE, FIXED_SHARE)
    share[-1] = DISTANCE_SHARE
    limits = Limits.of(body).widened([pose.Rs_parent_part for pose in poses])
    rows = [_residuals(*frame) for frame in marked]
    one_focal = np.ones(len(poses))
    fit = SharedFit(proportions, ideal, tuple(poses), one_focal, limits, free, share, share)
    found = solve(fit, Shared(np.zeros(len(free)), tuple(poses)), rows, STEPS).shared
    return Skeleton.of(proportions.body_at(found.sizes)), found.poses


def _residuals(places: Sequence[BodyPoint], uv: Array) -> Residuals:
    """Two rows a mark, across and down."""
    points = [place[0] for place in places]
    return Residuals(
        parts=np.repeat([part for part, _ in points], 2),
        points=np.repeat(np.array([p for _, p in points]), 2, axis=0),
        normals=np.tile(np.eye(2), (len(uv), 1)),
        target=uv.ravel(),
        sigma_px=np.full(2 * len(uv), JOINT_PX),
    )
