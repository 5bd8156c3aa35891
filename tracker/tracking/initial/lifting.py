"""From tracks in the picture to a motion in space: whole limb chains fitted over a segment.

INITIAL follows head, hands and feet in the picture and takes the motion to lie in a plane; it names
motion in 3D as what is left to do. Here all inner poses of a segment are unknown at once, and the
followed points must fall on their tracks. Bones keep their lengths because only turns and the
root's place are unknown. What a picture leaves open, nearer or farther, comes from both keyframes:
the motion is smooth, bends no joint beyond its limits, and keeps to a start where nothing is told.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tracker.body.joint_limits import Limits
from tracker.body.pose import twists
from tracker.body.skeleton import Skeleton
from tracker.body.trajectory import Trajectory
from tracker.geometry.camera import Camera
from tracker.geometry.rotations import Array, log_rotation, transpose
from tracker.kernels.chain import solve_banded
from tracker.kernels.whole import move_inner
from tracker.tracking.scene import Scene
from tracker.tracking.segment import NEAREST_M, Segment

if TYPE_CHECKING:
    from tracker.tracking.initial.templates import LimbTracks

SMOOTH_TURN_RAD = np.radians(1.0)
SMOOTH_SHIFT_PX = 0.7
"""Standard deviations of how the motion's change from frame to frame differs from the start's."""
LIMB_TURN_RAD, TRUNK_TURN_RAD = np.radians(14.0), np.radians(4.0)
KEEP_SHIFT_PX = 4.0
"""How far a limb's part, a part that carries several limbs, and the root may leave the start."""
LIMIT_RAD = np.radians(3.0)
LEAST_SIGMA_PX = 0.5
HUBER_WIDTH, CAUCHY_WIDTH = 1.345, 2.385
"""Robust widths in standard deviations: the first solves come from far, the last ones sort out."""
MOST_STEPS = 15
LONGEST_STEP = 0.3
SETTLED, GAIN = 1e-3, 1e-3
"""The step (radians or metres) and the share of the cost gained that end the descent."""


def lifted(scene: Scene, segment: Segment, base: Trajectory, tracks: LimbTracks) -> Trajectory:
    """The motion near `base` whose limbs fall on their tracks; its ends are the keyframes.

    It never fits worse than `base`, which comes back where there is nothing to fit.
    """
    base = _between_keyframes(segment, base)
    if len(base) < 3 or not scene.skeleton.dof_count or not _is_told(tracks).any():
        return base
    fit = _Fit.of(scene, segment, base, tracks)
    found = base
    for robust in (False, True):
        found = _descended(fit, found, robust)
    return found if fit.cost(found, False) < fit.cost(base, False) else base


def _between_keyframes(segment: Segment, base: Trajectory) -> Trajectory:
    R, t = base.loose()
    R[0], R[-1] = segment.start.Rs_parent_part, segment.end.Rs_parent_part
    t[0], t[-1] = segment.start.p_camera_root, segment.end.p_camera_root
    return Trajectory(base.first_frame, R, t)


def _is_told(tracks: LimbTracks) -> NDArray[np.bool_]:
    """(L, n) where a point was followed to, at the inner frames."""
    uv, sigma = tracks.uv[:, 1:-1], tracks.sigma_px[:, 1:-1]
    return np.asarray(np.isfinite(uv).all(axis=-1) & np.isfinite(sigma))


