"""Bundle adjustment over a body: where several cameras are that saw it at the same moments, how
long their lenses are, and where its joints were, in one solve.

The bones, whose lengths are known, give the scale. What is minimised are distances in the pictures
and of bones from their lengths, in standard deviations, weighed by Cauchy's kernel; joints are
eliminated moment by moment (Schur), since bones couple those of one moment alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.films.sightings import Sightings
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.geometry.triangulation import LEAST_DEPTH_M, where_rays_meet
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.solver.least_squares import Criteria, Damping, Problem, least_squares
from keypose.tracker.solver.robust import Cauchy


@dataclass(frozen=True)
class Bone:
    """Two joints whose distance stays.  ends: their numbers among `JOINTS`.  length: the number of
    the length among those that are asked for, which left and right share."""

    ends: tuple[int, int]
    length: int


LENGTHS: Final = (
    *(("shoulder", "elbow"), ("elbow", "wrist"), ("hip", "knee"), ("knee", "ankle")),
    *(("shoulder", "shoulder"), ("hip", "hip"), ("shoulder", "hip")),
)
"""The lengths of a body, each between two kinds of joints: those of limbs first."""
LIMBS: Final = 4
SPREAD_M: Final = np.array([0.02, 0.02, 0.02, 0.02, 0.03, 0.02, 0.05])
"""By how much joints lie nearer or farther than their bone is long, as a detector sees its ends, in
a standard deviation: shoulders are shrugged, and a trunk bends."""
SIZE_SHARE: Final = 0.06
UNKNOWN_SHARE: Final = 0.5
"""Standard deviation of a length, as a share of what the body has, and where it has none."""


def _bones() -> Iterator[Bone]:
    for number, (a, b) in enumerate(LENGTHS):
        if a == b:
            yield Bone((JOINTS.index(f"left_{a}"), JOINTS.index(f"right_{a}")), number)
            continue
        for side in ("left", "right"):
            yield Bone((JOINTS.index(f"{side}_{a}"), JOINTS.index(f"{side}_{b}")), number)


BONES: Final = tuple(_bones())
ENDS: Final = np.array([bone.ends for bone in BONES])
OF_BONE: Final = np.array([bone.length for bone in BONES])
FOCAL_SHARE = 0.10
"""Standard deviation of a lens that is a guess, as a share of its focal length."""
KERNEL = Cauchy()
"""Of distances and lengths, in standard deviations."""
ADJUSTING = Criteria(
    most_steps=60,
    gain=1e-6,
    damping=Damping(first=1e-4, least=1e-9, most=1e9),
)
USUAL_M: Final = np.array([0.29, 0.25, 0.42, 0.41, 0.34, 0.22, 0.5])
"""Lengths of a grown person, where the body has none."""
POSED_M = 0.05
"""Standard deviation of a joint that somebody posed, beside where detectors see it."""
WAY_M = 10.0
"""Standard deviation of how far a camera is carried."""
FREE_M = 30.0
"""Standard deviation of a joint before anything is seen: what one film alone sees has a depth."""


@dataclass(frozen=True, eq=False)
class BodyBundle:
    """V cameras, and J joints of a body at F moments.

    Ts (V, 4, 4): each camera's base from the world, which is the first one's base.
    log_focal (V,): of the focal length, as a multiple of the one the sightings were made with.
    metres (V,): of the unit of each camera's way.
    joints (F, J, 3): in the world, metres.  lengths_m (L,): of `LENGTHS`.
    """

    Ts: Array
    log_focal: Array
    metres: Array
    joints: Array
    lengths_m: Array


@dataclass(frozen=True, eq=False)
class BundleData:
    """What a bundle is compared with.

    Ts_camera_base (V, F, 4, 4): where each camera was in its base, at each moment, but for
        unit_shift (V, F, 3), whose unit is unknown.  unscaled: the views that have one.

    xy (V, F, J, 2): where joints are seen.  scale (V, F, J): 1/σ, 0 where they are not.
    lengths_m (L,): of `LENGTHS` as the body has them, NaN where it has not.  free_focal (V,):
        whose lens is a guess.  posed (F, J, 3): joints as somebody posed them, in the world, NaN
        where nobody did.
    """

    xy: Array
    scale: Array
    lengths_m: Array
    free_focal: tuple[bool, ...]
    posed: Array
    Ts_camera_base: Array
    unit_shift: Array
    unscaled: tuple[int, ...]

    @classmethod
    def of(
        cls,
        films: Sequence[Sightings],
        lengths_m: Array,
        free_focal: Sequence[bool],
        posed: Array | None = None,
    ) -> BundleData:
        """Films at the same moments."""
        xy = np.nan_to_num(np.stack([film.xy for film in films]))
        scale = np.stack([film.scale for film in films])
        nobody = np.full((*xy.shape[1:3], 3), np.nan)
        posed = nobody if posed is None else posed
        Ts_camera_base = np.stack([film.Ts_camera_base() for film in films])
        nowhere = np.zeros((scale.shape[1], 3))
        unit_shift = np.stack(
            [nowhere if film.unit_shift is None else film.unit_shift for film in films]
        )
        unscaled = tuple(v for v, film in enumerate(films) if film.unit_shift is not None)
        guesses = tuple(free_focal)
        return cls(xy, scale, lengths_m, guesses, posed, Ts_camera_base, unit_shift, unscaled)

    def Ts_camera_world(self, Ts: Array, metres: Array | None = None) -> Array:
        """(V, F, 4, 4) of cameras whose bases (V, 4, 4) are there, and the units of whose ways
        (V,) are so long; of none where that is not given."""
        Ts_camera_world = self.Ts_camera_base @ Ts[:, None]
        if metres is not None:
            Ts_camera_world[..., :3, 3] += metres[:, None, None] * self.unit_shift
        return np.asarray(Ts_camera_world)

    @property
    def lenses(self) -> list[int]:
        """The views whose focal length is free."""
        return [view for view, free in enumerate(self.free_focal) if free]

    @property
    def width(self) -> int:
        """Unknowns besides the joints: cameras, lenses, units of ways, lengths."""
        return 6 * (len(self.xy) - 1) + len(self.lenses) + len(self.unscaled) + len(LENGTHS)

    @property
    def first_length(self) -> int:
        """The number of the first length among these."""
        return self.width - len(LENGTHS)

    @property
    def length_shares(self) -> Array:
        """(L,) standard deviations of the lengths' logarithms."""
        return np.where(np.isfinite(self.lengths_m), SIZE_SHARE, UNKNOWN_SHARE)


