"""Find where other films' cameras were from the body that all of them saw.

Each film gets several starts: from where joints are seen alone (the essential matrix), from the
network's own depths, placed before both cameras, and from keyframes, whose joints are known in
space. Each is adjusted (`bundle.py`); the one that explains best what is seen counts.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.films.bundle import (
    ENDS,
    KERNEL,
    LENGTHS,
    LIMBS,
    OF_BONE,
    SIZE_SHARE,
    USUAL_M,
    Adjusted,
    BodyBundle,
    BundleData,
    adjusted,
    triangulated,
)
from keypose.tracker.films.sightings import Sightings
from keypose.tracker.geometry.rotations import (
    Array,
    apply_transform,
    log_rotation,
    nearest_rotation,
    transpose,
)
from keypose.tracker.geometry.triangulation import LEAST_DEPTH_M
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.solver.posed import BodyPoints

MOST_MOMENTS = 30
"""More of them make nothing surer: neighbouring frames of a film share their errors."""
LOOSE = 0.25
"""Visibility of a joint from which two views of it are compared."""
INLIER_SIGMAS = 1.33
FEWEST_POINTS = 24
FEWEST_IN_VIEW = 6
"""Joints with which a camera can be placed before a known body."""
OWN_SIGMA = 2.0
"""By how much errors are larger than the residuals say: a detector's own places of joints shift
alike in all frames. (Of four cameras a known way apart.)"""
SAME_SPREAD = 1.2
"""Guesses that lie within so many times the median's distance of the middle one are its own."""


@dataclass(frozen=True, eq=False)
class FoundCamera:
    """Where a film's camera is, T_camera_first (4, 4) from the first film's frame; of those that
    move their bases.

    focal, first_focal: its focal length and the first camera's, as multiples of those they were
        taken to have.
    metres: of the unit of its way, where that was unknown.
    sigma_rad, sigma_m: standard deviations of how it is turned, and of where it is.
    cost: of a moment; what other starts are compared by.
    """

    T_camera_first: Array
    focal: float
    first_focal: float
    sigma_rad: float
    sigma_m: float
    cost: float
    metres: float = 0.0


def lengths_of(body: Body) -> Array:
    """(L,) `LENGTHS` of a body, metres; NaN of those that it has not, and of those of the trunk,
    whose corners a detector sees elsewhere."""
    skeleton = Skeleton.of(body)
    joints = joints_of_pose(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))
    lengths = np.full(len(LENGTHS), np.nan)
    of_bones = np.linalg.norm(joints[ENDS[:, 0]] - joints[ENDS[:, 1]], axis=-1)
    for number in range(LIMBS):
        lengths[number] = of_bones[number == OF_BONE].mean()
    return lengths


def joints_of_pose(skeleton: Skeleton, pose: Pose) -> Array:
    """(J, 3) `JOINTS` of a posed body in the camera's frame; NaN of those that it has not."""
    index, parts, points = points_on_body(skeleton.body, JOINTS)
    where = np.full((len(JOINTS), 3), np.nan)
    where[index] = BodyPoints.single(skeleton, parts, points).at(pose_transforms(skeleton, pose))
    return where


def moments_of(films: Sequence[Sightings]) -> NDArray[np.int64]:
    """The rows at which all films see the body, evenly spread over them."""
    rows = np.flatnonzero(np.logical_and.reduce([film.seen for film in films]))
    if len(rows) > MOST_MOMENTS:
        rows = rows[np.linspace(0, len(rows) - 1, MOST_MOMENTS).astype(int)]
    return np.asarray(rows, np.int64)


def find_camera(
    first: Sightings,
    film: Sightings,
    lengths_m: Array,
    *,
    free_focal: tuple[bool, bool] = (False, False),
    keyed: Mapping[int, Array] | None = None,
    near: Array | None = None,
) -> FoundCamera | None:
    """Where a film's camera is; None where nothing tells it.

    first, film: at the same moments.  lengths_m: as `lengths_of`.  free_focal: whether
        the first lens is a guess, and this film's.
    keyed: joints (J, 3) in the first camera's base at rows that were posed.  near: T_camera_first
        that is about right: only this start counts then.
    """
    keyed = keyed or {}
    rows = moments_of([first, film])
    if len(rows) < 2:
        return None
    both = np.array([row for row in keyed if first.seen[row] and film.seen[row]], np.int64)
    rows = np.union1d(rows, both)
    nobody = np.full((len(JOINTS), 3), np.nan)
    posed = np.stack([keyed.get(int(row), nobody) for row in rows])
    sights = [first.rows(rows), film.rows(rows)]
    data = BundleData.of(sights, lengths_m, free_focal, posed)
    starts = [near] if near is not None else list(_starts(first, film, lengths_m, keyed))
    ends = [end for T in starts if (end := adjusted_from(data, [np.eye(4), T])) is not None]
    if not ends:
        return None
    best = min(ends, key=lambda end: end.cost)
    return found_cameras(best)[0] if np.isfinite(best.cost) else None


