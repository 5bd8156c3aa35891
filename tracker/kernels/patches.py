"""The compiled loop of photo-consistency: how alike a place of a surface looks from all sides."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.kernels import compiled

Array = NDArray[np.float64]

HALF = 3
"""Patches have (2 · HALF + 1)² samples."""


@compiled
def correlate(
    vertices: Array,
    normals: Array,
    Ts: Array,
    lenses: Array,
    sizes: NDArray[np.int64],
    pictures: NDArray[np.uint8],
    nearness: NDArray[np.float32],
    spacing_px: float,
    slack_px: float,
    least_cosine: float,
    mean_zncc: Array,
    seen_by: NDArray[np.int64],
) -> None:
    """Write the mean ZNCC (V,) over pairs of views that see a vertex, and how many do (V,).

    pictures, nearness: (K, H, W) brightness, and 1/z of what each view sees first.
    spacing_px, slack_px: between samples of a patch, and by how much a vertex may lie behind what
                          is seen, both in pixels at the vertex's depth.
    The patch lies in the tangent plane. Of n unit patches the mean over pairs is
    (|Σ|² − n) / (n(n − 1)).  SURFACE §3.2
    """
    count = (2 * HALF + 1) ** 2
    patch, total = np.empty(count), np.empty(count)
    first, second = np.empty(3), np.empty(3)
    for i in range(vertices.shape[0]):
        p, normal = vertices[i], normals[i]
        n = 0
        total[:] = 0.0
        has_frame = _tangents(normal, first, second)
        size = _footprint(p, Ts, lenses)
        for k in range(Ts.shape[0]):
            if not has_frame:
                break
            if not _sees(
                p, normal, Ts[k], lenses[k], sizes[k], nearness[k], slack_px, least_cosine
            ):
                continue
            step = spacing_px * size
            if _sample(p, first, second, step, Ts[k], lenses[k], sizes[k], pictures[k], patch):
                n += 1
                for s in range(count):
                    total[s] += patch[s]
        seen_by[i] = n
        square = 0.0
        for s in range(count):
            square += total[s] * total[s]
        mean_zncc[i] = (square - n) / (n * (n - 1)) if n >= 2 else -1.0


@compiled
def _footprint(p: Array, Ts: Array, lenses: Array) -> float:
    """The size of a pixel at a place, metres, in the mean of the views before which it lies."""
    total, n = 0.0, 0
    for k in range(Ts.shape[0]):
        z = Ts[k, 2, 0] * p[0] + Ts[k, 2, 1] * p[1] + Ts[k, 2, 2] * p[2] + Ts[k, 2, 3]
        if z > 0:
            total += z / lenses[k, 0]
            n += 1
    return total / max(n, 1)


@compiled
def _tangents(normal: Array, first: Array, second: Array) -> bool:
    """Two unit vectors across a unit normal; False where there is none."""
    if normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2 < 0.5:
        return False
    least = 0
    for axis in range(1, 3):
        if abs(normal[axis]) < abs(normal[least]):
            least = axis
    for axis in range(3):
        first[axis] = (1.0 if axis == least else 0.0) - normal[least] * normal[axis]
    length = math.sqrt(first[0] ** 2 + first[1] ** 2 + first[2] ** 2)
    for axis in range(3):
        first[axis] /= length
    second[0] = normal[1] * first[2] - normal[2] * first[1]
    second[1] = normal[2] * first[0] - normal[0] * first[2]
    second[2] = normal[0] * first[1] - normal[1] * first[0]
    return True


@compiled
def _sees(
    p: Array,
    normal: Array,
    T: Array,
    lens: Array,
    size: NDArray[np.int64],
    nearness: NDArray[np.float32],
    slack_px: float,
    least_cosine: float,
) -> bool:
    """Whether a place turns to the view, lies in its picture, and nothing is before it."""
    x = T[0, 0] * p[0] + T[0, 1] * p[1] + T[0, 2] * p[2] + T[0, 3]
    y = T[1, 0] * p[0] + T[1, 1] * p[1] + T[1, 2] * p[2] + T[1, 3]
    z = T[2, 0] * p[0] + T[2, 1] * p[1] + T[2, 2] * p[2] + T[2, 3]
    if z <= 1e-6:
        return False
    toward = 0.0
    for axis in range(3):
        turned = T[axis, 0] * normal[0] + T[axis, 1] * normal[1] + T[axis, 2] * normal[2]
        toward -= turned * (x if axis == 0 else (y if axis == 1 else z))
    if toward < least_cosine * math.sqrt(x * x + y * y + z * z):
        return False
    u, v = lens[0] * x / z + lens[2], lens[1] * y / z + lens[3]
    if not (u >= 0 and v >= 0 and u < size[0] - 1 and v < size[1] - 1):
        return False
    front = nearness[int(v + 0.5), int(u + 0.5)]
    return z * front < 1.0 + slack_px / lens[0]


@compiled
def _sample(
    p: Array,
    first: Array,
    second: Array,
    step: float,
    T: Array,
    lens: Array,
    size: NDArray[np.int64],
    picture: NDArray[np.uint8],
    patch: Array,
) -> bool:
    """The brightness about a place, mean 0 and length 1; False where the picture ends before."""
    mean, s = 0.0, 0
    for a in range(-HALF, HALF + 1):
        for b in range(-HALF, HALF + 1):
            qx = p[0] + step * (a * first[0] + b * second[0])
            qy = p[1] + step * (a * first[1] + b * second[1])
            qz = p[2] + step * (a * first[2] + b * second[2])
            x = T[0, 0] * qx + T[0, 1] * qy + T[0, 2] * qz + T[0, 3]
            y = T[1, 0] * qx + T[1, 1] * qy + T[1, 2] * qz + T[1, 3]
            z = T[2, 0] * qx + T[2, 1] * qy + T[2, 2] * qz + T[2, 3]
            if z <= 1e-6:
                return False
            u, v = lens[0] * x / z + lens[2], lens[1] * y / z + lens[3]
            if not (u >= 0 and v >= 0 and u < size[0] - 1 and v < size[1] - 1):
                return False
            column, row = int(u), int(v)
            du, dv = u - column, v - row
            above = (1 - du) * picture[row, column] + du * picture[row, column + 1]
            below = (1 - du) * picture[row + 1, column] + du * picture[row + 1, column + 1]
            patch[s] = (1 - dv) * above + dv * below
            mean += patch[s]
            s += 1
    mean /= s
    square = 0.0
    for i in range(s):
        patch[i] -= mean
        square += patch[i] * patch[i]
    length = math.sqrt(square) + 1e-6
    for i in range(s):
        patch[i] /= length
    return True
