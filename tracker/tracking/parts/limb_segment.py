"""A limb alone as a segment: between two frames at which it is known, on a body that is tracked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, interpolate
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.tracking.parts.closing import with_limb
from keypose.tracker.tracking.segment import Segment


@dataclass(frozen=True, eq=False, kw_only=True)
class LimbSegment(Segment):
    """A segment in which nothing but a limb, of these parts (k,), may move otherwise than in a
    motion that is given, which is where the limb belongs at both ends."""

    given: Trajectory
    parts: NDArray[np.int64]

    def set_right(self, whole: Segment) -> list[int]:
        """The frames of its ends that are no keyframes of the whole segment."""
        keyframes = (whole.first_frame, whole.last_frame)
        return [n for n in (self.first_frame, self.last_frame) if n not in keyframes]

    def interpolated(self) -> Trajectory:
        """The given motion, the limb's turns interpolated."""
        even = interpolate(self.start, self.end, self.first_frame, self.last_frame)
        return with_limb(self.given, even, self.parts, self.start, self.end)

    def expected(self, Rs: Array, ps: Array, n: int) -> Pose:
        """The nth pose of the given motion, the limb turned as in the last one."""
        R = Rs[n].copy()
        R[self.parts] = Rs[n - 1, self.parts]
        return Pose(R, ps[n])


def other_side(skeleton: Skeleton, parts: NDArray[np.int64]) -> list[int]:
    """The parts that mirror these."""
    names, body = {skeleton.body.names[i] for i in parts}, skeleton.body
    pairs = [*body.mirror_pairs, *((b, a) for a, b in body.mirror_pairs)]
    return [body.index(other) for one, other in pairs if one in names]
