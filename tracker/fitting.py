"""The body laid into joint positions, in space or in the picture: Levenberg–Marquardt on twists.

Bone lengths hold because only angles and the root's place are unknown. Joint limits hold softly,
and so does a pose to keep to where the positions say nothing: the pose before, or that between two
keyframes. Every part may turn in every way here, as in a keyframe; see `freed`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tracker.body import ALL_DOFS, ROTATIONS, Body
from tracker.camera import Camera
from tracker.geometry import Array, frozen, log_rotation, nearest_rotation, transpose
from tracker.limits import Limits
from tracker.pose import Pose, moved, pose_transforms, twists
from tracker.skeleton import Skeleton
from tracker.trajectory import Trajectory

if TYPE_CHECKING:
    from tracker.evaluate import Place

JOINT_SIGMA_M = 0.005
PIXEL_SIGMA = 2.0
LIMIT_SIGMA_RAD = np.radians(2.0)
KEEP_SIGMA_RAD, KEEP_SIGMA_M = np.radians(180.0), 30.0
"""What one standard deviation is of a joint, a keypoint, an angle past its limit, and of a pose
that is kept to where nothing else decides."""
POOR_M = 0.03
"""A frame fitted worse than this, and than the one before, is tried from a fresh start as well."""
MOST_STEPS, STOP, GAIN, LONGEST_STEP = 120, 1e-6, 1e-5, 0.5
"""Steps at most; the step (radians or metres) or the gain that ends them; and the longest step."""

Rows: TypeAlias = Callable[[Pose], tuple[Array, Array]]
"""Residuals (M,) at a pose, in standard deviations, and their slopes (M, D)."""


@dataclass(frozen=True, eq=False)
class Solved:
    """A pose found, half the sum of squares there, and whether the steps came to rest."""

    pose: Pose
    cost: float
    converged: bool


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
class Places:
    """Where on a body the given positions are, laid out for the numerics."""

    skeleton: Skeleton
    places: tuple[Place, ...]

    @cached_property
    def _points(self) -> tuple[NDArray[np.int64], Array, Array]:
        """Part (K,) and position (K, 3) of every point, and the mean (J, K) over them."""
        flat = [(j, *point) for j, place in enumerate(self.places) for point in place]
        mean = np.zeros((len(self.places), len(flat)))
        for k, (j, _, _) in enumerate(flat):
            mean[j, k] = 1 / len(self.places[j])
        parts = np.array([part for _, part, _ in flat], dtype=np.int64)
        return parts, np.array([p for _, _, p in flat], dtype=np.float64).reshape(-1, 3), mean

    def at(self, Ts_camera_part: Array) -> Array:
        """Positions (..., J, 3) in the camera frame."""
        parts, p, mean = self._points
        T = Ts_camera_part[..., parts, :, :]
        return np.asarray(mean @ ((T[..., :3, :3] @ p[..., None])[..., 0] + T[..., :3, 3]))

    def moving(self, Ts_camera_part: Array) -> tuple[Array, Array]:
        """Positions (J, 3) of one pose and their slopes (J, 3, D)."""
        parts, p, mean = self._points
        T = Ts_camera_part[parts]
        points: Array = (T[:, :3, :3] @ p[..., None])[..., 0] + T[:, :3, 3]
        S = twists(self.skeleton, Ts_camera_part)
        slopes = S[None, :, :3] + np.cross(S[None, :, 3:], points[:, None, :])
        slopes *= self.skeleton.below[parts][:, self.skeleton.dof_part][..., None]
        return mean @ points, np.tensordot(mean, np.swapaxes(slopes, 1, 2), axes=1)

    def of_part(self, part: int) -> list[tuple[int, Array]]:
        """Single points that stand still in a part's frame, with their place there: its own, and
        the joints of what hangs on it."""
        still = []
        for j, place in enumerate(self.places):
            if len(place) == 1:
                owner, p = place[0]
                if owner == part:
                    still.append((j, np.array(p)))
                elif self.skeleton.parents[owner] == part and not np.any(p):
                    still.append((j, self.skeleton.joints[owner]))
        return still


def freed(body: Body) -> Skeleton:
    """The body with every part free to turn in every way."""
    parts = (
        part.model_copy(update={"tracked": ROTATIONS if part.parent else ALL_DOFS})
        for part in body.parts
    )
    return Skeleton.of(body.model_copy(update={"parts": tuple(parts)}))


def fit_motion(
    body: Body,
    places: Sequence[Place],
    ps_camera_joint: Array,
    first_frame: int,
    kept: Sequence[Pose | None] | None = None,
) -> Fit:
    """The motion whose places come nearest to positions (N, J, 3), NaN where not known.

    kept: a pose for each frame to keep to where the positions say nothing, or None.
    """
    skeleton = freed(body)
    laid, limits = Places(skeleton, tuple(places)), Limits.of(body)
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
    laid: Places, limits: Limits, positions: Array, held: Sequence[Pose], rms_before: float
) -> Solved:
    """One frame: from the pose before, and afresh when that ends far from the positions."""
    skeleton = laid.skeleton
    if not held:
        held = [aimed(laid, positions, Pose.rest(skeleton, (0.0, 0.0, 0.0)))]
    rows = _together(
        [_joint_rows(laid, positions), _limit_rows(skeleton, limits)]
        + [_keep_rows(skeleton, pose) for pose in held]
    )
    solved = solve(skeleton, held[0], rows)
    if _rms(laid, solved.pose, positions) > max(POOR_M, 1.5 * rms_before):
        fresh = solve(skeleton, aimed(laid, positions, held[-1]), rows)
        solved = fresh if fresh.cost < solved.cost else solved
    return solved


def _rms(laid: Places, pose: Pose, positions: Array) -> float:
    away = laid.at(pose_transforms(laid.skeleton, pose)) - positions
    known = np.isfinite(away).all(-1)
    return float(np.sqrt((away[known] ** 2).sum(-1).mean())) if known.any() else np.nan


def aimed(laid: Places, positions: Array, rest: Pose) -> Pose:
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
            wanted, p_root = _laid_on(ours, theirs, wanted, p_root)
            os[i] = p_root
        else:
            os[i] = os[parent] + above @ skeleton.joints[i]
            if len(still):
                wanted = _turned_to(ours, theirs - os[i], wanted)
        Hs[i], Rs[i] = wanted, nearest_rotation(above.T @ wanted)
    return Pose(Rs, p_root)


def _laid_on(ours: Array, theirs: Array, R: Array, p: Array) -> tuple[Array, Array]:
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
    places: Sequence[Place],
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
    skeleton = freed(body)
    laid, limits = Places(skeleton, tuple(places)), Limits.of(body)
    ideal = camera.without_distortion()
    seen = ideal.project(_before(camera, uv)) if camera.is_distorted else uv
    rows = [_pixel_rows(laid, ideal, seen, weights), _limit_rows(skeleton, limits)]
    ends = []
    for start in starts:
        held = [_keep_rows(skeleton, kept if kept is not None else start)]
        if kept is not None:
            held.append(_depth_rows(skeleton, kept, depth_sigma))
        ends.append(solve(skeleton, start, _together(rows + held)))
    return min(ends, key=lambda solved: solved.cost)


def _before(camera: Camera, uv: Array) -> Array:
    """Points before the camera that are seen at the pixels."""
    return camera.back_project(uv, 1.0)


# --- rows


def solve(skeleton: Skeleton, start: Pose, rows: Rows) -> Solved:
    """Levenberg–Marquardt from a start; a step that makes things worse is not taken."""
    pose, damping = start, 1e-3
    r, J = rows(pose)
    cost = 0.5 * float(r @ r)
    if not np.isfinite(cost):
        return Solved(start, np.inf, False)
    for _ in range(MOST_STEPS):
        A, b = J.T @ J, J.T @ r
        while True:
            step = np.asarray(-np.linalg.solve(A + damping * np.diag(np.diag(A) + 1.0), b), float)
            step *= min(1.0, LONGEST_STEP / max(float(np.abs(step).max()), 1e-12))
            if np.abs(step).max() < STOP:
                return Solved(pose, cost, True)
            there = moved(skeleton, pose, step)
            r_there, J_there = rows(there)
            cost_there = 0.5 * float(r_there @ r_there)
            if np.isfinite(cost_there) and cost_there < cost:
                break
            damping *= 10
            if damping > 1e10:
                return Solved(pose, cost, True)
        gained = cost - cost_there
        pose, r, J, cost, damping = there, r_there, J_there, cost_there, max(damping / 10, 1e-9)
        if gained < GAIN * (cost + 1.0):
            return Solved(pose, cost, True)
    return Solved(pose, cost, False)


def _together(rows: Sequence[Rows]) -> Rows:
    def all_of_them(pose: Pose) -> tuple[Array, Array]:
        pairs = [row(pose) for row in rows]
        return np.concatenate([r for r, _ in pairs]), np.concatenate([J for _, J in pairs])

    return all_of_them


def _joint_rows(laid: Places, positions: Array) -> Rows:
    known = np.isfinite(positions).all(-1)

    def rows(pose: Pose) -> tuple[Array, Array]:
        p, J = laid.moving(pose_transforms(laid.skeleton, pose))
        away, J = (p - positions)[known], J[known]
        return away.ravel() / JOINT_SIGMA_M, J.reshape(-1, J.shape[-1]) / JOINT_SIGMA_M

    return rows


def _pixel_rows(laid: Places, camera: Camera, uv: Array, weights: Array) -> Rows:
    known = np.isfinite(uv).all(-1) & (weights > 0)
    scale = np.sqrt(weights[known])[:, None] / PIXEL_SIGMA
    f = np.array([camera.fx, camera.fy])

    def rows(pose: Pose) -> tuple[Array, Array]:
        p, J = laid.moving(pose_transforms(laid.skeleton, pose))
        p, J = p[known], J[known]
        if (p[:, 2] < 0.05).any():  # behind the camera: no pose to go to
            return np.array([np.inf]), np.zeros((1, J.shape[-1]))
        z = camera.depth(p)[:, None]
        away = f * p[:, :2] / z + (camera.cx, camera.cy) - uv[known]
        slope = J[:, :2] / z[..., None]
        if camera.projection == "perspective":
            slope = slope - (p[:, :2] / z**2)[..., None] * J[:, 2:]
        slope = slope * (scale * f)[..., None]
        return (away * scale).ravel(), slope.reshape(-1, J.shape[-1])

    return rows


def _limit_rows(skeleton: Skeleton, limits: Limits) -> Rows:
    turns = np.flatnonzero(skeleton.dof_turns == 1)
    parts, axes = skeleton.dof_part[turns], skeleton.dof_axis[turns]

    def rows(pose: Pose) -> tuple[Array, Array]:
        outside, slopes = limits.excess(pose.Rs_parent_part)
        over = outside != 0
        J = np.zeros((skeleton.part_count, 3, skeleton.dof_count))
        J[parts, :, turns] = slopes[parts, :, axes]
        return outside[over] / LIMIT_SIGMA_RAD, J[over] / LIMIT_SIGMA_RAD

    return rows


def _keep_rows(skeleton: Skeleton, held: Pose) -> Rows:
    turns = skeleton.dof_turns == 1
    sigma = np.where(turns, KEEP_SIGMA_RAD, KEEP_SIGMA_M)

    def rows(pose: Pose) -> tuple[Array, Array]:
        turn = log_rotation(transpose(held.Rs_parent_part) @ pose.Rs_parent_part)
        shift = pose.Rs_parent_part[0].T @ (pose.p_camera_root - held.p_camera_root)
        part, axis = skeleton.dof_part, skeleton.dof_axis
        away = np.where(turns, turn[part, axis], shift[axis])
        return away / sigma, np.diag(1 / sigma)

    return rows


def _depth_rows(skeleton: Skeleton, held: Pose, sigma: float) -> Rows:
    """The root's distance held to within a share of it."""
    shifts, z = skeleton.dof_turns == 0, held.p_camera_root[2]

    def rows(pose: Pose) -> tuple[Array, Array]:
        J = np.zeros((1, skeleton.dof_count))
        J[0, shifts] = pose.Rs_parent_part[0][2, skeleton.dof_axis[shifts]] / (sigma * z)
        return np.array([(pose.p_camera_root[2] - z) / (sigma * z)]), J

    return rows
