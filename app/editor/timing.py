"""When the steps of observed surfaces are: evenly, so many a second."""

from __future__ import annotations

import numpy as np

from tracker.geometry.rotations import Array, frozen
from tracker.session.schema import Keyframe, Surface


def times_of(surface: Surface, frame_count: int) -> Array:
    """(frame_count,) seconds."""
    return frozen(np.arange(frame_count) / surface.fps)


def retimed(poses: tuple[Keyframe, ...], surface: Surface) -> tuple[Keyframe, ...]:
    """Poses at the times their frames have by it."""
    return tuple(
        pose.model_copy(update={"time_s": float(pose.frame / surface.fps)}) for pose in poses
    )