@dataclass(frozen=True, eq=False)
class _Fit:
    """What a motion is compared with: n inner frames, L followed points, D degrees of freedom.

    parts (L,), points (L, 3): the followed points in their parts' frames.
    uv (n, L, 2): where they were followed to; told (n, L): 1/σ in 1/px, 0 where they were not.
    bends (n, D): the start's second differences. keep, smooth (D,): 1/σ² of each.
    """

    scene: Scene
    base: Trajectory
    parts: NDArray[np.int64]
    points: Array
    uv: Array
    told: Array
    limits: Limits
    bends: Array
    keep: Array
    smooth: Array

    @classmethod
    def of(cls, scene: Scene, segment: Segment, base: Trajectory, tracks: LimbTracks) -> _Fit:
        told = _is_told(tracks)
        sigma = np.maximum(np.where(told, tracks.sigma_px[:, 1:-1], 1.0), LEAST_SIGMA_PX)
        uv = np.where(told[..., None], tracks.uv[:, 1:-1], 0.0)
        keyed = [pose.Rs_parent_part for pose in (segment.start, segment.end)]
        return cls(
            scene, base, np.asarray(tracks.parts, np.int64), np.asarray(tracks.points, np.float64),
            np.swapaxes(uv, 0, 1), np.where(told, 1 / sigma, 0.0).T,
            Limits.of(scene.skeleton.body).widened(keyed), _bends(scene.skeleton, base),
            _keep_precision(scene),
            scene.precision(SMOOTH_TURN_RAD, SMOOTH_SHIFT_PX * scene.pixel_m),
        )  # fmt: skip

    def cost(self, motion: Trajectory, robust: bool) -> float:
        """Half the sum of all squares, those of the tracks robust; infinite behind the camera."""
        Ts = motion.transforms(self.scene.skeleton)[1:-1]
        p = _points(Ts, self.parts, self.points)
        if not p[..., 2].min() > NEAREST_M:
            return np.inf
        away = np.linalg.norm(_project(self.scene.camera, p) - self.uv, axis=-1) * self.told
        outside = _excess(self.limits, motion)[0] / LIMIT_RAD
        left, bent = self._left(motion), _bends(self.scene.skeleton, motion) - self.bends
        return 0.5 * float(
            _loss(away, robust).sum()
            + (outside**2).sum()
            + _loss(np.sqrt(self.keep) * np.abs(left), False).sum()
            + _loss(np.sqrt(self.smooth) * np.abs(bent), False).sum()
        )

    def _left(self, motion: Trajectory) -> Array:
        """(n, D) how far the inner poses have left the start."""
        R, R_base = motion.Rs_parent_part[1:-1], self.base.Rs_parent_part[1:-1]
        shift = motion.ps_camera_root[1:-1] - self.base.ps_camera_root[1:-1]
        return _by_dof(self.scene.skeleton, log_rotation(transpose(R_base) @ R), R[:, 0], shift)

    def equations(self, motion: Trajectory, robust: bool) -> tuple[Array, Array]:
        """A (n, D, D) and b (n, D): normal equations of every inner frame by itself."""
        skeleton = self.scene.skeleton
        Ts = motion.transforms(skeleton)[1:-1]
        uv, slopes = seen_points(skeleton, self.scene.camera, Ts, self.parts, self.points)
        away = (uv - self.uv) * self.told[..., None]
        weight = np.sqrt(_weight(np.linalg.norm(away, axis=-1), robust))
        n, dofs = len(away), skeleton.dof_count
        J = (slopes * (weight * self.told)[..., None, None]).reshape(n, -1, dofs)
        r = (away * weight[..., None]).reshape(n, -1)
        J_limit, r_limit = self._limit_rows(motion)
        J, r = np.concatenate([J, J_limit], axis=1), np.concatenate([r, r_limit], axis=1)
        left = self._left(motion)
        keep = self.keep * _weight(np.sqrt(self.keep) * np.abs(left), False)
        A = np.swapaxes(J, 1, 2) @ J + keep[:, None] * np.eye(dofs)
        return A, np.einsum("nmd,nm->nd", J, r) + keep * left

    def _limit_rows(self, motion: Trajectory) -> tuple[Array, Array]:
        skeleton = self.scene.skeleton
        outside, slopes = _excess(self.limits, motion)
        slopes = slopes * (outside != 0)[..., None]
        J = np.zeros((*outside.shape, skeleton.dof_count))
        turns = np.flatnonzero(skeleton.dof_turns == 1)
        parts, axes = skeleton.dof_part[turns], skeleton.dof_axis[turns]
        for d, part, axis in zip(turns, parts, axes, strict=True):
            J[:, part, :, d] = slopes[:, part, :, axis]
        n = len(outside)
        return J.reshape(n, -1, skeleton.dof_count) / LIMIT_RAD, outside.reshape(n, -1) / LIMIT_RAD

    def smoothness(self, motion: Trajectory) -> tuple[Array, Array]:
        """Upper banded (3D, nD) and gradient (n, D) of the motion's bends beside the start's."""
        bent = _bends(self.scene.skeleton, motion) - self.bends
        stiff = self.smooth * _weight(np.sqrt(self.smooth) * np.abs(bent), False)
        n, dofs = bent.shape
        k = -2 * np.eye(n) + np.eye(n, k=1) + np.eye(n, k=-1)  # the keyframes do not move
        banded = np.zeros((3 * dofs, n * dofs))
        for off in range(min(3, n)):
            products = k[:, : n - off] * k[:, off:]
            banded[-1 - off * dofs, off * dofs :] = (products.T @ stiff).ravel()
        return banded, k @ (stiff * bent)


def _descended(fit: _Fit, start: Trajectory, robust: bool) -> Trajectory:
    """Levenberg–Marquardt over the whole segment; a step that makes things worse is not taken."""
    present, cost, damping = start, fit.cost(start, robust), 1e-3
    for _ in range(MOST_STEPS):
        A, b = fit.equations(present, robust)
        stiff, pull = fit.smoothness(present)
        while True:
            there, largest = _stepped(fit.scene, present, stiff, A, b + pull, damping)
            reached = np.inf if there is None else fit.cost(there, robust)
            if there is not None and reached < cost:
                break
            damping *= 10
            if damping > 1e6:
                return present
        gained = cost - reached
        present, cost, damping = there, reached, max(damping / 10, 1e-6)
        if largest < SETTLED or gained < GAIN * cost:
            break
    return present


