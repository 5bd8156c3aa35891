"""Rotations as 3×3 arrays, written in place: the loops allocate nothing.

Arrays are copied by element: for `out[:] = a` numba compiles the words of a shape error as well,
which every loop that calls this one would compile again.
"""

from __future__ import annotations

import math

import numpy as np

from keypose.tracker.kernels import compiled


@compiled
def put(a, out):
    """out = a, both (3, 3)."""
    for i in range(3):
        for k in range(3):
            out[i, k] = a[i, k]


@compiled
def put_place(p, out):
    """out = p, both (3,)."""
    for i in range(3):
        out[i] = p[i]


@compiled
def put_pose(R, t, R_out, t_out):
    """R_out, t_out = R, t, (P, 3, 3) and (3,)."""
    for i in range(R.shape[0]):
        put(R[i], R_out[i])
    put_place(t, t_out)


@compiled
def product(a, b, out):
    """out = a b."""
    for i in range(3):
        for k in range(3):
            out[i, k] = a[i, 0] * b[0, k] + a[i, 1] * b[1, k] + a[i, 2] * b[2, k]


@compiled
def turned_back(a, b, out):
    """out = aᵀ b."""
    for i in range(3):
        for k in range(3):
            out[i, k] = a[0, i] * b[0, k] + a[1, i] * b[1, k] + a[2, i] * b[2, k]


@compiled
def exponential(v, out):
    """out = the rotation by ‖v‖ radians about v."""
    square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
    angle = math.sqrt(square)
    if angle < 1e-6:
        a, b = 1 - square / 6, 0.5 - square / 24
    else:
        a, b = math.sin(angle) / angle, (1 - math.cos(angle)) / square
    x, y, z = v[0], v[1], v[2]
    out[0, 0] = 1 - b * (y * y + z * z)
    out[0, 1] = b * x * y - a * z
    out[0, 2] = b * x * z + a * y
    out[1, 0] = b * x * y + a * z
    out[1, 1] = 1 - b * (x * x + z * z)
    out[1, 2] = b * y * z - a * x
    out[2, 0] = b * x * z - a * y
    out[2, 1] = b * y * z + a * x
    out[2, 2] = 1 - b * (x * x + y * y)


@compiled
def logarithm(R, out):
    """out = the rotation vector of R, its angle in [0, pi]."""
    out[0] = R[2, 1] - R[1, 2]
    out[1] = R[0, 2] - R[2, 0]
    out[2] = R[1, 0] - R[0, 1]
    sine = 0.5 * math.sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2])
    cosine = 0.5 * (R[0, 0] + R[1, 1] + R[2, 2] - 1)
    angle = math.atan2(sine, cosine)
    if math.pi - angle > 1e-2:
        scale = 0.5 * angle / sine if sine > 1e-9 else 0.5
        for i in range(3):
            out[i] *= scale
        return
    # Near a half turn the difference R − Rᵀ fades; the axis is the strongest column of R + Rᵀ.
    k = 0
    for i in range(1, 3):
        if R[i, i] > R[k, k]:
            k = i
    axis = np.empty(3)
    length = 0.0
    for i in range(3):
        axis[i] = 0.5 * (R[i, k] + R[k, i]) - (cosine if i == k else 0.0)
        length += axis[i] * axis[i]
    side = out[0] * axis[0] + out[1] * axis[1] + out[2] * axis[2]
    scale = (angle if side >= 0 else -angle) / math.sqrt(length)
    for i in range(3):
        out[i] = scale * axis[i]


@compiled
def cleaned(R):
    """One Newton step toward the nearest rotation: R ← R (3 I − RᵀR)/2, in place."""
    square = np.empty((3, 3))
    turned_back(R, R, square)
    for i in range(3):
        for k in range(3):
            square[i, k] *= -0.5
        square[i, i] += 1.5
    copy = R.copy()
    product(copy, square, R)


@compiled
def compose(R, v, scratch):
    """R ← R exp(v), in place and kept a rotation; `scratch` is (2, 3, 3)."""
    exponential(v, scratch[0])
    product(R, scratch[0], scratch[1])
    put(scratch[1], R)
    cleaned(R)
