"""The compiled loop that colours a drawn mesh, pixel by pixel."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.kernels import compiled

Array: TypeAlias = NDArray[np.float64]


@compiled
def colour(
    corners: Array,
    faces: NDArray[np.int64],
    rgb: NDArray[np.float32],
    lens: Array,
    inside: float,
    shown: NDArray[np.int32],
    picture: NDArray[np.uint8],
) -> None:
    """Colour the pixels of `picture` (H, W, 3) in which `shown` (H, W) has a face, not −1.

    corners (V, 3) in the frame that is looked from; rgb (V, 3), 0 to 255, runs linearly over each
    face (F, 3). lens: fx, fy, cx, cy. A face seen from behind is `inside` times as bright.

    A point of a face is a mix of its corners, so [a b c] · shares = depth · ray: the shares are
    those of the inverse, whose rows are cross products but for a factor, made to sum to 1.
    """
    for row in range(shown.shape[0]):
        y = (row - lens[3]) / lens[1]
        before = -1
        for column in range(shown.shape[1]):
            k = shown[row, column]
            if k < 0:
                continue
            if k != before:
                i, j, m = faces[k, 0], faces[k, 1], faces[k, 2]
                a, b, c = corners[i], corners[j], corners[m]
                bc0, bc1, bc2 = _cross(b, c)
                ca0, ca1, ca2 = _cross(c, a)
                ab0, ab1, ab2 = _cross(a, b)
                bright = inside if a[0] * bc0 + a[1] * bc1 + a[2] * bc2 > 0.0 else 1.0
                before = k
            x = (column - lens[2]) / lens[0]
            s = abs(bc0 * x + bc1 * y + bc2)
            t = abs(ca0 * x + ca1 * y + ca2)
            u = abs(ab0 * x + ab1 * y + ab2)
            total = s + t + u
            if total > 0.0:
                s, t, u = s / total, t / total, u / total
            else:
                s, t, u = 1.0, 0.0, 0.0
            for channel in range(3):
                value = s * rgb[i, channel] + t * rgb[j, channel] + u * rgb[m, channel]
                picture[row, column, channel] = np.uint8(bright * value)


@compiled
def _cross(a: Array, b: Array) -> tuple[float, float, float]:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )
