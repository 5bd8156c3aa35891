"""Find how a camera was turned from points of the background that a person matched."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.turn import SeenDirections, Turn, linearised
from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.gauss_newton import GAUSS_NEWTON, gauss_newton

CRITERIA = replace(GAUSS_NEWTON, most_steps=20, settled=1e-10, longest_step=0.3)
"""From any turn that two frames of one film can have between them, to the last digits."""
FEWEST = 2
"""Points that tell a turn and a zoom: each has two coordinates."""
LEAST_APART_PX = 4.0
"""Along the picture's longer way between points; closer ones tell no roll."""


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
    """Find how the camera was turned from one frame to another by points that are marked in both.

    Args:
        uv_one: (K, 2) pixels of points of the background in the one frame.
        uv_other: (K, 2) pixels of the same points in the other.
        camera: its lens at zoom 1.
        zoom: of the one frame.
        zooms: whether the other may have another zoom.

    Raises:
        CameraError: with fewer than two points, where they lie at one place, or where no turn
            explains them.
    """
    uv_one, uv_other = (np.asarray(uv, dtype=float).reshape(-1, 2) for uv in (uv_one, uv_other))
    if len(uv_one) != len(uv_other) or len(uv_one) < FEWEST:
        raise CameraError("Mark at least two points of the background in both frames.")
    if min(np.ptp(uv, axis=0).max() for uv in (uv_one, uv_other)) < LEAST_APART_PX:
        raise CameraError("The marked points lie in one place: mark points that are farther apart.")
    lens, unknowns = Lens.of(camera), 4 if zooms else 3
    directions = lens.directions(uv_one, zoom)

    def linearised_at(turn: Turn) -> tuple[Array, Array]:
        xy = lens.flat(uv_other, zoom * turn.zoom) / zoom
        return linearised(turn, SeenDirections.trusted(directions, xy, lens.focal_px * zoom))

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
