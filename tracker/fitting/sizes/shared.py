"""Sizes that several poses share, and the poses, found together: Gauss–Newton on an arrow matrix.

Each pose has its own unknowns; the sizes, the focal length and how far away all of them are belong
to all. A longer lens shows the body as large from farther away, so distances grow along with it.

Other films of the same poses are compared with where their keypoints are. How far their cameras
stand from the first one's is unknown too, as a multiple of what it was taken to be: bodies, places
and distances between cameras that are all larger by one share look the same in every film.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose, moved, part_transforms
from keypose.tracker.fitting.sizes.proportions import Proportions
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.least_squares import USUAL, Problem, least_squares
from keypose.tracker.solver.pose_terms import JointLimits, PosePrior, RootPosition
from keypose.tracker.solver.posed import Posed, points_on_parts
from keypose.tracker.solver.projection import image_jacobian
from keypose.tracker.solver.robust import Cauchy
from keypose.tracker.solver.sigmas import (
    HEIGHT_SHARE,
    LIMIT_RAD,
    POSED_DEPTH_SHARE,
    POSED_SHIFT_M,
    TRUNK_RAD,
    TURNS_RAD,
)
from keypose.tracker.solver.terms import Term, total_cost, total_equations

KERNEL = Cauchy(2.0)
SMALL = 1e-4
PIECE = 32


@dataclass(frozen=True, eq=False)
class Residuals:
    """M residuals in one picture: `normals` (M, 2) times a point's pixel is `target` (M,).

    parts (M,); points (M, 3) in the parts' frames at sizes that change nothing, metres.
    sigma_px (M,): of each. A far outlier counts little.
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
    def concatenate(cls, pieces: Sequence[Residuals]) -> Residuals:
        """All of them."""
        names = ("parts", "points", "normals", "target", "sigma_px")
        return cls(
            *(np.concatenate([getattr(residuals, name) for residuals in pieces]) for name in names)
        )


@dataclass(frozen=True, eq=False)
class FilmOfPose:
    """Another film than the first as it took the moment of a pose.

    camera: without distortion.  T_film_first (4, 4): from the first camera's frame to this one's.
    """

    camera: Camera
    T_film_first: Array

    def before_camera(self, p: Array, apart: float) -> Array:
        """Points (M, 3) of the first camera's frame before a camera that is so much farther off."""
        R, t = self.T_film_first[:3, :3], self.T_film_first[:3, 3]
        return np.asarray(p @ R.T + apart * t)


@dataclass(frozen=True, eq=False)
class SeenBeside:
    """What another film shows of one pose."""

    film: FilmOfPose
    residuals: Residuals


