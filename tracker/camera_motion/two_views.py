"""Find how a camera moved between two pictures, and how far points are, from nothing else."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.bundle import Bundle, adjusted, residual_lengths
from keypose.tracker.geometry.rotations import Array, nearest_rotation, transform
from keypose.tracker.solver.robust import Cauchy

FEWEST = 20
"""Points that a motion is believed from."""
LEAST_AGREE = 0.6
"""Share of the points that a motion must explain, all of them before both cameras."""
INLIER = 3.0
"""Standard deviations within which a point agrees."""
TURN_STEPS = 6
"""Of weighing anew which points a turn explains."""
UNKNOWN_SPREAD = 2.0
"""Standard deviation of an inverse depth of which nothing is known, over the usual one."""
STEPS = 15
"""Of the adjustment at the end."""
THRESHOLDS = (1.5, 4.0)
"""Of the essential matrix, standard deviations; the one that explains more points counts."""


@dataclass(frozen=True, eq=False)
class TwoViews:
    """T: (4, 4) of the second camera in the first, the middle depth of points the unit of length.

    depths, spread: (K,) inverse, along the first picture's rays.  agree: (K,).
    """

    T: Array
    depths: Array
    spread: Array
    agree: NDArray[np.bool_]


def parallax(xy: Array, xy_later: Array, noise: float) -> float:
    """The median distance of places (K, 2) in two pictures that no turn of the camera
    explains, in standard deviations.
    """
    a, b = (
        np.concatenate([places, np.ones((len(places), 1))], axis=1) for places in (xy, xy_later)
    )
    a, b = (ray / np.linalg.norm(ray, axis=1, keepdims=True) for ray in (a, b))
    R, weight = nearest_rotation(b.T @ a), np.ones(len(a))
    for _ in range(TURN_STEPS):
        left = np.linalg.norm(b - a @ R.T, axis=1) / noise
        weight = Cauchy(max(float(np.median(left)), 1.0)).weight(left)
        R = nearest_rotation((b * weight[:, None]).T @ a)
    return float(np.median(np.linalg.norm(b - a @ R.T, axis=1)) / noise)


def two_views(xy: Array, xy_later: Array, noise: float) -> TwoViews | None:
    """The motion that explains where points are seen in two pictures (K, 2), as x/z and y/z, by the
    essential matrix and then at the least cost; None where none does.

    noise: standard deviation of where a point is seen.
    """
    if len(xy) < FEWEST:
        return None
    motions = [_by_essential(xy, xy_later, noise, threshold * noise) for threshold in THRESHOLDS]
    return max(
        (motion for motion in motions if motion is not None),
        key=lambda motion: motion.agree.mean(),
        default=None,
    )


def _by_essential(xy: Array, xy_later: Array, noise: float, threshold: float) -> TwoViews | None:
    """As `two_views`; threshold: of the essential matrix, of the noise's unit."""
    cv2.setRNGSeed(0)  # the same pictures give the same motion
    E, inside = cv2.findEssentialMat(
        xy, xy_later, np.eye(3), method=cv2.RANSAC, prob=0.9999, threshold=threshold
    )
    if np.shape(E) != (3, 3):
        return None
    *turns, t = (np.asarray(part, float) for part in cv2.decomposeEssentialMat(E))
    motions = [transform(R, sign * t[:, 0]) for R in turns for sign in (1.0, -1.0)]
    ahead = [_ahead(T, xy, xy_later) & (inside[:, 0] > 0) for T in motions]
    best = int(np.argmax([flags.sum() for flags in ahead]))
    T, good = motions[best], ahead[best]
    if good.sum() < FEWEST:
        return None
    depths = along_rays(T, xy, xy_later)
    unit = float(np.median(depths[good]))
    T[:3, 3] *= unit
    rough = TwoViews(T, np.where(good, depths / unit, 1.0), np.full(len(xy), UNKNOWN_SPREAD), good)
    return _adjusted(rough, xy, xy_later, noise)


def _ahead(T: Array, xy: Array, xy_later: Array) -> NDArray[np.bool_]:
    """Which points (K,) lie before both cameras."""
    depths = along_rays(T, xy, xy_later)
    z = xy @ T[2, :2] + T[2, 2] + depths * T[2, 3]
    return np.asarray((depths > 0) & (z > 0))


def along_rays(T: Array, xy: Array, xy_later: Array) -> Array:
    """Inverse depths (K,) at which points of the first picture (K, 2) come nearest to where the
    second, at T (4, 4) in the first, sees them.
    """
    Rb = np.concatenate([xy, np.ones((len(xy), 1))], axis=1) @ T[:3, :3].T
    p = Rb[:, :2] - xy_later * Rb[:, 2:]
    q = T[:2, 3] - xy_later * T[2, 3]
    return np.asarray(-(p * q).sum(axis=1) / np.maximum((q * q).sum(axis=1), 1e-18))


def _adjusted(rough: TwoViews, xy: Array, xy_later: Array, noise: float) -> TwoViews | None:
    """The two pictures and all points, adjusted from a rough motion; None where too few points
    agree. The rest as of `two_views`."""
    count = len(xy)
    bundle = Bundle(
        Ts=np.stack([np.eye(4), rough.T]),
        free=np.array([False, True]),
        anchor=np.zeros(count, int),
        rays=xy,
        depths=rough.depths,
        mean=np.ones(count),
        spread=rough.spread,
        view=np.ones(count, int),
        point=np.arange(count),
        xy=xy_later,
        noise=noise,
    )
    bundle, spread = adjusted(bundle, STEPS)
    agree = (residual_lengths(bundle) < INLIER) & (bundle.depths > 0)
    if agree.mean() < LEAST_AGREE or agree.sum() < FEWEST:
        return None
    return TwoViews(bundle.Ts[1], bundle.depths, spread, agree)