def adjusted_from(data: BundleData, Ts: Sequence[Array]) -> Adjusted | None:
    """The adjustment from cameras; None where they see the body behind them."""
    joints = triangulated(data, np.stack(Ts))
    usual = np.nanmedian(joints, axis=1, keepdims=True) if np.isfinite(joints).any() else None
    if usual is None or not np.isfinite(usual).all():
        return None
    joints = np.where(np.isfinite(joints), joints, usual)
    joints = _before_all(joints, data.Ts_camera_world(np.stack(Ts)))
    lengths_m = np.where(np.isfinite(data.lengths_m), data.lengths_m, USUAL_M)
    none = np.zeros(len(Ts))
    return adjusted(data, BodyBundle(np.stack(Ts), none, none, joints, lengths_m))


def found_cameras(end: Adjusted) -> list[FoundCamera]:
    """The cameras but the first of an adjustment."""
    cameras = []
    bundle = end.bundle
    for T, log_focal, metres, covariance in zip(
        bundle.Ts[1:], bundle.log_focal[1:], bundle.metres[1:], end.covariances, strict=True
    ):
        # of where the camera is, not of the world's origin before it
        back = np.concatenate([_cross(-T[:3, 3]), np.eye(3)], axis=1)
        place = back @ covariance @ back.T
        cameras.append(
            FoundCamera(
                T,
                float(np.exp(log_focal)),
                float(np.exp(bundle.log_focal[0])),
                OWN_SIGMA * float(np.sqrt(np.trace(covariance[:3, :3]))),
                OWN_SIGMA * float(np.sqrt(np.trace(place))),
                end.cost,
                float(metres),
            )
        )
    return cameras


def _cross(v: Array) -> Array:
    """(3, 3) w ↦ w × v."""
    x, y, z = v
    return np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])


def _before_all(joints: Array, Ts: Array) -> Array:
    """Joints where all cameras (V, F, 4, 4) have them before them: those that have not are put at
    the middle of the others."""
    z = np.einsum("vfa,fja->vfj", Ts[..., 2, :3], joints) + Ts[..., None, 2, 3]
    behind = (z < 0.3).any(axis=0)
    if not behind.any() or behind.all():
        return joints
    middle = np.median(joints[~behind], axis=0)
    # apart from one another: bones of no length point nowhere
    spread = np.random.default_rng(0).normal(0.0, 0.2, joints.shape)
    return np.where(behind[..., None], middle + spread, joints)


def _starts(
    first: Sightings, film: Sightings, lengths_m: Array, keyed: Mapping[int, Array]
) -> Iterator[Array]:
    """Guesses of T_camera_first."""
    for row, joints in keyed.items():
        T = _placed(joints, film, row)
        if T is not None:
            yield T
    for T in (_by_rays(first, film, lengths_m), _by_depths(first, film)):
        if T is not None:
            yield T


def _by_rays(first: Sightings, film: Sightings, lengths_m: Array) -> Array | None:
    """By the essential matrix of all moments, its length that of the bones."""
    a, b = _in_base(first), _in_base(film)
    both = np.minimum(first.visibility, film.visibility) > LOOSE
    both &= np.isfinite(a).all(axis=-1) & np.isfinite(b).all(axis=-1)
    a, b = a[both], b[both]
    if len(a) < FEWEST_POINTS:
        return None
    cv2.setRNGSeed(1)
    threshold = INLIER_SIGMAS * max(first.sigma, film.sigma)
    E, inliers = cv2.findEssentialMat(
        a, b, np.eye(3), method=cv2.RANSAC, prob=0.9999, threshold=threshold
    )
    if np.shape(E) != (3, 3):
        return None
    _, R, t, _ = cv2.recoverPose(E, a, b, np.eye(3), mask=inliers)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, t[:, 0]
    return at_limbs_length(T, first, film, lengths_m)


def _in_base(film: Sightings) -> Array:
    """(N, J, 2) where a camera that stood at its base would see what a film saw, were all of it far
    away; NaN of what lies behind it."""
    if film.path is None:
        return film.xy
    rays = np.concatenate([film.xy, np.ones((*film.xy.shape[:-1], 1))], axis=-1)
    x, y, z = np.moveaxis(rays @ film.path.Ts_camera_world[:, :3, :3], -1, 0)
    ahead = np.where(z > LEAST_AHEAD, z, np.nan)
    return np.stack([x / ahead, y / ahead], axis=-1)


LEAST_AHEAD: Final = 0.2
"""Cosine to where the base looks."""


