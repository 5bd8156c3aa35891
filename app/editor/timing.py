"""When the steps of observed surfaces are: evenly, so many a second."""

from __future__ import annotations

from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.references import Surface


def retimed(poses: tuple[Keyframe, ...], surface: Surface) -> tuple[Keyframe, ...]:
    """Poses at the times their frames have by it."""
    return tuple(
        pose.model_copy(update={"time_s": float(pose.frame / surface.fps)}) for pose in poses
    )
