"""Sizes that several poses share, and the poses, found together: Gauss–Newton on an arrow matrix.

Each pose has its own unknowns; the sizes, the focal length and how far away all of them are belong
to all. A longer lens shows the body as large from farther away, so distances grow along with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tracker.body.joint_limits import Limits
from tracker.body.pose import Pose, moved, part_transforms
from tracker.fitting.sizes.proportions import Proportions
from tracker.geometry.camera import Camera
from tracker.geometry.rotations import Array, log_rotation, transpose
from tracker.solver.least_squares import Criteria, Damping, Problem, least_squares
from tracker.solver.posed import Posed, image_jacobian
from tracker.solver.robust import Cauchy
from tracker.solver.terms import JointLimits

TURNS_RAD = np.radians([8.0, 15.0, 8.0])
SHIFT_M, DEPTH_SHARE = 0.015, 0.02
HEIGHT_SHARE = 0.02
"""How far a hand's pose may be off: turns about a part's x, y and z, the root across and along the
view. Turns out of the picture were used to make up for wrong lengths, so they are off by more than
a hand's own error; a twist, about y, is hard to see."""
LIMIT_RAD = np.radians(3.0)
KERNEL = Cauchy(2.0)
SMALL = 1e-4
CRITERIA = Criteria(most_tries=5, longest_step=0.2, gain=1e-3, damping=Damping(least=1e-6))
PIECE = 32


@dataclass(frozen=True, eq=False)
class Residuals:
    """M statements about one picture: `normals` (M, 2) times a point's pixel is `target` (M,).

    parts (M,); points (M, 3) in the parts' frames at sizes that change nothing, metres.
    sigma_px (M,): how far a statement may be off. A far outlier counts little.
    """

    parts: NDArray[np.int64]
    points: Array
    normals: Array
    target: Array
    sigma_px: Array

    def along(self, uv: Array) -> Array:
        """(M,) the pixels (M, 2) along the normals."""
        return np.asarray((self.normals * uv).sum(-1))

    @classmethod
    def joined(cls, some: Sequence[Residuals]) -> Residuals:
        """All of them."""
        names = ("parts", "points", "normals", "target", "sigma_px")
        return cls(
            *(np.concatenate([getattr(residuals, name) for residuals in some]) for name in names)
        )


@dataclass(frozen=True, eq=False)
class Shared:
    """What K pictures share, and a pose for each of them.

    values (S + 2,): logarithms of ratios: the sizes, the focal length, the distance of all poses.
    """

    values: Array
    poses: tuple[Pose, ...]

    @property
    def sizes(self) -> Array:
        """(S,)"""
        return self.values[:-2]

    @property
    def nearer(self) -> Array:
        """(3,) by which the root's place is multiplied: a longer lens stretches depth alone."""
        focal, distance = self.values[-2:]
        return np.exp([distance, distance, distance + focal])


@dataclass(frozen=True, eq=False)
class SharedFit:
    """What is fitted: the body, the camera, the poses as they were posed, and what stays fixed.

    free (S + 2,): which of the shared values may change; usual (S + 2,): by how much they may be
    off in general, share (S + 2,): and by how much here.
    """

    proportions: Proportions
    camera: Camera
    posed: tuple[Pose, ...]
    limits: Limits
    free: NDArray[np.bool_]
    usual: Array
    share: Array

    @property
    def precision(self) -> Array:
        """(S + 2, S + 2) how firmly each value is held, and how long the body is all in all.

        A larger body farther away looks the same, so that what was set as its height stays.
        """
        lengths = np.zeros(len(self.free))
        lengths[:-2:2] = 1 / len(self.proportions.groups)
        return np.diag(self.share**-2.0) + np.outer(lengths, lengths) / HEIGHT_SHARE**2

    def camera_at(self, shared: Shared) -> Camera:
        """The camera with the focal length found."""
        ratio = float(np.exp(shared.values[-2]))
        size = {"fx": self.camera.fx * ratio, "fy": self.camera.fy * ratio}
        return self.camera.model_copy(update=size)

    def transforms(self, shared: Shared, k: int) -> Array:
        """Ts_camera_part (P, 4, 4) in picture k."""
        pose = shared.poses[k]
        skeleton = self.proportions.skeleton_at(shared.sizes)
        return part_transforms(skeleton, pose.Rs_parent_part, pose.p_camera_root)

    def places(self, shared: Shared, k: int, residuals: Residuals) -> Array:
        """(M, 3) the points of the rows in the camera's frame."""
        T = self.transforms(shared, k)[residuals.parts]
        points = residuals.points * self.proportions.ratios(shared.sizes)[residuals.parts]
        return np.asarray((T[:, :3, :3] @ points[..., None])[..., 0] + T[:, :3, 3])

    def pixels(self, shared: Shared, k: int, residuals: Residuals) -> Array:
        """(M, 2) where the points of the rows are seen."""
        return self.camera_at(shared).project(self.places(shared, k, residuals))

    def changed(self, shared: Shared, step: Array) -> Shared:
        """The shared values changed by a step (S + 2,), and where the poses are along with it."""
        nearer = Shared(step, ()).nearer
        poses = (Pose(p.Rs_parent_part, p.p_camera_root * nearer) for p in shared.poses)
        return Shared(shared.values + step, tuple(poses))


