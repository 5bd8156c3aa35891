"""Rotations and rigid transforms on stacked arrays.

Rotations are 3×3 matrices in the last two axes, rotation vectors (axis times angle, radians) in the
last axis; every leading axis is a batch axis. `T_a_b` is a 4×4 matrix that maps points of frame b
to frame a.

Written here because SciPy makes each matrix orthogonal first, and takes 30 times as long for Euler
angles.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array: TypeAlias = NDArray[np.float64]


def frozen(values: ArrayLike) -> Array:
    """A read-only float copy, so that results cannot be changed later."""
    array = np.array(values, dtype=np.float64, order="C")
    array.setflags(write=False)
    return array


def transpose(matrices: Array) -> Array:
    """Swap the last two axes."""
    return np.swapaxes(matrices, -1, -2)


def exp_rotation(vectors: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3) of rotation vectors (..., 3): Rodrigues' formula."""
    v = np.asarray(vectors, dtype=np.float64)
    half_turns = np.linalg.norm(v, axis=-1)[..., None, None] / np.pi
    K = np.zeros((*v.shape, 3))
    K[..., 2, 1], K[..., 0, 2], K[..., 1, 0] = v[..., 0], v[..., 1], v[..., 2]
    K = K - transpose(K)
    R: Array = np.eye(3) + np.sinc(half_turns) * K + 0.5 * np.sinc(half_turns / 2) ** 2 * (K @ K)
    return R


def log_rotation(rotations: ArrayLike) -> Array:
    """Rotation vectors (..., 3) of rotation matrices (..., 3, 3), angles in [0, pi]."""
    q = quaternion_wxyz(rotations)
    length = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(length, q[..., :1])
    return q[..., 1:] * np.where(length > 1e-9, angle / np.maximum(length, 1e-9), 2.0)


def nearest_rotation(matrices: ArrayLike) -> Array:
    """Nearest rotations in the Frobenius norm: the polar factor with determinant +1."""
    u, _, vt = np.linalg.svd(np.asarray(matrices, dtype=np.float64))
    u[..., -1] *= np.linalg.det(u @ vt)[..., None]
    return np.asarray(u @ vt)


def rotation_from_euler(z: float, y: float, x: float) -> Array:
    """Qz(z) Qy(y) Qx(x), radians: the order in which a part's pose is written (DRIFT §2.1)."""
    Qz, Qy, Qx = exp_rotation(np.diag([z, y, x])[:, ::-1])
    return np.asarray(Qz @ Qy @ Qx)


def euler_from_rotation(rotations: ArrayLike) -> Array:
    """Angles (..., 3) as [z, y, x] in radians with R = Qz Qy Qx; y within ±pi/2.

    Where y is a quarter turn, z and x turn about the same axis; x is then 0.
    """
    R = np.asarray(rotations, dtype=np.float64)
    y = np.arctan2(-R[..., 2, 0], np.hypot(R[..., 0, 0], R[..., 1, 0]))
    locked = np.hypot(R[..., 0, 0], R[..., 1, 0]) < 1e-9
    z = np.arctan2(
        np.where(locked, -R[..., 0, 1], R[..., 1, 0]), np.where(locked, R[..., 1, 1], R[..., 0, 0])
    )
    x = np.where(locked, 0.0, np.arctan2(R[..., 2, 1], R[..., 2, 2]))
    return np.stack([z, y, x], axis=-1)


def quaternion_wxyz(rotation: ArrayLike) -> Array:
    """Unit quaternions (..., 4), scalar first and not negative.

    4 q qᵀ is linear in the matrix; its row with the largest diagonal gives q without cancellation.
    """
    R = np.asarray(rotation, dtype=np.float64)
    Q = np.empty((*R.shape[:-2], 4, 4))
    xx, yy, zz = (R[..., i, i] for i in range(3))
    Q[..., 0, 0] = 1 + xx + yy + zz
    Q[..., 1, 1] = 1 + xx - yy - zz
    Q[..., 2, 2] = 1 - xx + yy - zz
    Q[..., 3, 3] = 1 - xx - yy + zz
    for k, (a, b) in enumerate(((2, 1), (0, 2), (1, 0)), 1):
        Q[..., 0, k] = Q[..., k, 0] = R[..., a, b] - R[..., b, a]
    for a, b in ((0, 1), (0, 2), (1, 2)):
        Q[..., a + 1, b + 1] = Q[..., b + 1, a + 1] = R[..., a, b] + R[..., b, a]
    best = np.diagonal(Q, axis1=-2, axis2=-1).argmax(axis=-1)
    q = np.take_along_axis(Q, best[..., None, None], axis=-2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return np.asarray(np.where(q[..., :1] < 0, -q, q))


def rotation_from_quaternion(wxyz: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3) of quaternions (..., 4), scalar first, any positive length."""
    q = np.asarray(wxyz, dtype=np.float64)
    w, x, y, z = np.moveaxis(q / np.linalg.norm(q, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def rotation_between(start: Array, end: Array, shares: Sequence[float] | Array) -> Array:
    """Rotations on the one-axis path from `start` to `end`, (S, ..., 3, 3) for S shares.

    Share 0 is the start and share 1 the end; both are given back to rounding.
    """
    turn = log_rotation(transpose(start) @ end)
    steps = np.asarray(shares, dtype=np.float64).reshape((-1,) + (1,) * turn.ndim)
    return start @ exp_rotation(steps * turn)


def transform(rotation: Array, position: Array) -> Array:
    """T (..., 4, 4) of a rotation (..., 3, 3) and the position (..., 3) of its origin."""
    T = np.zeros((*rotation.shape[:-2], 4, 4))
    T[..., :3, :3] = rotation
    T[..., :3, 3] = position
    T[..., 3, 3] = 1.0
    return T


def apply_transform(T_a_b: Array, p_b: Array) -> Array:
    """Points (..., N, 3) of frame b in frame a."""
    return p_b @ transpose(T_a_b[..., :3, :3]) + T_a_b[..., None, :3, 3]