@dataclass(frozen=True, eq=False)
class Adjusted:
    """Where the adjustment ended.

    cost: half the sum of squares, a moment.  covariance (6, 6) of each camera but the first: turned
        and shifted in its own frame, radians and metres, by what the residuals say of themselves.
    """

    bundle: BodyBundle
    cost: float
    covariances: Array


def adjusted(data: BundleData, start: BodyBundle) -> Adjusted:
    """The bundle that explains best what is seen, from a start near by; its cost is infinite where
    that cannot be."""
    solution = least_squares(_Adjustment(data), start, ADJUSTING)
    count = len(start.Ts) - 1
    covariances = np.full((count, 6, 6), np.nan)
    if np.isfinite(solution.cost):
        whole = solution.here.equations.covariance
        covariances = np.stack([whole[6 * v : 6 * v + 6, 6 * v : 6 * v + 6] for v in range(count)])
    return Adjusted(solution.state, float(solution.cost) / len(start.joints), covariances)


@dataclass(frozen=True, eq=False)
class _Equations:
    """Normal equations: C (n, n), h (n,) of cameras and lenses, A (F, D, D), g (F, D) of the
    joints of each moment, B (F, D, n) between these."""

    C: Array
    h: Array
    A: Array
    g: Array
    B: Array

    def step(self, damping: float) -> Array | None:
        """The damped step (n + F·D,): cameras and lenses, then the joints."""
        A = self.A + damping * np.einsum("fii->fi", self.A)[:, :, None] * np.eye(self.A.shape[1])
        try:
            solved = np.linalg.solve(A, np.concatenate([self.B, self.g[..., None]], axis=-1))
            of_cameras, own = solved[..., :-1], solved[..., -1]
            C = self.C + damping * np.diag(np.diag(self.C))
            C = C - np.einsum("fda,fdb->ab", self.B, of_cameras)
            h = self.h - np.einsum("fda,fd->a", self.B, own)
            step = -np.linalg.solve(C, h)
        except np.linalg.LinAlgError:
            return None
        return np.concatenate([step, -(own + of_cameras @ step).ravel()])

    @property
    def covariance(self) -> Array:
        """(n, n) of cameras and lenses, the joints left free."""
        between = np.linalg.solve(self.A, self.B)
        return np.asarray(np.linalg.pinv(self.C - np.einsum("fda,fdb->ab", self.B, between)))


