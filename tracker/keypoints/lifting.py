"""A person's joints in space from keypoints of a film: a small network looks at a second of them.

Joints are relative to the middle of the hips and in body sizes: one film says neither how far away
nor how tall a person is. Before a look the picture is turned so that the middle of the hips lies
straight ahead, at each frame anew; a camera that moves, or is turned after a person, sees the same.
After J. Martinez and others, *A simple yet effective baseline for 3D human pose estimation*, 2017,
and D. Pavllo and others, *3D human pose estimation in video with temporal convolutions and
semi-supervised training*, 2019. How it was trained is in `bench/lift`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from keypose.tracker.errors import KeypointError, listed
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.model_files import LIFTER, verified
from keypose.tracker.keypoints.runtimes import Runtime, Tensor, open_runtime

_LEG: Final = ("hip", "knee", "ankle", "foot_index")
_ARM: Final = ("shoulder", "elbow", "wrist")
POINTS: Final = (
    *(f"right_{name}" for name in _LEG),
    *(f"left_{name}" for name in _LEG),
    "head",
    *(f"right_{name}" for name in _ARM),
    *(f"left_{name}" for name in _ARM),
)
"""What the network sees; head is the middle of the ears."""
LIFTED: Final = (*POINTS, "neck")
"""What it answers with: centres of joints, the toes, the middle of the ears, and the base of the
neck, between the shoulders."""
OFFSETS_S: Final = np.array([-14, -9, -5, -2, 0, 2, 5, 9, 14]) / 30
"""Of the moments it sees from the one it answers for, seconds."""
MIDDLE: Final = 4
"""Of these, the one it answers for."""
HIPS: Final = (POINTS.index("right_hip"), POINTS.index("left_hip"))
_SHOULDERS: Final = (POINTS.index("right_shoulder"), POINTS.index("left_shoulder"))
OTHER_SIDE: Final = (4, 5, 6, 7, 0, 1, 2, 3, 8, 12, 13, 14, 9, 10, 11, 15)
"""Of each of `LIFTED`, the same of the other side."""

LEAST_VISIBILITY: Final = 0.1
"""Keypoints less visible are not shown to it. Those of hidden joints are mostly near the truth: a
walk, squats and a man on a beam come out 4, 0 and 8 mm better with 0.1 than with 0.3, and 5, 1 and
18 mm better than with 0.6."""
_SAME_S: Final = 1e-4
"""Moments so near are the same."""
LONGEST_GAP_S: Final = 0.2
"""Between two frames in which a keypoint is seen, over which it is interpolated."""
LEAST_POINTS: Final = 4
"""Seen in a frame; of fewer nothing is said."""
_MOST_AT_ONCE: Final = 2048
"""Frames, some 100 MB."""

_LOG_SCALE: Final = 2.0
"""Added to the logarithm of a figure's size, which is about −2 for a whole body 4 m away."""
_ACROSS: Final = 0.38
"""Body sizes across the view, of the root mean square of a figure's points."""
_LOG_SIGMA: Final = -2.5
_LEAST = -6.0
_MOST = 1.0
"""Logarithm of a usual deviation in body sizes, and how far from it one may lie."""
NETWORKS: Final = ("first", "second")
"""Trained alike from other beginnings; where they disagree, neither is to be believed."""


@dataclass(frozen=True, eq=False)
class Lifted:
    """Joints in body sizes, from the middle of the hips, in the axes of the camera at each frame.

    A body size is thigh and shin, mean of both sides, and the way from the middle of the hips to
    that of the shoulders.

    first_frame: of the video.
    names:       of the J joints, `LIFTED`.
    p_hips:      (N, J, 3), x right, y down, z away; NaN where too little is seen.
    sigma:       (N, J, 2) standard deviation across the line of sight, along each of the two axes,
                 and along it; NaN where p_hips is.
    hips:        (N, 2) the middle of the hips in the plane at distance 1, bridged where it is
                 hidden for a moment.
    """

    first_frame: int
    names: tuple[str, ...]
    p_hips: Array
    sigma: Array
    hips: Array

    def __len__(self) -> int:
        return len(self.p_hips)


