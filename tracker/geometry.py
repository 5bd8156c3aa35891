"""Rotations and rigid transforms on stacked arrays.

Rotations are 3×3 matrices in the last two axes, rotation vectors (axis times angle, radians) in the
last axis; every leading axis is a batch axis. `T_a_b` is a 4×4 matrix that maps points of frame b
to frame a.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

Array: TypeAlias = NDArray[np.float64]


def frozen(values: ArrayLike) -> Array:
    """A read-only float copy, so that a result cannot change under those who hold it."""
    array = np.array(values, dtype=np.float64, order="C")
    array.setflags(write=False)
    return array


def transpose(matrices: Array) -> Array:
    """Swap the last two axes."""
    return np.swapaxes(matrices, -1, -2)


def exp_rotation(vectors: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3) of rotation vectors (..., 3)."""
    vectors = np.asarray(vectors, dtype=np.float64)
    flat = Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix()
    return flat.reshape(*vectors.shape[:-1], 3, 3)


def log_rotation(rotations: ArrayLike) -> Array:
    """Rotation vectors (..., 3) of rotation matrices (..., 3, 3), angles in [0, pi]."""
    rotations = np.asarray(rotations, dtype=np.float64)
    flat = Rotation.from_matrix(rotations.reshape(-1, 3, 3)).as_rotvec()
    return flat.reshape(*rotations.shape[:-2], 3)


def nearest_rotation(matrices: ArrayLike) -> Array:
    """Nearest rotations in the Frobenius norm: the polar factor with determinant +1."""
    u, _, vt = np.linalg.svd(np.asarray(matrices, dtype=np.float64))
    u[..., -1] *= np.linalg.det(u @ vt)[..., None]
    return u @ vt


def rotation_from_euler(z: float, y: float, x: float) -> Array:
    """Qz(z) Qy(y) Qx(x), radians: the order in which a part's pose is written (DRIFT §2.1)."""
    return np.asarray(Rotation.from_euler("ZYX", [z, y, x]).as_matrix(), dtype=np.float64)


def euler_from_rotation(rotations: ArrayLike) -> Array:
    """Angles (..., 3) as [z, y, x] in radians with R = Qz Qy Qx; y within ±pi/2."""
    rotations = np.asarray(rotations, dtype=np.float64)
    flat = Rotation.from_matrix(rotations.reshape(-1, 3, 3)).as_euler("ZYX", suppress_warnings=True)
    return flat.reshape(*rotations.shape[:-2], 3)


def quaternion_wxyz(rotation: ArrayLike) -> Array:
    """Unit quaternions (..., 4), scalar first and not negative."""
    rotation = np.asarray(rotation, dtype=np.float64)
    xyzw = Rotation.from_matrix(rotation.reshape(-1, 3, 3)).as_quat(canonical=True)
    return np.roll(xyzw, 1, axis=-1).reshape(*rotation.shape[:-2], 4)


def rotation_from_quaternion(wxyz: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3) of quaternions (..., 4), scalar first, any positive length."""
    wxyz = np.asarray(wxyz, dtype=np.float64)
    flat = Rotation.from_quat(np.roll(wxyz.reshape(-1, 4), -1, axis=-1)).as_matrix()
    return flat.reshape(*wxyz.shape[:-1], 3, 3)


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