@dataclass(frozen=True, eq=False)
class _Point:
    """A bundle on the way, and its cost and equations there."""

    data: BundleData
    bundle: BodyBundle

    @cached_property
    def _seen(self) -> tuple[Array, Array]:
        """Joints (V, F, J, 3) in the cameras' frames, and where they are seen (V, F, J, 2)."""
        Ts_camera_world = self.data.Ts_camera_world(self.bundle.Ts, self.bundle.metres)
        p = _seen_from(Ts_camera_world, self.bundle.joints)
        focal = np.exp(self.bundle.log_focal)[:, None, None, None]
        return p, focal * p[..., :2] / np.maximum(p[..., 2:], LEAST_DEPTH_M)

    @cached_property
    def _residuals(self) -> tuple[Array, Array]:
        """(V, F, J, 2) in standard deviations, and their lengths (V, F, J)."""
        r = (self._seen[1] - self.data.xy) * self.data.scale[..., None]
        return r, np.linalg.norm(r, axis=-1)

    @cached_property
    def _bones(self) -> tuple[Array, Array]:
        """The directions (F, B, 3) of the bones, and how much too long (F, B) they are, standard
        deviations."""
        joints, lengths = self.bundle.joints, self.bundle.lengths_m
        along = joints[:, ENDS[:, 0]] - joints[:, ENDS[:, 1]]
        length = np.maximum(np.linalg.norm(along, axis=-1), 1e-6)
        return along / length[..., None], (length - lengths[OF_BONE]) / SPREAD_M[OF_BONE]

    @cached_property
    def _off_posed(self) -> tuple[Array, Array]:
        """(F, J, 3) from where joints were posed, and their lengths (F, J), standard deviations; 0
        where nobody posed them."""
        off = np.nan_to_num(self.bundle.joints - self.data.posed) / POSED_M
        return off, np.linalg.norm(off, axis=-1)

    @cached_property
    def _size(self) -> Array:
        """(L,) by how much lengths are larger than the body's, standard deviations."""
        usual_m = np.where(np.isfinite(self.data.lengths_m), self.data.lengths_m, USUAL_M)
        return np.log(self.bundle.lengths_m / usual_m) / self.data.length_shares

    @cached_property
    def _way_scale(self) -> Array:
        """By each unscaled way's unit, 1/σ of how long that is: no camera is carried farther."""
        return (
            np.array([np.ptp(self.data.unit_shift[v], axis=0).max() for v in self.data.unscaled])
            / WAY_M
        )

    @cached_property
    def cost(self) -> float:
        p, (_, away), (_, off) = self._seen[0], self._residuals, self._bones
        if (p[..., 2] < LEAST_DEPTH_M)[self.data.scale > 0].any():
            return np.inf
        lenses = (self.bundle.log_focal[self.data.lenses] / FOCAL_SHARE) ** 2
        priors = lenses.sum() + (self._size**2).sum()
        ways = self.bundle.metres[list(self.data.unscaled)] * self._way_scale
        priors += (ways**2).sum()
        posed = KERNEL.loss(self._off_posed[1]).sum()
        total = KERNEL.loss(away).sum() + KERNEL.loss(np.abs(off)).sum() + priors + posed
        return 0.5 * float(total)

    @cached_property
    def equations(self) -> _Equations:
        data, bundle, n = self.data, self.bundle, self.data.width
        V, (F, J) = len(bundle.Ts), bundle.joints.shape[:2]
        A = np.tile(np.eye(3 * J) / FREE_M**2, (F, 1, 1))
        g, B = np.zeros((F, 3 * J)), np.zeros((F, 3 * J, n))
        C, h = np.eye(n) * 1e-9, np.zeros(n)
        p, uv = self._seen
        r, away = self._residuals
        weight = KERNEL.weight(away) * (data.scale > 0)
        by_joint, by_camera, by_focal, by_metre = _jacobians(data, bundle, p, uv)
        joint = np.arange(J)
        blocks = np.zeros((F, J, 3, J, 3))
        for v in range(V):
            JX, w = by_joint[v], weight[v]
            wJX = JX * w[..., None, None]
            blocks[:, joint, :, joint, :] += np.einsum("fjka,fjkb->jfab", wJX, JX)
            g += np.einsum("fjka,fjk->fja", wJX, r[v]).reshape(F, -1)
            columns, K = _columns(v, data, by_camera[v], by_focal[v], by_metre[v])
            if not len(columns):
                continue
            wK = K * w[..., None, None]
            C[np.ix_(columns, columns)] += np.einsum("fjka,fjkb->ab", wK, K)
            h[columns] += np.einsum("fjka,fjk->a", wK, r[v])
            B[:, :, columns] += np.einsum("fjka,fjkb->fjab", wJX, K).reshape(F, 3 * J, -1)
        off_posed, length = self._off_posed
        held = KERNEL.weight(length) * np.isfinite(data.posed).all(axis=-1)
        blocks[:, joint, :, joint, :] += held.T[..., None, None] * np.eye(3) / POSED_M**2
        g += (held[..., None] * off_posed / POSED_M).reshape(F, -1)
        A += blocks.reshape(F, 3 * J, 3 * J)
        self._add_bones(C, h, A, g, B)
        for k, view in enumerate(data.lenses):
            at = 6 * (V - 1) + k
            C[at, at] += FOCAL_SHARE**-2
            h[at] += bundle.log_focal[view] / FOCAL_SHARE**2
        for k, view in enumerate(data.unscaled):
            at = 6 * (V - 1) + len(data.lenses) + k
            C[at, at] += self._way_scale[k] ** 2
            h[at] += self._way_scale[k] ** 2 * bundle.metres[view]
        return _Equations(C, h, A, g, B)

    def _add_bones(self, C: Array, h: Array, A: Array, g: Array, B: Array) -> None:
        """What bones say of the joints of each moment, and of their lengths; of these by the
        logarithm."""
        along, off = self._bones
        weight = KERNEL.weight(np.abs(off))
        for k, bone in enumerate(BONES):
            i, j = (slice(3 * end, 3 * end + 3) for end in bone.ends)
            sigma, at = SPREAD_M[bone.length], self.data.first_length + bone.length
            w, unit = weight[:, k], along[:, k] / sigma
            block = w[:, None, None] * unit[:, :, None] * unit[:, None, :]
            A[:, i, i] += block
            A[:, j, j] += block
            A[:, i, j] -= block
            A[:, j, i] -= block
            pull = (w * off[:, k])[:, None] * unit
            g[:, i] += pull
            g[:, j] -= pull
            by_length = -self.bundle.lengths_m[bone.length] / sigma
            B[:, i, at] += by_length * w[:, None] * unit
            B[:, j, at] -= by_length * w[:, None] * unit
            C[at, at] += by_length**2 * w.sum()
            h[at] += by_length * (w * off[:, k]).sum()
        shares = self.data.length_shares
        own = self.data.first_length + np.arange(len(LENGTHS))
        C[own, own] += shares**-2
        h[own] += self._size / shares

    def step(self, damping: float) -> Array | None:
        return self.equations.step(damping)