@dataclass(frozen=True, eq=False)
class Solved:
    """What was found; spread (S + 2,): standard deviations of the shared values."""

    shared: Shared
    spread: Array


def solve(fit: SharedFit, start: Shared, rows: Sequence[Residuals], steps: int) -> Solved:
    """A few steps downhill from a start; one that makes things worse is shortened or not taken."""
    found = least_squares(_Pictures(fit, rows), start, replace(CRITERIA, most_steps=steps))
    last = found.solved
    spread = np.zeros(len(start.values)) if last is None else last.spread(found.damping)
    return Solved(found.state, spread)


@dataclass(frozen=True, eq=False)
class _Pictures(Problem[Shared, "_Point"]):
    """A step is that of what is shared (S + 2,), and then the motion (D,) of every pose."""

    fit: SharedFit
    rows: Sequence[Residuals]

    def at(self, state: Shared, count: int) -> _Point:
        return _Point(self.fit, state, self.rows)

    def moved(self, state: Shared, step: Array) -> Shared:
        sizes, motions = np.split(step, [len(state.values)])
        return _stepped(self.fit, state, sizes, motions.reshape(len(state.poses), -1))


@dataclass(frozen=True, eq=False)
class _Point:
    """What the pictures say of sizes and poses."""

    fit: SharedFit
    shared: Shared
    rows: Sequence[Residuals]

    @cached_property
    def cost(self) -> float:
        return _cost(self.fit, self.shared, self.rows)

    @cached_property
    def _blocks(self) -> list[Array]:
        return [_block(self.fit, self.shared, k, some) for k, some in enumerate(self.rows)]

    def step(self, damping: float) -> Array | None:
        A, b, shares = _eliminated(self.fit, self.shared, self._blocks, damping)
        return _arrow(self.fit.free, A, b, shares)

    def spread(self, damping: float) -> Array:
        """(S + 2,) standard deviations of what is shared."""
        A, _, _ = _eliminated(self.fit, self.shared, self._blocks, damping)
        return np.sqrt(np.maximum(np.diag(np.linalg.inv(A)), 0.0))


def _stepped(fit: SharedFit, shared: Shared, step: Array, motions: Array) -> Shared:
    skeleton = fit.proportions.skeleton
    poses = tuple(moved(skeleton, p, x) for p, x in zip(shared.poses, motions, strict=True))
    return fit.changed(replace(shared, poses=poses), step)


def _block(fit: SharedFit, shared: Shared, k: int, residuals: Residuals) -> Array:
    """(D + S + 3, D + S + 3) JᵀJ of one picture over its pose, what is shared, the residual."""
    dofs, sizes = fit.proportions.skeleton.dof_count, len(fit.free)
    r, J_pose = _prior_residuals(fit, shared, k)
    there = fit.pixels(shared, k, residuals)
    away = (residuals.along(there) - residuals.target) / residuals.sigma_px
    weight = np.sqrt(KERNEL.weight(away))
    J = np.zeros((len(r) + len(away), dofs + sizes + 1))
    J[: len(r), :dofs], J[: len(r), -1] = J_pose, r
    told = J[len(r) :]
    told[:, :dofs] = _pose_slopes(fit, shared, k, residuals)
    told[:, dofs:-1] = _size_slopes(fit, shared, k, residuals, there)
    told[:, :-1] *= (weight / residuals.sigma_px)[:, None]
    told[:, -1] = away * weight
    return _products(J)