def at_limbs_length(T: Array, first: Sightings, film: Sightings, lengths_m: Array) -> Array | None:
    """T_camera_first whose lengths are of any unit, in metres: so that limbs are as long as the
    body's; None where no limb is seen by both.  first, film: at the same moments."""
    T, rows = T.copy(), moments_of([first, film])
    if not len(rows):
        return None
    data = BundleData.of([first.rows(rows), film.rows(rows)], lengths_m, (False, False))
    joints = triangulated(data, np.stack([np.eye(4), T]))
    apart = np.linalg.norm(joints[:, ENDS[:, 0]] - joints[:, ENDS[:, 1]], axis=-1)
    measured = np.isfinite(apart).any(axis=0) & np.isfinite(lengths_m[OF_BONE])
    if not measured.any():
        return None
    T[:3, 3] *= lengths_m[OF_BONE[measured]].sum() / np.nanmedian(apart[:, measured], axis=0).sum()
    return T


def _by_depths(first: Sightings, film: Sightings) -> Array | None:
    """By the network's own depths in the first film, placed before both cameras at each moment: the
    middle of what that says."""
    guesses = []
    for row in moments_of([first, film]):
        joints = first.p_hips[row]
        if not np.isfinite(joints).all():
            continue
        there, here = _placed(joints, first, row), _placed(joints, film, row)
        if there is not None and here is not None:
            guesses.append(here @ np.linalg.inv(there))
    return _middle(np.array(guesses)) if len(guesses) > 2 else None


def _placed(joints: Array, film: Sightings, row: int) -> Array | None:
    """T_base_joints (4, 4) of a camera that sees joints (J, 3) at one of its moments."""
    xy, visibility = film.xy[row], film.visibility[row]
    used = (visibility > LOOSE) & np.isfinite(joints).all(axis=-1) & np.isfinite(xy).all(axis=-1)
    if used.sum() < FEWEST_IN_VIEW:
        return None
    try:
        ok, turn, shift = cv2.solvePnP(
            joints[used], xy[used], np.eye(3), None, flags=cv2.SOLVEPNP_SQPNP
        )
    except cv2.error:
        return None  # joints on one line say nothing of a camera
    if not ok or not np.isfinite(shift).all() or shift[2, 0] <= 0:
        return None
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = cv2.Rodrigues(turn)[0], shift[:, 0]
    return T if film.path is None else np.asarray(film.path.Ts_world_camera[row] @ T)


def _middle(Ts: Array) -> Array:
    """The mean of those transforms (N, 4, 4) that lie about the middle one."""
    R = Ts[:, :3, :3]
    apart = np.linalg.norm(log_rotation(transpose(R)[:, None] @ R[None]), axis=-1)
    middle = int(np.argmin(np.median(apart, axis=1)))
    near = apart[middle] <= SAME_SPREAD * np.median(apart[middle]) + 1e-9
    T = np.eye(4)
    T[:3, :3] = nearest_rotation(R[near].mean(axis=0))
    T[:3, 3] = np.median(Ts[near, :3, 3], axis=0)
    return T


def at_scale_of(camera: FoundCamera, film: Sightings, keyed: Mapping[int, Array]) -> FoundCamera:
    """The camera as far away as keyframes say: by the lengths of a body alone all distances may be
    off by one share, which keyframes posed with that body tell.

    film: at the first film's moments.  keyed: joints (J, 3) in the first camera's base by moment.
    """
    rows = [row for row in keyed if film.visibility[row].max(initial=0.0) > 0]
    if not rows:
        return camera
    joints = np.stack([keyed[row] for row in rows])
    xy, scale = film.xy[rows], film.scale[rows] * np.isfinite(joints).all(axis=-1)
    R, t = camera.T_camera_first[:3, :3], camera.T_camera_first[:3, 3]
    turned, Ts_camera_base = np.nan_to_num(joints) @ R.T, film.Ts_camera_base(camera.metres)[rows]
    costs = []
    for share in SHARES:
        p = apply_transform(Ts_camera_base, turned + share * t)
        projected = camera.focal * p[..., :2] / np.maximum(p[..., 2:], LEAST_DEPTH_M)
        away = np.linalg.norm(np.nan_to_num(projected - xy), axis=-1) * scale / LOOSE_SIGMAS
        costs.append(KERNEL.loss(away).sum() + (np.log(share) / SIZE_SHARE) ** 2)
    T = camera.T_camera_first.copy()
    T[:3, 3] *= SHARES[int(np.argmin(costs))]
    return replace(camera, T_camera_first=T)


SHARES: Final = np.linspace(0.8, 1.25, 181)
"""By which all distances may be off."""
LOOSE_SIGMAS: Final = 3.0
"""By so many times as far as a detector's joints those of a keyframe lie aside in another film."""
