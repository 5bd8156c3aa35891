"""Find how a camera was turned from points of the background that a person matched."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.turn import Turn, linearised
from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.gauss_newton import GAUSS_NEWTON, gauss_newton

CRITERIA = replace(GAUSS_NEWTON, most_steps=20, settled=1e-10, longest_step=0.3)
"""From any turn that two frames of one film can have between them, to the last digits."""
FEWEST = 2
FEWEST_APART_PX = 4.0


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
    lens, unknowns = Lens.of(camera), 4 if zooms else 3
    directions = lens.directions(one, zoom)

    def linearised_at(turn: Turn) -> tuple[Array, Array]:
        seen = lens.flat(other, zoom * turn.zoom) / zoom
        return linearised(turn, directions, seen, lens.focal_px * zoom)

    def step(turn: Turn, count: int) -> Array:  # noqa: ARG001
        residual, J = linearised_at(turn)
        solved, *_ = np.linalg.lstsq(J[..., :unknowns].reshape(-1, unknowns), residual.ravel())
        return np.pad(solved, (0, 4 - unknowns))

    solution = gauss_newton(step, Turn.moved, Turn.none(), CRITERIA)
    if solution.end != "settled":
        raise CameraError(
            "No turn of the camera explains these points: check that each is the same."
        )
    turn = solution.state
    error_px = np.linalg.norm(linearised_at(turn)[0], axis=1)
    return Matched(turn.R, zoom * turn.zoom, error_px)