def _seen_from(Ts_camera_world: Array, joints: Array) -> Array:
    """Joints (F, J, 3) of the world in the frames of cameras (V, F, 4, 4): (V, F, J, 3)."""
    R, t = Ts_camera_world[..., :3, :3], Ts_camera_world[..., None, :3, 3]
    return np.asarray(np.einsum("vfab,fjb->vfja", R, joints) + t)


def _jacobians(
    data: BundleData, bundle: BodyBundle, p: Array, uv: Array
) -> tuple[Array, Array, Array, Array]:
    """How residuals move with joints (V, F, J, 2, 3), with the turn and shift of their camera's
    base in its own frame (V, F, J, 2, 6), with the logarithm of its focal length, and with the unit
    of its way (V, F, J, 2).

    p: joints in the cameras' frames.
    """
    scale, Ts = data.scale, bundle.Ts
    focal = np.exp(bundle.log_focal)[:, None, None]
    z = np.maximum(p[..., 2], LEAST_DEPTH_M)
    P = np.zeros((*p.shape[:-1], 2, 3))
    P[..., 0, 0] = P[..., 1, 1] = focal / z
    P[..., :, 2] = -uv / z[..., None]
    P *= scale[..., None, None]
    by_metre = np.einsum("vfjka,vfa->vfjk", P, data.unit_shift)
    P = P @ data.Ts_camera_base[:, :, None, :3, :3]
    in_base = _seen_from(np.broadcast_to(Ts[:, None], data.Ts_camera_base.shape), bundle.joints)
    turned = np.cross(in_base[..., None, :], P)  # P (w × p) = w · (p × P)
    by_joint = P @ Ts[:, None, None, :3, :3]
    by_camera = np.concatenate([turned, P], axis=-1)
    return by_joint, by_camera, uv * scale[..., None], by_metre


