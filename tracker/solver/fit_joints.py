"""The body fitted to joint positions, in space or in the picture: Levenberg–Marquardt on twists.

Bone lengths hold because only angles and the root's position are unknown. Joint limits are soft,
and so is the prior on the pose where the positions do not decide: the pose before, or that between
two keyframes. Every part may turn in every way here, as in a keyframe; see `free_skeleton`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, frozen, nearest_rotation
from keypose.tracker.solver.least_squares import JOINTS, least_squares
from keypose.tracker.solver.one_pose import OnePose
from keypose.tracker.solver.pose_terms import (
    JointLimits,
    PointsInPicture,
    PointsInSpace,
    PosePrior,
    RootPosition,
)
from keypose.tracker.solver.posed import BodyPoints, free_skeleton
from keypose.tracker.solver.sigmas import ANYWHERE, JOINT_M, JOINT_PX, LIMIT_RAD
from keypose.tracker.solver.terms import Term

if TYPE_CHECKING:
    from keypose.tracker.body.skeleton import Skeleton
    from keypose.tracker.solver.posed import BodyPoint

NEAREST_M = 0.05
POOR_M = 0.03
"""A frame fitted worse than this, and than the one before, is tried from a fresh start as well."""


@dataclass(frozen=True, eq=False)
class JointFit:
    """A motion fitted to joint positions.

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
    near: Sequence[Pose | None] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> JointFit:
    """The motion whose places come nearest to positions (N, J, 3), NaN where not known.

    near: a pose for each frame to stay near where the positions do not decide, or None.
    progress: receives how many frames of how many are done.
    """
    skeleton = free_skeleton(body)
    points, limits = BodyPoints(skeleton, tuple(places)), Limits.of(body)
    N = len(ps_camera_joint)
    R, t = np.empty((N, skeleton.part_count, 3, 3)), np.empty((N, 3))
    rms, converged = np.full(N, np.nan), np.zeros(N, dtype=np.bool_)
    before: Solved | None = None
    for n, positions in enumerate(ps_camera_joint):
        priors = [] if before is None else [before.pose]
        if near is not None and (pose := near[n]) is not None:
            priors.append(pose)
        before = _fit_frame(points, limits, positions, priors, rms[n - 1] if n else 0.0)
        R[n], t[n] = before.pose.Rs_parent_part, before.pose.p_camera_root
        rms[n], converged[n] = _rms(points, before.pose, positions), before.converged
        if progress is not None:
            progress(n + 1, N)
    return JointFit(Trajectory(first_frame, R, t), frozen(rms), converged)


def _fit_frame(
    points: BodyPoints, limits: Limits, positions: Array, priors: Sequence[Pose], rms_before: float
) -> Solved:
    """One frame: from the pose before, and afresh when that ends far from the positions."""
    skeleton = points.skeleton
    if not priors:
        priors = [aim_parts(points, positions, Pose.rest(skeleton, (0.0, 0.0, 0.0)))]
    is_known = np.asarray(np.isfinite(positions).all(-1))
    terms: list[Term] = [
        PointsInSpace(points.only(is_known), positions[is_known], JOINT_M),
        JointLimits(limits, LIMIT_RAD),
        *(_weak_prior(skeleton, pose) for pose in priors),
    ]
    solved = _solve(skeleton, priors[0], terms)
    if _rms(points, solved.pose, positions) > max(POOR_M, 1.5 * rms_before):
        fresh = _solve(skeleton, aim_parts(points, positions, priors[-1]), terms)
        solved = fresh if fresh.cost < solved.cost else solved
    return solved


def _weak_prior(skeleton: Skeleton, pose: Pose) -> PosePrior:
    """The pose where nothing else decides."""
    return PosePrior.of(pose, ANYWHERE.precision(skeleton))


def _solve(skeleton: Skeleton, start: Pose, terms: Sequence[Term]) -> Solved:
    solution = least_squares(OnePose(skeleton, terms, floor=1.0), start, JOINTS)
    return Solved(solution.state, solution.cost, solution.converged)


def _rms(points: BodyPoints, pose: Pose, positions: Array) -> float:
    away = points.at(pose_transforms(points.skeleton, pose)) - positions
    is_known = np.isfinite(away).all(-1)
    return float(np.sqrt((away[is_known] ** 2).sum(-1).mean())) if is_known.any() else np.nan


def aim_parts(points: BodyPoints, positions: Array, rest: Pose) -> Pose:
    """A start: every part, from the root on, turned so that its points lie toward theirs.

    Part by part in closed form; what a part's points do not fix is as in `rest`.
    """
    skeleton = points.skeleton
    Rs, p_root = rest.Rs_parent_part.copy(), rest.p_camera_root
    is_known = np.asarray(np.isfinite(positions).all(-1))
    Hs, os = np.empty_like(Rs), np.empty((skeleton.part_count, 3))
    for i, parent in enumerate(skeleton.parents):
        still = [(j, p) for j, p in points.of_part(i) if is_known[j]]
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
                wanted = _align(ours, theirs - os[i], wanted)
        Hs[i], Rs[i] = wanted, nearest_rotation(above.T @ wanted)
    return Pose(Rs, p_root)


def _align_root(ours: Array, theirs: Array, R: Array, p: Array) -> tuple[Array, Array]:
    """Rotation and position of the root; with fewer than three points, the least turn."""
    if not len(ours):
        return R, p
    middle, there = ours.mean(0), theirs.mean(0)
    R = _align(ours - middle, theirs - there, R)
    return R, there - R @ middle


def _align(ours: Array, theirs: Array, R: Array) -> Array:
    """The rotation that brings points to theirs; a little of R decides what they leave open."""
    spread = np.abs(ours).max(initial=0.0) * np.abs(theirs).max(initial=0.0)
    return nearest_rotation(theirs.T @ ours + (1e-3 * spread + 1e-9) * R)


def rigid(ps_from: Array, ps_to: Array) -> tuple[Array, Array]:
    """R (3, 3) and p (3,) with R x + p nearest to `ps_to` (M, 3) (Kabsch, 1976).

    Points of which one is NaN in either do not count.
    """
    is_known = np.isfinite(ps_from).all(-1) & np.isfinite(ps_to).all(-1)
    a, b = ps_from[is_known], ps_to[is_known]
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
    near: Pose | None = None,
    depth_sigma: float = 0.05,
) -> Solved:
    """The pose whose places come nearest to pixels (J, 2), NaN where not known; weights (J,).

    A picture leaves depth open: every start is tried and the best result is returned.
    near: a pose to stay near, its root's distance within a share `depth_sigma`.
    """
    skeleton = free_skeleton(body)
    points, limits = BodyPoints(skeleton, tuple(places)), Limits.of(body)
    ideal = camera.without_distortion()
    ideal_uv = ideal.project(camera.back_project(uv, 1.0)) if camera.is_distorted else uv
    is_known = np.isfinite(ideal_uv).all(-1) & (weights > 0)
    scale = np.sqrt(weights[is_known]) / JOINT_PX
    terms: list[Term] = [
        PointsInPicture(points.only(is_known), ideal, ideal_uv[is_known], scale, NEAREST_M),
        JointLimits(limits, LIMIT_RAD),
    ]
    if near is not None:
        terms.append(RootPosition.depth(near.p_camera_root, depth_sigma))
    ends = []
    for start in starts:
        prior = _weak_prior(skeleton, start if near is None else near)
        ends.append(_solve(skeleton, start, [*terms, prior]))
    return min(ends, key=lambda solved: solved.cost)
