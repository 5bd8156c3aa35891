"""Find how a camera was turned from points of the background that a person matched."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.turn import Turn, linearised
from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array

STEPS = 20
SETTLED = 1e-10
FEWEST = 2
FEWEST_APART_PX = 4.0
MOST_STEP = 0.3


@dataclass(frozen=True, eq=False)
class Matched:
    """The rotation (3, 3) from one frame's camera into another's, the other's zoom, and what is
    left to each match (K,), pixels.
    """

    R_other_one: Array
    zoom: float
    error_px: Array


def rotation_from_matches(
    uv_one: Array, uv_other: Array, camera: Camera, zoom: float = 1.0, zooms: bool = True
) -> Matched:
    """Find how the camera was turned from one frame to another in which the same points of the
    background were marked, pixels (K, 2) of each.

    zoom: of the first frame.  zooms: whether the other may have another. Two points or more,
    not at one place; CameraError otherwise, or where no turn explains them.
    """
    one, other = (np.asarray(uv, dtype=float).reshape(-1, 2) for uv in (uv_one, uv_other))
    if len(one) != len(other) or len(one) < FEWEST:
        raise CameraError("Mark at least two points of the background in both frames.")
    if min(np.ptp(uv, axis=0).max() for uv in (one, other)) < FEWEST_APART_PX:
        raise CameraError("The marked points lie in one place: mark points that are farther apart.")
    lens, turn = Lens.of(camera), Turn.none()
    directions = lens.directions(one, zoom)
    for _ in range(STEPS):
        seen = lens.flat(other, zoom * turn.zoom) / zoom
        residual, J = linearised(turn, directions, seen, lens.focal_px * zoom)
        used = 4 if zooms else 3
        step, *_ = np.linalg.lstsq(J[..., :used].reshape(-1, used), residual.ravel(), rcond=None)
        if not np.isfinite(step).all():
            break
        step = np.pad(step, (0, 4 - used))
        turn = turn.moved(step * min(1.0, MOST_STEP / max(np.abs(step).max(), 1e-12)))
        if np.abs(step).max() < SETTLED:
            error = np.linalg.norm(residual, axis=1)
            return Matched(turn.R, zoom * turn.zoom, error)
    raise CameraError("No turn of the camera explains these points: check that each is the same.")