def _products(J: Array) -> Array:
    """JᵀJ in small pieces: a large product would be shared out to threads, which costs more than
    it saves beside other work."""
    padded = np.zeros((-(-len(J) // PIECE), PIECE, J.shape[1]))
    padded.reshape(-1, J.shape[1])[: len(J)] = J
    return np.asarray((np.swapaxes(padded, 1, 2).copy() @ padded).sum(axis=0))


def _eliminated(
    fit: SharedFit, shared: Shared, blocks: Sequence[Array], damping: float
) -> tuple[Array, Array, list[Array]]:
    """Equations of what is shared alone, and every pose's share in its motion (D, S + 3)."""
    dofs, A = fit.proportions.skeleton.dof_count, fit.precision
    b = A @ shared.values
    shares: list[Array] = []
    for block in blocks:
        pose, mixed, rest = block[:dofs, :dofs], block[:dofs, dofs:], block[dofs:-1, dofs:]
        share = np.asarray(np.linalg.solve(pose + damping * np.diag(np.diag(pose)), mixed), float)
        less = rest - mixed[:, :-1].T @ share
        A, b = A + less[:, :-1], b + less[:, -1]
        shares.append(share)
    return A, b, shares


def _arrow(free: NDArray[np.bool_], A: Array, b: Array, shares: Sequence[Array]) -> Array:
    """The step of what is shared, and the motions of all poses that follow from it."""
    step = np.where(free, -np.linalg.solve(A, b), 0.0)
    if not free.all():
        step[free] = -np.linalg.solve(A[np.ix_(free, free)], b[free])
    return np.concatenate([step, *(-share[:, -1] - share[:, :-1] @ step for share in shares)])


def _cost(fit: SharedFit, shared: Shared, rows: Sequence[Residuals]) -> float:
    """Half the sum of squares, those of the rows robust; infinite behind the camera."""
    total = shared.values @ fit.precision @ shared.values
    for k, some in enumerate(rows):
        r, _ = _prior_residuals(fit, shared, k)
        away = (some.along(fit.pixels(shared, k, some)) - some.target) / some.sigma_px
        if not np.isfinite(away).all():
            return np.inf
        total += (r**2).sum() + KERNEL.loss(away).sum()
    return 0.5 * float(total)


def _pose_slopes(fit: SharedFit, shared: Shared, k: int, residuals: Residuals) -> Array:
    """(M, D) how the rows change with small motions of the pose."""
    pose, skeleton = shared.poses[k], fit.proportions.skeleton_at(shared.sizes)
    p = fit.places(shared, k, residuals)
    J = Posed.of(skeleton, pose).point_jacobian(residuals.parts, p)
    uv = image_jacobian(fit.camera_at(shared), p, J)
    return np.asarray(np.einsum("mdc,mc->md", uv, residuals.normals))


def _size_slopes(
    fit: SharedFit, shared: Shared, k: int, residuals: Residuals, there: Array
) -> Array:
    """(M, S + 2) how they change with what is shared, by small differences."""
    slopes = np.zeros((len(residuals.parts), len(fit.free)))
    for s in np.flatnonzero(fit.free):
        step = np.zeros(len(fit.free))
        step[s] = SMALL
        beside = fit.pixels(fit.changed(shared, step), k, residuals)
        slopes[:, s] = residuals.along(beside - there) / SMALL
    return slopes


def _prior_residuals(fit: SharedFit, shared: Shared, k: int) -> tuple[Array, Array]:
    """Residuals and slopes (…, D) of staying near what was posed, and within the joints' limits."""
    skeleton, pose, posed = fit.proportions.skeleton, shared.poses[k], fit.posed[k]
    turns = np.flatnonzero(skeleton.dof_turns == 1)
    part, axis = skeleton.dof_part[turns], skeleton.dof_axis[turns]
    turn = log_rotation(transpose(posed.Rs_parent_part) @ pose.Rs_parent_part)
    sigma = TURNS_RAD[axis]
    r_turn = turn[part, axis] / sigma
    J_turn = np.zeros((len(turns), skeleton.dof_count))
    J_turn[np.arange(len(turns)), turns] = 1 / sigma
    r_shift, along = _shifted(fit, shared, pose.p_camera_root, posed.p_camera_root)
    J_shift = np.zeros((3, skeleton.dof_count))
    shifts = np.flatnonzero(skeleton.dof_turns == 0)
    J_shift[:, shifts] = along @ pose.Rs_parent_part[0][:, skeleton.dof_axis[shifts]]
    limits = JointLimits(fit.limits, LIMIT_RAD).rows(Posed.of(skeleton, pose))
    r = np.concatenate([r_turn, r_shift, limits.r])
    return r, np.concatenate([J_turn, J_shift, limits.J])


def _shifted(fit: SharedFit, shared: Shared, p: Array, p_posed: Array) -> tuple[Array, Array]:
    """(3,) how far the root has left where it was posed, and how that changes with its place.

    Across the view it is compared along the ray on which it was posed: nearer or farther is free.
    """
    p_posed = p_posed * shared.nearer
    along = np.eye(3)
    if fit.camera.projection == "perspective":
        along[:2, 2] = -p_posed[:2] / p_posed[2]
    sigma = np.array([SHIFT_M, SHIFT_M, DEPTH_SHARE * p_posed[2]])
    return along @ (p - p_posed) / sigma, along / sigma[:, None]
