"""What a pose is held to, as residuals with their slopes, and Levenberg–Marquardt on them.

Each residual is in standard deviations, so that rows of different kinds can be put together.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from tracker.body.joint_limits import Limits
from tracker.body.pose import Pose, moved, pose_transforms
from tracker.body.skeleton import Skeleton
from tracker.geometry.camera import Camera
from tracker.geometry.rotations import Array, log_rotation, transpose
from tracker.solver.body_points import Places

JOINT_SIGMA_M = 0.005
PIXEL_SIGMA = 2.0
LIMIT_SIGMA_RAD = np.radians(2.0)
KEEP_SIGMA_RAD, KEEP_SIGMA_M = np.radians(180.0), 30.0
"""What one standard deviation is of a joint, a keypoint, an angle past its limit, and of a pose
that is kept to where nothing else decides."""
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


def together(rows: Sequence[Rows]) -> Rows:
    """Several kinds of rows as one."""

    def all_of_them(pose: Pose) -> tuple[Array, Array]:
        pairs = [row(pose) for row in rows]
        return np.concatenate([r for r, _ in pairs]), np.concatenate([J for _, J in pairs])

    return all_of_them


def joint_rows(laid: Places, positions: Array) -> Rows:
    """Places at positions (J, 3), NaN where not known, camera frame, metres."""
    known = np.isfinite(positions).all(-1)

    def rows(pose: Pose) -> tuple[Array, Array]:
        p, J = laid.moving(pose_transforms(laid.skeleton, pose))
        away, J = (p - positions)[known], J[known]
        return away.ravel() / JOINT_SIGMA_M, J.reshape(-1, J.shape[-1]) / JOINT_SIGMA_M

    return rows


def pixel_rows(laid: Places, camera: Camera, uv: Array, weights: Array) -> Rows:
    """Places seen at pixels (J, 2), NaN where not known; weights (J,)."""
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


def limit_rows(skeleton: Skeleton, limits: Limits) -> Rows:
    """Joint angles within their limits."""
    turns = np.flatnonzero(skeleton.dof_turns == 1)
    parts, axes = skeleton.dof_part[turns], skeleton.dof_axis[turns]

    def rows(pose: Pose) -> tuple[Array, Array]:
        outside, slopes = limits.excess(pose.Rs_parent_part)
        over = outside != 0
        J = np.zeros((skeleton.part_count, 3, skeleton.dof_count))
        J[parts, :, turns] = slopes[parts, :, axes]
        return outside[over] / LIMIT_SIGMA_RAD, J[over] / LIMIT_SIGMA_RAD

    return rows


def keep_rows(skeleton: Skeleton, held: Pose) -> Rows:
    """The pose as `held`, weakly."""
    turns = skeleton.dof_turns == 1
    sigma = np.where(turns, KEEP_SIGMA_RAD, KEEP_SIGMA_M)

    def rows(pose: Pose) -> tuple[Array, Array]:
        turn = log_rotation(transpose(held.Rs_parent_part) @ pose.Rs_parent_part)
        shift = pose.Rs_parent_part[0].T @ (pose.p_camera_root - held.p_camera_root)
        part, axis = skeleton.dof_part, skeleton.dof_axis
        away = np.where(turns, turn[part, axis], shift[axis])
        return away / sigma, np.diag(1 / sigma)

    return rows


def depth_rows(skeleton: Skeleton, held: Pose, sigma: float) -> Rows:
    """The root's distance held to within a share of it."""
    shifts, z = skeleton.dof_turns == 0, held.p_camera_root[2]

    def rows(pose: Pose) -> tuple[Array, Array]:
        J = np.zeros((1, skeleton.dof_count))
        J[0, shifts] = pose.Rs_parent_part[0][2, skeleton.dof_axis[shifts]] / (sigma * z)
        return np.array([(pose.p_camera_root[2] - z) / (sigma * z)]), J

    return rows