def lifted(
    keypoints: Keypoints,
    camera: Camera,
    times_s: ArrayLike,
    up_camera: ArrayLike | None = None,
) -> Lifted:
    """The joints in space of a person whose keypoints these are.

    times_s: (N,) of the frames, rising, in seconds; of any rate.
    up_camera: (3,) or (N, 3) what is up, in the camera's axes; None where it is not known to some
        4°: 10° off harm more than not to know it.
    KeypointError where keypoints are not those of a person, or times do not fit.
    """
    times = np.asarray(times_s, dtype=np.float64)
    if (
        times.shape != (len(keypoints),)
        or not np.isfinite(times).all()
        or (np.diff(times) <= 0).any()
    ):
        raise KeypointError(
            f"Times of {len(keypoints)} frames, each later than the one before, are needed to lift "
            "keypoints into space."
        )
    if not len(keypoints):
        return Lifted(
            keypoints.first_frame,
            LIFTED,
            np.empty((0, 16, 3)),
            np.empty((0, 16, 2)),
            np.empty((0, 2)),
        )
    xy, is_seen = _points(keypoints, camera)
    hips = _hips(xy, is_seen, times)
    is_seen &= np.isfinite(hips).all(axis=1, keepdims=True)
    Rs_turned_camera = turns(hips)
    if camera.telephoto_distance_m is not None:  # lines of sight are parallel
        Rs_turned_camera, xy = np.broadcast_to(np.eye(3), (len(times), 3, 3)), xy - hips[:, None]
    else:
        xy = turned(xy, Rs_turned_camera)
    up = _ups(up_camera, Rs_turned_camera)
    p_hips = np.full((len(times), len(LIFTED), 3), np.nan)
    sigma = np.full((len(times), len(LIFTED), 2), np.nan)
    enough = np.nonzero(is_seen.sum(axis=1) >= LEAST_POINTS)[0]
    for first in range(0, len(enough), _MOST_AT_ONCE):
        frames = enough[first : first + _MOST_AT_ONCE]
        p_turned, sigma[frames] = both_ways(*_windows(xy, is_seen, times, frames), up[frames])
        p_hips[frames] = p_turned @ Rs_turned_camera[frames]
    return Lifted(keypoints.first_frame, LIFTED, p_hips, sigma, hips)


def _points(keypoints: Keypoints, camera: Camera) -> tuple[Array, NDArray[np.bool_]]:
    """The network's points (N, 15, 2) in the plane at distance 1, and which are seen."""
    missing = [name for name in JOINTS if name not in keypoints.names]
    if missing:
        raise KeypointError(
            f"These keypoints have no {listed(missing)}: only a person's can be lifted into space."
        )
    visible = np.isfinite(keypoints.uv).all(axis=2) & (keypoints.visibility > LEAST_VISIBILITY)
    # of a telephoto camera the directions all are one, and the places in that plane are the same
    plane = camera.model_copy(update={"projection": "perspective", "telephoto_distance_m": None})
    xy = np.full((len(keypoints), len(POINTS), 2), np.nan)
    for k, name in enumerate(POINTS):
        parts = ("left_ear", "right_ear") if name == "head" else (name,)
        if all(part in keypoints.names for part in parts):
            at = [keypoints.names.index(part) for part in parts]
            uv = keypoints.uv[:, at].mean(axis=1)
            shown = visible[:, at].all(axis=1)
            xy[shown, k] = plane.back_project(uv[shown], 1.0)[:, :2]
    return xy, np.isfinite(xy).all(axis=2)


def _hips(xy: Array, is_seen: NDArray[np.bool_], times: Array) -> Array:
    """The middle of the hips (N, 2), interpolated where one is unseen; NaN far from where both
    are seen."""
    both = is_seen[:, HIPS].all(axis=1)
    middle = np.asarray(xy[:, HIPS].mean(axis=1))
    if not both.any():
        return middle
    at = times[both]
    filled = np.column_stack([np.interp(times, at, middle[both, axis]) for axis in (0, 1)])
    after = np.searchsorted(at, times)
    before, after = np.maximum(after - 1, 0), np.minimum(after, len(at) - 1)
    nearest = np.minimum(np.abs(times - at[before]), np.abs(times - at[after]))
    return np.asarray(np.where((nearest <= OFFSETS_S[-1])[:, None], filled, np.nan))


def turns(hips: Array) -> Array:
    """Rotations (..., 3, 3) to the axes of a camera that looks at a point (..., 2) of the plane at
    distance 1, x as level in the picture as it was."""
    ahead = np.concatenate([hips, np.ones_like(hips[..., :1])], axis=-1)
    z = ahead / np.linalg.norm(ahead, axis=-1, keepdims=True)
    x = np.stack([z[..., 2], np.zeros_like(z[..., 0]), -z[..., 0]], axis=-1)
    x = x / np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=-2)


def turned(xy: Array, R_turned_camera: Array) -> Array:
    """Points (..., K, 2) of the plane at distance 1 as a turned camera sees them."""
    rays = xy @ np.swapaxes(R_turned_camera[..., :2], -1, -2) + R_turned_camera[..., None, :, 2]
    return np.asarray(rays[..., :2] / rays[..., 2:])


def _windows(
    xy: Array, is_seen: NDArray[np.bool_], times: Array, frames: NDArray[np.intp]
) -> tuple[Array, NDArray[np.bool_]]:
    """What is seen (F, 9, 15, 2) around each of F frames, and which of it is."""
    moments = times[frames, None] + OFFSETS_S
    points = np.zeros((*moments.shape, len(POINTS), 2))
    shown = np.zeros(points.shape[:-1], np.bool_)
    for k in range(len(POINTS)):
        at, places = times[is_seen[:, k]], xy[is_seen[:, k], k]
        if not len(at):
            continue
        after = np.searchsorted(at, moments - _SAME_S)
        is_there = np.abs(at[np.minimum(after, len(at) - 1)] - moments) <= _SAME_S
        before = np.where(is_there, after, after - 1)
        between = (before >= 0) & (after < len(at))
        before, after = before * between, after * between
        gap = at[after] - at[before]
        share = np.divide(moments - at[before], gap, out=np.zeros_like(gap), where=gap > 0)[
            ..., None
        ]
        points[:, :, k] = places[before] * (1 - share) + places[after] * share
        shown[:, :, k] = between & (gap <= LONGEST_GAP_S)
    return points, shown