def _columns(
    view: int, data: BundleData, by_camera: Array, by_focal: Array, by_metre: Array
) -> tuple[NDArray[np.int64], Array]:
    """The unknowns that a view's residuals depend on, and their Jacobian (F, J, 2, n)."""
    columns: list[int] = []
    parts: list[Array] = []
    if view > 0:
        columns += range(6 * (view - 1), 6 * view)
        parts.append(by_camera)
    after_cameras = 6 * (len(data.xy) - 1)
    if view in data.lenses:
        columns.append(after_cameras + data.lenses.index(view))
        parts.append(by_focal[..., None])
    if view in data.unscaled:
        columns.append(after_cameras + len(data.lenses) + data.unscaled.index(view))
        parts.append(by_metre[..., None])
    J = np.concatenate(parts, axis=-1) if parts else np.zeros((*by_focal.shape, 0))
    return np.array(columns, np.int64), J


@dataclass(frozen=True, eq=False)
class _Adjustment(Problem[BodyBundle, _Point]):
    """All cameras but the first, lenses that are a guess, and all joints."""

    data: BundleData

    def at(self, state: BodyBundle, count: int) -> _Point:
        return _Point(self.data, state)

    def moved(self, state: BodyBundle, step: Array) -> BodyBundle:
        views, lenses = len(state.Ts), self.data.lenses
        after_lenses = 6 * (views - 1) + len(lenses)
        ends = [6 * (views - 1), after_lenses, self.data.first_length, self.data.width]
        cameras, focal, units, sizes, joints = np.split(step, ends)
        Ts, log_focal, metres = state.Ts.copy(), state.log_focal.copy(), state.metres.copy()
        metres[list(self.data.unscaled)] += units
        steps = cameras.reshape(-1, 6)
        R = exp_rotation(steps[:, :3])
        Ts[1:, :3, :3] = R @ state.Ts[1:, :3, :3]
        Ts[1:, :3, 3] = (R @ state.Ts[1:, :3, 3:])[..., 0] + steps[:, 3:]
        log_focal[lenses] += focal
        return BodyBundle(
            Ts,
            log_focal,
            metres,
            state.joints + joints.reshape(-1, len(JOINTS), 3),
            state.lengths_m * np.exp(sizes),
        )


def triangulated(data: BundleData, Ts: Array) -> Array:
    """Joints (F, J, 3) in the world, each where the rays of all views meet best, were their bases
    (V, 4, 4) there; NaN where fewer than two see it."""
    return where_rays_meet(data.xy, data.scale, data.Ts_camera_world(Ts))