def size_count(values: Array | NDArray[np.bool_]) -> int:
    """How many of what is shared are sizes, which come in pairs; the focal length, the distance
    and, where there are other films, how far their cameras are away follow."""
    return 2 * ((len(values) - 2) // 2)


@dataclass(frozen=True, eq=False)
class Shared:
    """What K pictures share, and a pose for each of them.

    values (S + 2,): logarithms of ratios: the sizes, the focal length, the distance of all poses;
    (S + 3,) with other films, whose cameras' distance from the first one is the last.
    """

    values: Array
    poses: tuple[Pose, ...]

    @property
    def sizes(self) -> Array:
        """(S,)"""
        return self.values[: size_count(self.values)]

    @property
    def apart(self) -> float:
        """How far other films' cameras are from the first one, as a multiple of what was taken."""
        return float(np.exp(self.values[size_count(self.values) + 2 :].sum()))

    @property
    def nearer(self) -> Array:
        """(3,) by which the root's place is multiplied: a longer lens stretches depth alone."""
        focal, distance = self.values[size_count(self.values) :][:2]
        return np.exp([distance, distance, distance + focal])

    def focus(self, camera: Camera, zoom: float = 1.0) -> Camera:
        """A camera with the focal length found, zoomed."""
        return camera.zoomed(zoom * float(np.exp(self.values[size_count(self.values)])))


@dataclass(frozen=True, eq=False)
class SharedFit:
    """What is fitted: the body, the camera, the poses as they were posed, and what stays fixed.

    free (S + 2,): which of the shared values may change; usual (S + 2,): their sigmas in general,
    share (S + 2,): and here. poses_free: whether poses may change besides what is shared.
    turns_rad, trunk_rad (3,): sigmas of the turns of limbs and of the trunk.
    zoom (K,): each picture's focal length as a multiple of the camera's.
    beside: what other films show of each pose; none where there are none, and S + 2 is S + 3 else.
    """

    proportions: Proportions
    camera: Camera
    posed: tuple[Pose, ...]
    zoom: Array
    limits: Limits
    free: NDArray[np.bool_]
    usual: Array
    share: Array
    poses_free: bool = True
    turns_rad: tuple[float, ...] = TURNS_RAD
    trunk_rad: tuple[float, ...] = TRUNK_RAD
    beside: tuple[tuple[SeenBeside, ...], ...] = ()

    def seen_beside(self, k: int) -> tuple[SeenBeside, ...]:
        """What other films show of pose k."""
        return self.beside[k] if self.beside else ()

    @property
    def precision(self) -> Array:
        """(S + 2, S + 2) of the prior on each value, and on how long the body is all in all.

        A larger body farther away looks the same, so that what was set as its height stays.
        """
        lengths = np.zeros(len(self.free))
        lengths[: self.proportions.count : 2] = 1 / len(self.proportions.groups)
        return np.diag(self.share**-2.0) + np.outer(lengths, lengths) / HEIGHT_SHARE**2

    def lens(self, shared: Shared, k: int) -> Camera:
        """The camera as it took picture k."""
        return shared.focus(self.camera, float(self.zoom[k]))

    def transforms(self, shared: Shared, k: int) -> Array:
        """Ts_camera_part (P, 4, 4) in picture k."""
        pose = shared.poses[k]
        skeleton = self.proportions.skeleton_at(shared.sizes)
        return part_transforms(skeleton, pose.Rs_parent_part, pose.p_camera_root)

    def camera_points(self, shared: Shared, k: int, residuals: Residuals) -> Array:
        """(M, 3) the points of the rows in the camera's frame."""
        points = residuals.points * self.proportions.ratios(shared.sizes)[residuals.parts]
        return points_on_parts(self.transforms(shared, k), residuals.parts, points)

    def pixels(
        self, shared: Shared, k: int, residuals: Residuals, film: FilmOfPose | None = None
    ) -> Array:
        """(M, 2) where the points of the rows are seen; film: another than the first."""
        p = self.camera_points(shared, k, residuals)
        if film is None:
            return self.lens(shared, k).project(p)
        return film.camera.project(film.before_camera(p, shared.apart))

    def with_step(self, shared: Shared, step: Array) -> Shared:
        """The shared values changed by a step (S + 2,), and where the poses are along with it."""
        nearer = Shared(step, ()).nearer
        poses = (Pose(p.Rs_parent_part, p.p_camera_root * nearer) for p in shared.poses)
        return Shared(shared.values + step, tuple(poses))


@dataclass(frozen=True, eq=False)
class Solved:
    """What was found; spread (S + 2,): sigmas of the shared values."""

    shared: Shared
    spread: Array


def solve(fit: SharedFit, start: Shared, rows: Sequence[Residuals], steps: int) -> Solved:
    """A few steps downhill from a start; one that makes things worse is shortened or not taken."""
    few = replace(USUAL, most_steps=steps, most_tries=5, longest_step=0.2)
    solution = least_squares(_SizesProblem(fit, rows), start, few)
    last = solution.solved
    spread = np.zeros(len(start.values)) if last is None else last.spread(solution.damping)
    return Solved(solution.state, spread)


def covariance(fit: SharedFit, shared: Shared, rows: Sequence[Residuals]) -> Array:
    """(S + 3, S + 3) of what is shared, were all of it free, with its usual sigmas."""
    whole = replace(fit, free=np.ones_like(fit.free), share=fit.usual)
    return _Iterate(whole, shared, rows).covariance(0.0)


@dataclass(frozen=True, eq=False)
class _SizesProblem(Problem[Shared, "_Iterate"]):
    """A step is that of what is shared (S + 2,), and then the motion (D,) of every pose."""

    fit: SharedFit
    rows: Sequence[Residuals]

    def at(self, state: Shared, count: int) -> _Iterate:
        return _Iterate(self.fit, state, self.rows)

    def moved(self, state: Shared, step: Array) -> Shared:
        sizes, motions = np.split(step, [len(state.values)])
        return _take_step(self.fit, state, sizes, motions.reshape(len(state.poses), -1))


@dataclass(frozen=True, eq=False)
class _Iterate:
    """Sizes and poses, and the residuals there."""

    fit: SharedFit
    shared: Shared
    rows: Sequence[Residuals]

    @cached_property
    def cost(self) -> float:
        return _cost(self.fit, self.shared, self.rows)

    @cached_property
    def _normal_blocks(self) -> list[Array]:
        return [
            _normal_block(self.fit, self.shared, k, residuals)
            for k, residuals in enumerate(self.rows)
        ]

    def step(self, damping: float) -> Array | None:
        A, b, shares = _marginalise_poses(self.fit, self.shared, self._normal_blocks, damping)
        return _solve_arrow(self.fit.free, A, b, shares)

    def spread(self, damping: float) -> Array:
        """(S + 2,) sigmas of what is shared."""
        return np.sqrt(np.maximum(np.diag(self.covariance(damping)), 0.0))

    def covariance(self, damping: float) -> Array:
        """(S + 2, S + 2) of what is shared."""
        A, _, _ = _marginalise_poses(self.fit, self.shared, self._normal_blocks, damping)
        return np.asarray(np.linalg.inv(A))


def _take_step(fit: SharedFit, shared: Shared, step: Array, motions: Array) -> Shared:
    if not fit.poses_free:
        return fit.with_step(shared, step)
    skeleton = fit.proportions.skeleton
    poses = tuple(moved(skeleton, p, x) for p, x in zip(shared.poses, motions, strict=True))
    return fit.with_step(replace(shared, poses=poses), step)


def _normal_block(fit: SharedFit, shared: Shared, k: int, residuals: Residuals) -> Array:
    """(D + S + 3, D + S + 3) JᵀJ of one picture over its pose, what is shared, the residual."""
    dofs = fit.proportions.skeleton.dof_count
    prior = total_equations(_prior_terms(fit, shared, k), _posed_body(fit, shared, k))
    block = _block_of(fit, shared, k, residuals)
    block[:dofs, :dofs] += prior.A
    block[:dofs, -1] += prior.b
    for row in fit.seen_beside(k):
        block += _block_of(fit, shared, k, row.residuals, row.film)
    return block


def _block_of(
    fit: SharedFit, shared: Shared, k: int, residuals: Residuals, film: FilmOfPose | None = None
) -> Array:
    """The same of the rows in one film alone."""
    dofs, sizes = fit.proportions.skeleton.dof_count, len(fit.free)
    there = fit.pixels(shared, k, residuals, film)
    away = (residuals.along(there) - residuals.target) / residuals.sigma_px
    weight = np.sqrt(KERNEL.weight(away))
    J = np.zeros((len(away), dofs + sizes + 1))
    J[:, :dofs] = _pose_jacobian(fit, shared, k, residuals, film)
    J[:, dofs:-1] = _size_jacobian(fit, shared, k, residuals, there, film)
    J[:, :-1] *= (weight / residuals.sigma_px)[:, None]
    J[:, -1] = away * weight
    return _products(J)


def _products(J: Array) -> Array:
    """JᵀJ in small pieces: a large product would run in threads, which costs more than it saves
    beside other work."""
    padded = np.zeros((-(-len(J) // PIECE), PIECE, J.shape[1]))
    padded.reshape(-1, J.shape[1])[: len(J)] = J
    return np.asarray((np.swapaxes(padded, 1, 2).copy() @ padded).sum(axis=0))


def _marginalise_poses(
    fit: SharedFit, shared: Shared, blocks: Sequence[Array], damping: float
) -> tuple[Array, Array, list[Array]]:
    """Equations of what is shared, the poses marginalised (Schur complement), and how every pose
    follows from it (D, S + 3)."""
    dofs, A = fit.proportions.skeleton.dof_count, fit.precision
    b = A @ shared.values
    shares: list[Array] = []
    for block in blocks:
        pose, mixed, rest = block[:dofs, :dofs], block[:dofs, dofs:], block[dofs:-1, dofs:]
        if fit.poses_free:
            pose = pose + damping * np.diag(np.diag(pose))
            share = np.asarray(np.linalg.solve(pose, mixed), np.float64)
        else:
            share = np.zeros_like(mixed)
        less = rest - mixed[:, :-1].T @ share
        A, b = A + less[:, :-1], b + less[:, -1]
        shares.append(share)
    return A, b, shares


def _solve_arrow(free: NDArray[np.bool_], A: Array, b: Array, shares: Sequence[Array]) -> Array:
    """The step of what is shared, and the motions of all poses that follow from it."""
    step = np.where(free, -np.linalg.solve(A, b), 0.0)
    if not free.all():
        step[free] = -np.linalg.solve(A[np.ix_(free, free)], b[free])
    return np.concatenate([step, *(-share[:, -1] - share[:, :-1] @ step for share in shares)])


def _cost(fit: SharedFit, shared: Shared, rows: Sequence[Residuals]) -> float:
    """Half the sum of squares, those of the rows robust; infinite behind the camera."""
    total = shared.values @ fit.precision @ shared.values
    for k, residuals in enumerate(rows):
        prior = total_cost(_prior_terms(fit, shared, k), _posed_body(fit, shared, k))
        away = (
            residuals.along(fit.pixels(shared, k, residuals)) - residuals.target
        ) / residuals.sigma_px
        beside = [away_beside(fit, shared, k, row) for row in fit.seen_beside(k)]
        if not all(np.isfinite(each).all() for each in (away, *beside)):
            return np.inf
        total += 2 * prior + KERNEL.loss(away).sum()
        total += sum(KERNEL.loss(each).sum() for each in beside)
    return 0.5 * float(total)


def away_beside(fit: SharedFit, shared: Shared, k: int, beside: SeenBeside) -> Array:
    """(M,) by how many sigmas pose k misses what another film shows."""
    rows = beside.residuals
    there = fit.pixels(shared, k, rows, beside.film)
    return np.asarray((rows.along(there) - rows.target) / rows.sigma_px)


def _pose_jacobian(
    fit: SharedFit, shared: Shared, k: int, residuals: Residuals, film: FilmOfPose | None = None
) -> Array:
    """(M, D) how the rows change with small motions of the pose."""
    pose, skeleton = shared.poses[k], fit.proportions.skeleton_at(shared.sizes)
    p = fit.camera_points(shared, k, residuals)
    J = Posed.of(skeleton, pose).point_jacobian(residuals.parts, p)
    if film is None:
        uv = image_jacobian(fit.lens(shared, k), p, J)
    else:
        R = film.T_film_first[:3, :3]
        uv = image_jacobian(film.camera, film.before_camera(p, shared.apart), np.asarray(J @ R.T))
    return np.asarray(np.einsum("mdc,mc->md", uv, residuals.normals))


def _size_jacobian(
    fit: SharedFit,
    shared: Shared,
    k: int,
    residuals: Residuals,
    there: Array,
    film: FilmOfPose | None = None,
) -> Array:
    """(M, S + 2) how they change with what is shared, by small differences."""
    slopes = np.zeros((len(residuals.parts), len(fit.free)))
    for s in np.flatnonzero(fit.free):
        step = np.zeros(len(fit.free))
        step[s] = SMALL
        beside = fit.pixels(fit.with_step(shared, step), k, residuals, film)
        slopes[:, s] = residuals.along(beside - there) / SMALL
    return slopes


def _posed_body(fit: SharedFit, shared: Shared, k: int) -> Posed:
    return Posed.of(fit.proportions.skeleton, shared.poses[k])


def _prior_terms(fit: SharedFit, shared: Shared, k: int) -> list[Term]:
    """Staying near what was posed, and within the joints' limits.

    Across the view the root is compared along the ray on which it was posed: nearer or farther is
    free.
    """
    skeleton, posed = fit.proportions.skeleton, fit.posed[k]
    sigma_rad = np.array(fit.turns_rad)[skeleton.dof_axis]
    sigma_rad = np.where(
        fit.proportions.is_trunk[skeleton.dof_part],
        np.array(fit.trunk_rad)[skeleton.dof_axis],
        sigma_rad,
    )
    turns = np.where(skeleton.dof_turns == 1, sigma_rad**-2.0, 0.0)
    p_posed = posed.p_camera_root * shared.nearer
    along = np.eye(3)
    if fit.camera.projection == "perspective":
        along[:2, 2] = -p_posed[:2] / p_posed[2]
    sigma = np.array([POSED_SHIFT_M, POSED_SHIFT_M, POSED_DEPTH_SHARE * p_posed[2]])
    return [
        PosePrior.of(posed, turns),
        RootPosition(p_posed, along / sigma[:, None]),
        JointLimits(fit.limits, LIMIT_RAD),
    ]