def _ups(up_camera: ArrayLike | None, Rs_turned_camera: Array) -> Array:
    """What is up (N, 3) in turned axes; 0 where unknown."""
    count = len(Rs_turned_camera)
    if up_camera is None:
        return np.zeros((count, 3))
    up = np.broadcast_to(np.asarray(up_camera, dtype=np.float64), (count, 3))
    length = np.linalg.norm(up, axis=1, keepdims=True)
    unit = np.divide(up, length, out=np.zeros((count, 3)), where=length > 0)
    return np.asarray(np.nan_to_num(np.einsum("nij,nj->ni", Rs_turned_camera, unit)))


# --- what the network is shown, and what it answers


def encoded(points: Array, shown: NDArray[np.bool_], up: Array) -> Tensor:
    """The network's input (N, 410).

    points: (N, 9, 15, 2) in the plane at distance 1, the middle of the hips at 0.
    shown: (N, 9, 15) which of them are seen.  up: (N, 3) unit vectors, 0 where unknown.
    """
    weight = shown.astype(np.float32)
    xy = points.astype(np.float32) * weight[..., None]
    count = np.maximum(weight.sum(axis=(1, 2)), 1.0)
    size = np.sqrt(np.maximum((xy**2).sum(axis=(1, 2, 3)) / count, 1e-8))
    has_up = np.linalg.norm(up, axis=1, keepdims=True) > 0
    rows = len(points)
    return np.concatenate(
        [
            (xy / size[:, None, None, None]).reshape(rows, -1),
            weight.reshape(rows, -1),
            np.log(size)[:, None] + _LOG_SCALE,
            up,
            has_up,
        ],
        axis=1,
        dtype=np.float32,
    )


INPUTS: Final = len(OFFSETS_S) * len(POINTS) * 3 + 5
OUTPUTS: Final = len(LIFTED) * 5 + 1
_SEEN_NOW: Final = slice(MIDDLE * len(POINTS) * 2, (MIDDLE + 1) * len(POINTS) * 2)
"""Of the input, the points of the moment it answers for."""


def decoded(inputs: Tensor, outputs: Tensor) -> tuple[Array, Array]:
    """Joints (N, 16, 3) in body sizes, in turned axes, and their deviation (N, 16, 2) across the
    line of sight and along it; of outputs (N, 81)."""
    each = outputs[:, :-1].reshape(len(outputs), len(LIFTED), 5).astype(np.float64)
    uv_now = inputs[:, _SEEN_NOW].reshape(len(inputs), len(POINTS), 2)
    neck = uv_now[:, _SHOULDERS].mean(axis=1, keepdims=True)
    scale = _ACROSS * np.exp(np.clip(outputs[:, -1:, None], -2, 2))
    p = each[..., :3].copy()
    p[..., :2] += np.concatenate([uv_now, neck], axis=1) * scale
    # Laplace's scale times the root of 2 is the standard deviation
    sigma = np.sqrt(2) * np.exp(np.clip(each[..., 3:], _LEAST, _MOST) + _LOG_SIGMA)
    return p, sigma


def both_ways(points: Array, shown: NDArray[np.bool_], up: Array) -> tuple[Array, Array]:
    """Joints (N, 16, 3) and their deviation (N, 16, 2), in turned axes, of what `encoded` takes.

    Joints are the mean of what each network answers to what is seen and to its mirror image. Their
    deviation is what they say and how far they disagree, which is far where a motion is unlike the
    training.
    """
    order = list(OTHER_SIDE)
    mirror = np.array([-1.0, 1.0, 1.0])
    inputs = [
        encoded(points, shown, up),
        encoded(points[:, :, order[:-1]] * mirror[:2], shown[:, :, order[:-1]], up * mirror),
    ]
    count = len(points)
    places, sigmas = [], []
    for output in _network().run(np.concatenate(inputs).T[:, :, None]):
        rows = output.reshape(OUTPUTS, 2 * count).T
        p, sigma = decoded(inputs[0], rows[:count])
        p_mirrored, sigma_mirrored = decoded(inputs[1], rows[count:])
        places += [p, p_mirrored[:, order] * mirror]
        sigmas += [sigma, sigma_mirrored[:, order]]
    variance = np.var(places, axis=0)
    apart = np.sqrt(np.stack([variance[..., :2].mean(axis=-1), variance[..., 2]], axis=-1))
    return np.mean(places, axis=0), np.hypot(np.mean(sigmas, axis=0), apart)


@cache
def _network() -> Runtime:
    return open_runtime(LIFTER.file, verified(LIFTER), NETWORKS, fast=False)
