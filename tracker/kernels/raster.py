"""The compiled z-buffer.

A corner is (x, y, z) in metres in the frame that is looked from; a projection is the six numbers
(kind, fx, fy, cx, cy, reference): PERSPECTIVE divides by z, PARALLEL by the one reference distance.
What is linear over the picture is 1/z in the first case and z in the second, so the buffer holds a
nearness, 1/z or −z, which grows toward the eye and is interpolated without any division.
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.kernels import compiled
from keypose.tracker.kernels.rigid import put_place

Array: TypeAlias = NDArray[np.float64]

PERSPECTIVE = 0.0
PARALLEL = 1.0
"""Kinds of projections."""


@compiled
def fill(
    corners: Array,
    faces: NDArray[np.int64],
    projection: Array,
    near: float,
    nearness: NDArray[np.float32],
    shown: NDArray[np.int32],
) -> None:
    """Draw triangles into `nearness` (H, W) and `shown` (H, W), the index of the face seen.

    corners (V, 3), faces (F, 3) indices into them. The buffers come in as −inf and −1. What lies
    nearer than z = near is cut away.
    """
    inside = np.empty((4, 3))
    flat = np.empty((4, 3))
    for k in range(faces.shape[0]):
        count = _clipped(corners, faces[k], near, inside)
        for i in range(count):
            _project(inside[i], projection, flat[i])
        for i in range(1, count - 1):
            _fill_triangle(flat[0], flat[i], flat[i + 1], k, nearness, shown)


@compiled
def _clipped(corners: Array, face: NDArray[np.int64], near: float, inside: Array) -> int:
    """Write the corners (at most 4) of the part of a face with z ≥ near; give their number."""
    count = 0
    for i in range(3):
        a, b = corners[face[i]], corners[face[(i + 1) % 3]]
        if a[2] >= near:
            put_place(a, inside[count])
            count += 1
        if (a[2] >= near) != (b[2] >= near):
            share = (near - a[2]) / (b[2] - a[2])
            for axis in range(2):
                inside[count, axis] = a[axis] + share * (b[axis] - a[axis])
            inside[count, 2] = near
            count += 1
    return count


@compiled
def _project(p: Array, projection: Array, flat: Array) -> None:
    perspective = projection[0] == PERSPECTIVE
    divisor = p[2] if perspective else projection[5]
    flat[0] = projection[1] * p[0] / divisor + projection[3]
    flat[1] = projection[2] * p[1] / divisor + projection[4]
    flat[2] = 1.0 / p[2] if perspective else -p[2]


@compiled
def _fill_triangle(
    a: Array,
    b: Array,
    c: Array,
    label: int,
    nearness: NDArray[np.float32],
    shown: NDArray[np.int32],
) -> None:
    """Fill one triangle, its corners (u, v, nearness), row by row; edges belong to it."""
    height, width = nearness.shape
    area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
    if not abs(area) > 1e-12:  # also turns NaN away
        return
    slope_u = ((b[2] - a[2]) * (c[1] - a[1]) - (c[2] - a[2]) * (b[1] - a[1])) / area
    slope_v = ((c[2] - a[2]) * (b[0] - a[0]) - (b[2] - a[2]) * (c[0] - a[0])) / area
    first_row = math.ceil(max(min(a[1], b[1], c[1]), 0.0))
    last_row = math.floor(min(max(a[1], b[1], c[1]), height - 1.0))
    for row in range(first_row, last_row + 1):
        left, right = _span(a, b, c, float(row))
        first = math.ceil(max(left - 1e-9, 0.0))
        last = math.floor(min(right + 1e-9, width - 1.0))
        value = a[2] + slope_v * (row - a[1]) - slope_u * a[0]
        for column in range(first, last + 1):
            here = np.float32(value + slope_u * column)
            if here > nearness[row, column]:
                nearness[row, column] = here
                shown[row, column] = label


@compiled
def _span(a: Array, b: Array, c: Array, row: float) -> tuple[float, float]:
    """Where a horizontal line enters and leaves a triangle; (inf, −inf) for a miss."""
    left, right = np.inf, -np.inf
    for start, end in ((a, b), (b, c), (c, a)):
        low, high = min(start[1], end[1]), max(start[1], end[1])
        if low > row or high < row:
            continue
        if low == high:
            left, right = min(left, start[0], end[0]), max(right, start[0], end[0])
            continue
        u = start[0] + (row - start[1]) / (end[1] - start[1]) * (end[0] - start[0])
        left, right = min(left, u), max(right, u)
    return left, right
