"""The body laid into joint positions, in space or in the picture: Levenberg–Marquardt on twists.

Bone lengths hold because only angles and the root's place are unknown. Joint limits hold softly,
and so does a pose to keep to where the positions say nothing: the pose before, or that between two
keyframes. Every part may turn in every way here, as in a keyframe; see `free_skeleton`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tracker.body.body import Body
from tracker.body.joint_limits import Limits
from tracker.body.pose import Pose, pose_transforms
from tracker.body.trajectory import Trajectory
from tracker.geometry.camera import Camera
from tracker.geometry.rotations import Array, frozen, nearest_rotation
from tracker.solver.body_points import BodyPoints, free_skeleton
from tracker.solver.least_squares import Criteria, Damping, least_squares
from tracker.solver.one_pose import OnePose
from tracker.solver.terms import (
    JointLimits,
    PointsInPicture,
    PointsInSpace,
    PosePrior,
    RootPosition,
    Term,
)

if TYPE_CHECKING:
    from tracker.body.skeleton import Skeleton
    from tracker.solver.body_points import BodyPoint

JOINT_SIGMA_M = 0.005
PIXEL_SIGMA = 2.0
LIMIT_SIGMA_RAD = np.radians(2.0)
KEEP_SIGMA_RAD, KEEP_SIGMA_M = np.radians(180.0), 30.0
"""What one standard deviation is of a joint, a keypoint, an angle past its limit, and of a pose
that is kept to where nothing else decides."""
NEAREST_M = 0.05
CRITERIA = Criteria(
    most_steps=120,
    longest_step=0.5,
    negligible=1e-6,
    gain=1e-5,
    gain_floor=1.0,
    damping=Damping(least=1e-9, most=1e10),
)
POOR_M = 0.03
"""A frame fitted worse than this, and than the one before, is tried from a fresh start as well."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A motion laid into joint positions.

    rms_m:     (N,) root mean square distance of the joints at each frame, NaN where none is given.
    converged: (N,) whether the steps came to rest there.
    """

    trajectory: Trajectory
    rms_m: Array
    converged: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Solved:
    """A pose found, half the sum of squares there, and whether the steps came to rest."""

    pose: Pose
    cost: float
    converged: bool


def fit_motion(
    body: Body,
    places: Sequence[BodyPoint],
    ps_camera_joint: Array,
    first_frame: int,
    kept: Sequence[Pose | None] | None = None,
) -> Fit:
    """The motion whose places come nearest to positions (N, J, 3), NaN where not known.

    kept: a pose for each frame to keep to where the positions say nothing, or None.
    """
    skeleton = free_skeleton(body)
    laid, limits = BodyPoints(skeleton, tuple(places)), Limits.of(body)
    N = len(ps_camera_joint)
    R, t = np.empty((N, skeleton.part_count, 3, 3)), np.empty((N, 3))
    rms, rested = np.full(N, np.nan), np.zeros(N, dtype=np.bool_)
    before: Solved | None = None
    for n, positions in enumerate(ps_camera_joint):
        held = [] if before is None else [before.pose]
        if kept is not None and (pose := kept[n]) is not None:
            held.append(pose)
        before = _fitted(laid, limits, positions, held, rms[n - 1] if n else 0.0)
        R[n], t[n] = before.pose.Rs_parent_part, before.pose.p_camera_root
        rms[n], rested[n] = _rms(laid, before.pose, positions), before.converged
    return Fit(Trajectory(first_frame, R, t), frozen(rms), rested)


def _fitted(
    laid: BodyPoints, limits: Limits, positions: Array, held: Sequence[Pose], rms_before: float
) -> Solved:
    """One frame: from the pose before, and afresh when that ends far from the positions."""
    skeleton = laid.skeleton
    if not held:
        held = [aim_parts(laid, positions, Pose.rest(skeleton, (0.0, 0.0, 0.0)))]
    known = np.asarray(np.isfinite(positions).all(-1))
    terms: list[Term] = [
        PointsInSpace(laid.only(known), positions[known], JOINT_SIGMA_M),
        JointLimits(limits, LIMIT_SIGMA_RAD),
        *(_weak_prior(skeleton, pose) for pose in held),
    ]
    solved = _solved(skeleton, held[0], terms)
    if _rms(laid, solved.pose, positions) > max(POOR_M, 1.5 * rms_before):
        fresh = _solved(skeleton, aim_parts(laid, positions, held[-1]), terms)
        solved = fresh if fresh.cost < solved.cost else solved
    return solved


def _weak_prior(skeleton: Skeleton, pose: Pose) -> PosePrior:
    """The pose where nothing else decides."""
    sigma = np.where(skeleton.dof_turns == 1, KEEP_SIGMA_RAD, KEEP_SIGMA_M)
    return PosePrior.of(pose, sigma**-2.0)


def _solved(skeleton: Skeleton, start: Pose, terms: Sequence[Term]) -> Solved:
    found = least_squares(OnePose(skeleton, terms, floor=1.0), start, CRITERIA)
    return Solved(found.state, found.cost, found.converged)


def _rms(laid: BodyPoints, pose: Pose, positions: Array) -> float:
    away = laid.at(pose_transforms(laid.skeleton, pose)) - positions
    known = np.isfinite(away).all(-1)
    return float(np.sqrt((away[known] ** 2).sum(-1).mean())) if known.any() else np.nan


def aim_parts(laid: BodyPoints, positions: Array, rest: Pose) -> Pose:
    """A start: every part, from the root on, turned so that its points lie toward theirs.

    Part by part in closed form; what a part's points do not fix is as in `rest`.
    """
    skeleton = laid.skeleton
    Rs, p_root = rest.Rs_parent_part.copy(), rest.p_camera_root
    known = np.asarray(np.isfinite(positions).all(-1))
    Hs, os = np.empty_like(Rs), np.empty((skeleton.part_count, 3))
    for i, parent in enumerate(skeleton.parents):
        still = [(j, p) for j, p in laid.of_part(i) if known[j]]
        theirs = np.array([positions[j] for j, _ in still]).reshape(-1, 3)
        ours = np.array([p for _, p in still]).reshape(-1, 3)
        above = np.eye(3) if parent < 0 else Hs[parent]
        wanted = above @ Rs[i]
        if parent < 0:
            wanted, p_root = _align_root(ours, theirs, wanted, p_root)
            os[i] = p_root
        else:
            os[i] = os[parent] + above @ skeleton.joints[i]
            if len(still):
                wanted = _turned_to(ours, theirs - os[i], wanted)
        Hs[i], Rs[i] = wanted, nearest_rotation(above.T @ wanted)
    return Pose(Rs, p_root)


def _align_root(ours: Array, theirs: Array, R: Array, p: Array) -> tuple[Array, Array]:
    """Rotation and place of the root: with fewer than three points, as little turned as may be."""
    if not len(ours):
        return R, p
    middle, there = ours.mean(0), theirs.mean(0)
    R = _turned_to(ours - middle, theirs - there, R)
    return R, there - R @ middle


def _turned_to(ours: Array, theirs: Array, R: Array) -> Array:
    """The rotation that brings points to theirs, held a little to R, which decides what is left."""
    spread = np.abs(ours).max(initial=0.0) * np.abs(theirs).max(initial=0.0)
    return nearest_rotation(theirs.T @ ours + (1e-3 * spread + 1e-9) * R)


def rigid(ps_from: Array, ps_to: Array) -> tuple[Array, Array]:
    """R (3, 3) and p (3,) with R x + p nearest to `ps_to` (M, 3) (Kabsch, 1976).

    Points of which one is NaN in either do not count.
    """
    known = np.isfinite(ps_from).all(-1) & np.isfinite(ps_to).all(-1)
    a, b = ps_from[known], ps_to[known]
    R = nearest_rotation((b - b.mean(0)).T @ (a - a.mean(0)))
    return R, b.mean(0) - R @ a.mean(0)


# --- in the picture


def fit_picture(
    body: Body,
    camera: Camera,
    places: Sequence[BodyPoint],
    uv: Array,
    weights: Array,
    starts: Sequence[Pose],
    kept: Pose | None = None,
    depth_sigma: float = 0.05,
) -> Solved:
    """The pose whose places come nearest to pixels (J, 2), NaN where not known; weights (J,).

    A picture leaves depth open: every start is tried, and the best of their ends is kept.
    kept: a pose to keep to, its root's distance within a share `depth_sigma`.
    """
    skeleton = free_skeleton(body)
    laid, limits = BodyPoints(skeleton, tuple(places)), Limits.of(body)
    ideal = camera.without_distortion()
    seen = ideal.project(_before(camera, uv)) if camera.is_distorted else uv
    known = np.isfinite(seen).all(-1) & (weights > 0)
    scale = np.sqrt(weights[known]) / PIXEL_SIGMA
    terms: list[Term] = [
        PointsInPicture(laid.only(known), ideal, seen[known], scale, NEAREST_M),
        JointLimits(limits, LIMIT_SIGMA_RAD),
    ]
    if kept is not None:
        terms.append(RootPosition.depth(kept.p_camera_root, depth_sigma))
    ends = []
    for start in starts:
        prior = _weak_prior(skeleton, start if kept is None else kept)
        ends.append(_solved(skeleton, start, [*terms, prior]))
    return min(ends, key=lambda solved: solved.cost)


def _before(camera: Camera, uv: Array) -> Array:
    """Points before the camera that are seen at the pixels."""
    return camera.back_project(uv, 1.0)
