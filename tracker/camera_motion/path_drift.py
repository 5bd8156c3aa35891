"""Pull poses so that they meet those that are known, and bridge those that are not."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array, rotation_between, transform, transpose


def pulled(Ts: Array, frames: Sequence[int], wanted: Array) -> Array:
    """Poses (N, 4, 4) that are `wanted` (M, 4, 4) at some frames, in order. What these are off by,
    turn and place in the world, is shared out evenly between them, and is the same beyond them.
    """
    Rs, ps = _placed(Ts)
    Rs_wanted, ps_wanted = _placed(wanted)
    at = np.asarray(frames)
    turn, shift = transpose(Rs[at]) @ Rs_wanted, ps_wanted - ps[at]
    every = np.arange(len(Ts))
    after = np.clip(np.searchsorted(at, every, side="right"), 1, max(len(at) - 1, 1))
    before, after = after - 1, np.minimum(after, len(at) - 1)
    share = (every - at[before]) / np.maximum(at[after] - at[before], 1)
    share = np.clip(share, 0.0, 1.0)
    R = np.stack(
        [
            rotation_between(turn[i], turn[j], [s])[0]
            for i, j, s in zip(before, after, share, strict=True)
        ]
    )
    R = Rs @ R
    p = ps + (1 - share)[:, None] * shift[before] + share[:, None] * shift[after]
    out = transform(R, -(R @ p[..., None])[..., 0])
    out[at] = wanted
    return out


def bridged(Ts: Array, known: NDArray[np.bool_]) -> Array:
    """Poses (N, 4, 4), those that are not known on the straight way between their neighbours that
    are, or as these at the ends.
    """
    at = np.flatnonzero(known)
    if not len(at) or len(at) == len(Ts):
        return Ts
    out = Ts.copy()
    out[: at[0]], out[at[-1] :] = Ts[at[0]], Ts[at[-1]]
    for i, j in pairwise(at.tolist()):
        if j > i + 1:
            Rs, ps = _placed(Ts[[i, j]])
            shares = np.arange(1, j - i) / (j - i)
            R = rotation_between(Rs[0], Rs[1], shares)
            p = ps[0] + shares[:, None] * (ps[1] - ps[0])
            out[i + 1 : j] = transform(R, -(R @ p[..., None])[..., 0])
    return out


def _placed(Ts: Array) -> tuple[Array, Array]:
    """Rs_camera_world (N, 3, 3), and the camera's places (N, 3) in the world."""
    R = Ts[:, :3, :3]
    return R, -np.einsum("nba,nb->na", R, Ts[:, :3, 3])