def _stepped(
    scene: Scene, motion: Trajectory, stiff: Array, A: Array, b: Array, damping: float
) -> tuple[Trajectory | None, float]:
    """The motion after one solve, and its largest component; None where it cannot be solved."""
    n, dofs = b.shape
    banded, step = stiff.copy(), -b.ravel()
    d, e = np.triu_indices(dofs)
    columns = np.arange(n)[:, None] * dofs + e
    banded[len(banded) - 1 + d - e, columns] += A[:, d, e]
    banded[-1] = banded[-1] * (1 + damping) + 1e-6
    if not solve_banded(banded, step) or not np.isfinite(step).all():
        return None, 0.0
    largest = float(np.abs(step).max())
    step *= min(1.0, LONGEST_STEP / max(largest, 1e-12))
    R, t = motion.loose()
    move_inner(scene.arrays, R, t, step.reshape(n, dofs))
    return Trajectory(motion.first_frame, R, t), largest


def seen_points(
    skeleton: Skeleton, camera: Camera, Ts: Array, parts: NDArray[np.int64], points: Array
) -> tuple[Array, Array]:
    """Pixels (n, L, 2) of points (L, 3) on parts (L,) and their slopes (n, L, 2, D)."""
    p = _points(Ts, parts, points)
    S = twists(skeleton, Ts)[:, None]
    moved = S[..., :3] + np.cross(S[..., 3:], p[:, :, None])
    moved *= skeleton.below[parts][:, skeleton.dof_part][..., None]
    z = camera.depth(p)[..., None, None]
    slopes = moved[..., :2] / z
    if camera.projection == "perspective":
        slopes = slopes - p[:, :, None, :2] / z**2 * moved[..., 2:]
    slopes = slopes * (camera.fx, camera.fy)
    return _project(camera, p), np.swapaxes(slopes, -1, -2)


def _points(Ts_camera_part: Array, parts: NDArray[np.int64], points: Array) -> Array:
    T = Ts_camera_part[:, parts]
    return np.asarray((T[..., :3, :3] @ points[..., None])[..., 0] + T[..., :3, 3])


def _project(camera: Camera, p: Array) -> Array:
    z = camera.depth(p)[..., None]
    return np.asarray(p[..., :2] / z * (camera.fx, camera.fy) + (camera.cx, camera.cy))


def _bends(skeleton: Skeleton, motion: Trajectory) -> Array:
    """(n, D) how the motion changes from frame to frame at every inner frame."""
    R, t = motion.Rs_parent_part, motion.ps_camera_root
    turn = log_rotation(transpose(R[:-1]) @ R[1:])
    return np.diff(_by_dof(skeleton, turn, R[:-1, 0], np.diff(t, axis=0)), axis=0)


def _by_dof(skeleton: Skeleton, turn: Array, R_root: Array, shift: Array) -> Array:
    """(n, D) of turns (n, P, 3) in the parts' frames and the root's shift (n, 3) in camera's."""
    inside = np.einsum("nba,nb->na", R_root, shift)
    part, axis = skeleton.dof_part, skeleton.dof_axis
    return np.where(skeleton.dof_turns == 1, turn[:, part, axis], inside[:, axis])


def _keep_precision(scene: Scene) -> Array:
    """(D,) a trunk leaves the start less than the limbs it carries."""
    skeleton = scene.skeleton
    carried = np.bincount(skeleton.parents[1:], minlength=skeleton.part_count)
    turn = np.where(carried > 1, TRUNK_TURN_RAD, LIMB_TURN_RAD)[skeleton.dof_part]
    return np.where(skeleton.dof_turns == 1, turn, KEEP_SHIFT_PX * scene.pixel_m) ** -2.0


def _excess(limits: Limits, motion: Trajectory) -> tuple[Array, Array]:
    """`Limits.excess` of all inner poses: (n, P, 3) and (n, P, 3, 3)."""
    R = motion.Rs_parent_part[1:-1]
    n, parts = R.shape[:2]
    every = Limits(np.tile(limits.low, (n, 1)), np.tile(limits.high, (n, 1)))
    outside, slopes = every.excess(R.reshape(-1, 3, 3))
    return outside.reshape(n, parts, 3), slopes.reshape(n, parts, 3, 3)


def _loss(away: Array, robust: bool) -> Array:
    """What distances in standard deviations cost: Huber's loss, or Cauchy's."""
    if robust:
        return np.asarray(CAUCHY_WIDTH**2 * np.log1p((away / CAUCHY_WIDTH) ** 2))
    far = away > HUBER_WIDTH
    return np.where(far, HUBER_WIDTH * (2 * away - HUBER_WIDTH), away**2)


def _weight(away: Array, robust: bool) -> Array:
    """The weights (n, L) by which least squares come to the same."""
    if robust:
        return np.asarray(1 / (1 + (away / CAUCHY_WIDTH) ** 2))
    return HUBER_WIDTH / np.maximum(away, HUBER_WIDTH)
