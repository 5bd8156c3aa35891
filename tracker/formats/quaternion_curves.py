"""Quaternions that run smoothly over time, for programs that interpolate them number by number."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array, quaternion_wxyz


def smooth_quaternions_xyzw(rotations: Array) -> NDArray[np.float32]:
    """(N, B, 4) of rotations (N, B, 3, 3) of consecutive frames: of the two that are one rotation,
    the one nearer to the frame before; the first frame's w is not negative."""
    q = quaternion_wxyz(rotations)
    turned = np.where((q[1:] * q[:-1]).sum(axis=-1, keepdims=True) < 0, -1.0, 1.0)
    q[1:] *= np.cumprod(turned, axis=0)
    return np.roll(q, -1, axis=-1).astype(np.float32)
