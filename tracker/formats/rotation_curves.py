"""Make rotations run smoothly over time, for programs that interpolate or draw their numbers.

A rotation has many triples [z, y, x] with R = Qz·Qy·Qx: any angle may gain a full turn, and
(z + π, π − y, x + π) is the same rotation as (z, y, x). Where y is a quarter turn, only the sum or
the difference of z and x counts. Of all these, as of both signs of a quaternion, the one nearest to
the frame before is taken.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array, euler_from_rotation, quaternion_wxyz


def smooth_quaternions_xyzw(rotations: Array) -> NDArray[np.float32]:
    """(N, B, 4) of rotations (N, B, 3, 3) of consecutive frames: of the two that are one rotation,
    the one nearer to the frame before; the first frame's w is not negative."""
    q = quaternion_wxyz(rotations)
    turned = np.where((q[1:] * q[:-1]).sum(axis=-1, keepdims=True) < 0, -1.0, 1.0)
    q[1:] *= np.cumprod(turned, axis=0)
    return np.roll(q, -1, axis=-1).astype(np.float32)


LOCKED = 1e-8
"""cos y below which z and x turn about one axis, to the precision of any file."""

FULL_TURN = 2 * np.pi

NEAR_POLE = np.sin(np.radians(45.0))
"""sin y from which on z and x turn about nearly one axis: half a turn of both is no turn of the
part, which only passes beside the pole, and whole turns are no part's if they add up there."""


def smooth_euler(rotations: Array) -> Array:
    """[z, y, x] (N, ..., 3), radians, of rotations (N, ..., 3, 3) of consecutive frames.

    The first frame has the usual triple, with y within ±pi/2.
    """
    angles = euler_from_rotation(rotations)
    for before, now in pairwise(angles):
        now[...] = _nearest(before, now)
    return angles


def known_smooth_euler(rotations: Array) -> Array:
    """[z, y, x] (N, ..., 3), radians, smooth over the frames that are known, also across a gap; NaN
    of the others. Whole turns that z and x gain by passing the pole are taken back where they pass
    it; those of a part that does turn stay."""
    angles = np.full(rotations.shape[:-1], np.nan)
    is_known = np.isfinite(rotations).reshape(len(rotations), -1).all(axis=1)
    smooth = smooth_euler(rotations[is_known])
    for part in np.ndindex(smooth.shape[1:-1]):
        _take_turns_back(smooth[(slice(None), *part)])
    angles[is_known] = smooth
    return angles


def _take_turns_back(angles: Array) -> None:
    """Bring z and x of [z, y, x] (N, 3) back to within half a turn in the mean after every pass of
    the pole, in place; the step is where the part is nearest to it."""
    height = np.abs(np.sin(angles[:, 1]))
    edges = np.flatnonzero(np.diff(height > NEAR_POLE)) + 1
    runs = [range(*ends) for ends in pairwise([0, *edges.tolist(), len(angles)])]
    for passed, after in pairwise(runs):
        if len(passed) and height[passed[0]] > NEAR_POLE:
            at = passed[0] + int(np.argmax(height[passed]))
            turns = np.round(angles[after][:, [0, 2]].mean(axis=0) / FULL_TURN)
            angles[at:, [0, 2]] -= FULL_TURN * turns


def _nearest(before: Array, now: Array) -> Array:
    """The triple (..., 3) equivalent to `now` that is nearest to `before`."""
    z, y, x = np.moveaxis(now, -1, 0)
    equivalent = np.stack([z + np.pi, np.pi - y, x + np.pi], axis=-1)
    both = np.stack([_nearest_turns(before, now), _nearest_turns(before, equivalent)])
    distance = np.square(both - before).sum(axis=-1)
    nearer = np.where((distance[1] < distance[0])[..., None], both[1], both[0])
    locked = np.abs(np.cos(y)) < LOCKED
    return np.where(locked[..., None], _nearest_locked(before, nearer), nearer)


def _nearest_turns(before: Array, now: Array) -> Array:
    """Every angle with the full turns that bring it nearest to the one before."""
    return np.asarray(now + FULL_TURN * np.round((before - now) / FULL_TURN))


def _nearest_locked(before: Array, now: Array) -> Array:
    """A locked triple with z and x as near to those before as their common turn allows."""
    sign = np.where(np.sin(now[..., 1]) > 0, -1.0, 1.0)  # where sin y is 1, x − z counts
    miss = (now[..., 2] + sign * now[..., 0]) - (before[..., 2] + sign * before[..., 0])
    half = (miss - FULL_TURN * np.round(miss / FULL_TURN)) / 2
    y = now[..., 1]
    return np.stack([before[..., 0] + sign * half, y, before[..., 2] + half], axis=-1)
