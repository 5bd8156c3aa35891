"""Resample a motion at other times, or low-pass filter it with zero phase.

The filter is the one of movement science: a Butterworth filter of second order forward and back,
together of fourth order and without delay, 3 dB down at the cut-off. (A filter that is designed
for 6 Hz and run forward and back is 6 dB down there, and 3 dB at 4.8 Hz.) Forward and back it is
one symmetric kernel of weights. A position becomes the weighted mean of its neighbours, a rotation
their weighted mean on the group of rotations: the M with Σ w log(Mᵀ R) = 0. So a steady turn stays
itself however often it goes round, no frame of reference is preferred, and, since rotations and the
root alone are filtered, bones keep their lengths exactly. Beyond an end a motion is continued by
its reflection through that end, R₀ Rⱼᵀ R₀, which leaves the end where it was.

Between two frames it follows the cubic through them and one neighbour on each side, by the times
they are shown at: of positions, and of rotations as rotation vectors from the earlier of the two.
It meets every frame exactly, and a steady motion stays steady. Where a part turns so far from frame
to frame that neighbours determine nothing, it turns evenly about one axis.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import (
    Array,
    exp_rotation,
    log_rotation,
    nearest_rotation,
    quaternion_wxyz,
    rotation_from_quaternion,
    transpose,
)

ORDER = 2
"""Of the filter that runs forward and back."""

LEAST_WEIGHT = 1e-4
"""Of the largest: the kernel ends where its weights stay below."""

LONGEST_NEAR_HALF_RATE = 500
"""Frames that a kernel may reach beside those of its cut-off: near half the rate it rings."""

CLOSE_RAD = 1e-9
MOST_STEPS = 30
"""When a mean of rotations counts as found, and how many steps that may take."""

FRAMES_AT_ONCE = 256
"""Of rotations, which bounds the memory."""


def low_pass_kernel(cutoff_hz: float, rate: float) -> Array:
    """The weights (2K + 1,), symmetric, their sum 1, for `rate` frames a second.

    ValueError unless the cut-off lies between 0 and half the rate, where it would mean something.
    """
    from scipy.signal import butter, sosfiltfilt  # loads longer than all the page needs to start

    if not 0.0 < cutoff_hz < rate / 2:
        raise ValueError("the cut-off must lie between 0 and half the rate")
    # Two passes are 3 dB down where one is 1.5; the tangent is the bilinear transform's warp.
    one_pass = np.tan(np.pi * cutoff_hz / rate) / (np.sqrt(2.0) - 1.0) ** (1 / (2 * ORDER))
    sections = butter(ORDER, 2.0 / np.pi * np.arctan(one_pass), output="sos")
    half = int(np.ceil(4.0 * rate / cutoff_hz)) + LONGEST_NEAR_HALF_RATE
    impulse = np.zeros(2 * half + 1)
    impulse[half] = 1.0
    weights = sosfiltfilt(sections, impulse, padlen=0)
    reach = int(np.flatnonzero(np.abs(weights[half:]) > LEAST_WEIGHT * weights[half])[-1])
    kept = weights[half - reach : half + reach + 1]
    kept = (kept + kept[::-1]) / 2
    return np.asarray(kept / kept.sum())


def least_frames(cutoff_hz: float, rate: float) -> int:
    """How many frames a motion must have to be filtered: a period of the cut-off."""
    return max(int(np.ceil(rate / cutoff_hz)), 3) + 1


def filtered_positions(ps: Array, kernel: Array) -> Array:
    """Positions (N, ...) of consecutive frames, at least two."""
    reach = len(kernel) // 2
    edges = ((reach, reach), *((0, 0),) * (ps.ndim - 1))
    continued = np.pad(ps, edges, mode="reflect", reflect_type="odd")
    windows = np.lib.stride_tricks.sliding_window_view(continued, len(kernel), axis=0)
    return np.asarray(windows @ kernel)


def filtered_rotations(Rs: Array, kernel: Array) -> Array:
    """Rotations (N, ..., 3, 3) of consecutive frames, at least two."""
    q = quaternion_wxyz(_continued(Rs, len(kernel) // 2))
    means = []
    for start in range(0, len(Rs), FRAMES_AT_ONCE):
        count = min(FRAMES_AT_ONCE, len(Rs) - start)
        means.append(_means(q[start : start + count + len(kernel) - 1], kernel))
    return nearest_rotation(np.concatenate(means))


def _continued(Rs: Array, reach: int) -> Array:
    """Reflected through both ends by so many frames, again and again where they are few."""
    while reach > 0:
        count = min(reach, len(Rs) - 1)
        before = Rs[0] @ np.swapaxes(Rs[count:0:-1], -1, -2) @ Rs[0]
        after = Rs[-1] @ np.swapaxes(Rs[-2 : -count - 2 : -1], -1, -2) @ Rs[-1]
        Rs, reach = np.concatenate([before, Rs, after]), reach - count
    return Rs


def _means(q: Array, kernel: Array) -> Array:
    """Weighted means (n, ..., 3, 3) of quaternions (n + 2K, ..., 4)."""
    reach = len(kernel) // 2
    count = len(q) - 2 * reach
    around = np.stack([q[j : j + count] for j in range(len(kernel))])
    mean = rotation_from_quaternion(q[reach : reach + count])
    for _ in range(MOST_STEPS):
        step = np.tensordot(kernel, _logs(quaternion_wxyz(mean), around), axes=1)
        mean = mean @ exp_rotation(step)
        if np.abs(step).max(initial=0.0) < CLOSE_RAD:
            break
    return mean


def _logs(mean: Array, around: Array) -> Array:
    """Rotation vectors (2K + 1, n, ..., 3) from the mean to each, running on past half a turn."""
    w, v = mean[..., :1], -mean[..., 1:]
    real = w[..., 0] * around[..., 0] - (v * around[..., 1:]).sum(axis=-1)
    imaginary = w * around[..., 1:] + around[..., :1] * v + np.cross(v, around[..., 1:])
    sign = np.where(real < 0, -1.0, 1.0)
    length = np.linalg.norm(imaginary, axis=-1)
    angle = 2 * np.arctan2(length, np.abs(real))
    per_length = np.where(length > 1e-12, angle / np.maximum(length, 1e-12), 2.0)
    logs = imaginary * (sign * per_length)[..., None]
    middle = len(logs) // 2
    for step in (1, -1):
        for j in range(middle + step, middle + step * (middle + 1), step):
            logs[j] = _nearest_turns(logs[j - step], logs[j])
    return np.asarray(logs)


def _nearest_turns(before: Array, now: Array) -> Array:
    """The rotation vector (..., 3) with the full turns that bring it nearest to the one before."""
    angle = np.linalg.norm(now, axis=-1, keepdims=True)
    aside = np.linalg.norm(before, axis=-1, keepdims=True)
    axis = np.where(angle > 1e-9, now / np.maximum(angle, 1e-9), before / np.maximum(aside, 1e-9))
    turns = np.round(((before * axis).sum(axis=-1, keepdims=True) - angle) / (2 * np.pi))
    return np.asarray(now + 2 * np.pi * turns * axis)


FARTHEST_RAD = 3.0
"""Where neighbours turn by more than this, frame by frame, together, cubics do not resolve them:
half a turn has no direction."""


def resampled(Rs: Array, ps: Array, times_s: Array, wanted_s: Array) -> tuple[Array, Array]:
    """Rotations (M, ..., 3, 3) and positions (M, 3) at `wanted_s` (M,), within the N times.

    Rs (N, ..., 3, 3), ps (N, 3), times_s (N,) ascending; N is at least two.
    """
    before = np.clip(np.searchsorted(times_s, wanted_s, side="right") - 1, 0, len(times_s) - 2)
    near = _neighbours(before, len(times_s))
    cubic = _weights(times_s[near], wanted_s)
    positions = np.einsum("mk,mk...->m...", cubic, ps[near])
    start = Rs[before]
    turns = log_rotation(transpose(start)[:, None] @ Rs[near])
    steps = np.linalg.norm(log_rotation(transpose(Rs[:-1]) @ Rs[1:]), axis=-1)
    far = steps[near[:, :-1]].sum(axis=1) > FARTHEST_RAD
    pair = np.stack([before, before + 1], axis=1)
    linear = _weights(times_s[pair], wanted_s)[:, 1]
    straight = log_rotation(transpose(start) @ Rs[before + 1])
    share = linear.reshape(-1, *(1,) * (straight.ndim - 1))
    curved = np.einsum("mk,mk...->m...", cubic, turns)
    return start @ exp_rotation(np.where(far[..., None], share * straight, curved)), positions


def _neighbours(before: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """(M, 4) the frames that a cubic goes through, or as many as there are."""
    width = min(4, count)
    first = np.clip(before - 1, 0, count - width)
    return np.asarray(first[:, None] + np.arange(width))


def _weights(times_s: Array, wanted_s: Array) -> Array:
    """(M, K) Lagrange's weights of K times (M, K)."""
    width = times_s.shape[1]
    weights = np.ones_like(times_s)
    for k in range(width):
        for i in range(width):
            if i != k:
                weights[:, k] *= (wanted_s - times_s[:, i]) / (times_s[:, k] - times_s[:, i])
    return weights
