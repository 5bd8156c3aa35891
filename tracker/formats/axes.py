"""The axes of files whose y points up: x right, y up, z toward the camera, whose origin is theirs.

It is the camera frame turned by half a turn about x, F = diag(1, −1, −1). A part's frame is turned
likewise: a point of it becomes F p, a rotation F R F.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.geometry.rotations import Array

FLIP = np.array([1.0, -1.0, -1.0])
"""The diagonal of F."""


def flipped(points: Array) -> Array:
    """Points (..., 3) in the file's frames instead of ours."""
    return np.asarray(points * FLIP)
