"""What a reduction is asked for, and what it gives; loads none of the compiled loops."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import ReductionError
from keypose.tracker.geometry.rotations import Array

LEAST_M = 1e-4
LEAST_PX = 0.01
"""The smallest tolerances: below, rounding of a file's numbers would ask for every frame."""


@dataclass(frozen=True)
class Tolerance:
    """How far interpolation may lead any point of the body away from the motion.

    metres: in space.  pixels: in the picture, of an ideal lens. Infinite where one does not count.
    """

    metres: float = 0.02
    pixels: float = math.inf

    def __post_init__(self) -> None:
        if not (self.metres >= LEAST_M and self.pixels >= LEAST_PX):
            raise ReductionError(
                f"The tolerance must be at least {1000 * LEAST_M:g} mm, or {LEAST_PX:g} pixels."
            )
        if math.isinf(self.metres) and math.isinf(self.pixels):
            raise ReductionError("The tolerance must be given in space or in the picture.")


@dataclass(frozen=True)
class Every:
    """One keyframe in about so many frames, where interpolation misses the motion least."""

    frames: int

    def __post_init__(self) -> None:
        if self.frames < 1:
            raise ReductionError("One keyframe in how many frames? It must be at least 1.")


Goal: TypeAlias = Tolerance | Every


@dataclass(frozen=True, eq=False)
class Reduction:
    """The frames of a motion to keep as keyframes.

    frames:    of the video, ascending.
    first_frame: of the motion.
    misses:    (N,) for every frame of the motion how far the point of the body that is farthest
        off is from the motion where it is interpolated between the keyframes, as a share of the
        tolerance; 0 at keyframes, NaN where the motion has no pose.
    tolerance: that was asked for; else the largest miss.
    """

    frames: tuple[int, ...]
    first_frame: int
    misses: Array
    tolerance: Tolerance

    @property
    def worst(self) -> float:
        """The largest miss, as a share of the tolerance."""
        return float(np.nanmax(self.misses))

    @property
    def worst_m(self) -> float:
        """The largest miss in space, metres; infinite where the tolerance is in the picture."""
        return self.worst * self.tolerance.metres

    @property
    def worst_px(self) -> float:
        """The largest miss in the picture, pixels; infinite where the tolerance is in space."""
        return self.worst * self.tolerance.pixels

    @property
    def known_count(self) -> int:
        """Frames with a pose."""
        return int(np.isfinite(self.misses).sum())

    @property
    def frames_per_keyframe(self) -> float:
        """Frames that one keyframe stands for."""
        return (self.frames[-1] - self.frames[0]) / max(len(self.frames) - 1, 1)


def require_range(motion: Trajectory, first: int, last: int) -> Trajectory:
    """The frames of a motion from first to last; ReductionError where it has not all of them."""
    if not motion.first_frame <= first <= last <= motion.last_frame:
        raise ReductionError(
            f"The motion has frames {motion.first_frame} to {motion.last_frame}: choose a range "
            "within them."
        )
    rows = slice(first - motion.first_frame, last - motion.first_frame + 1)
    return Trajectory(first, motion.Rs_parent_part[rows], motion.ps_camera_root[rows])
