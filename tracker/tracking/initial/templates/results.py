"""Results of templates: a first trajectory, or the tracks of the ends of limbs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array


@dataclass(frozen=True, eq=False)
class Start:
    """A first trajectory of a segment, and notes for a person on what could not be followed."""

    trajectory: Trajectory
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class LimbTracks:
    """Where points of the body are seen in the N frames of a segment.

    A limb's end has two rows, the point of its surface that either keyframe shows.

    parts:    (L,) index of the part that each point belongs to.
    points:   (L, 3) the points in their parts' frames, metres.
    uv:       (L, N, 2) pixels of the working pictures; NaN where a point was lost.
    sigma_px: (L, N) how far a place may be wrong, one standard deviation; inf where lost.
    notes:    plain sentences about what was lost.
    """

    parts: NDArray[np.int64]
    points: Array
    uv: Array
    sigma_px: Array
    notes: tuple[str, ...]
