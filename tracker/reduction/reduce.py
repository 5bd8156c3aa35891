"""A dense motion reduced to keyframes: which frames, and what interpolation makes of them."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from tracker.body.skeleton import Skeleton
from tracker.body.trajectory import Trajectory
from tracker.errors import ReductionError
from tracker.geometry.camera import Camera
from tracker.geometry.rotations import Array, frozen
from tracker.reduction.compare import Comparison, Tolerance
from tracker.reduction.fewest import fewest_frames


@dataclass(frozen=True, eq=False)
class Reduction:
    """The frames of a motion to keep as keyframes.

    frames:    of the video, ascending.
    first_frame: of the motion.
    misses:    (N,) for every frame of the motion how far the point of the body that is farthest
        off is from the motion where it is interpolated between the keyframes, as a share of the
        tolerance; 0 at keyframes, NaN where the motion has no pose.
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
    def known_count(self) -> int:
        """Frames with a pose."""
        return int(np.isfinite(self.misses).sum())

    @property
    def frames_per_keyframe(self) -> float:
        """Frames that one keyframe stands for."""
        return (self.frames[-1] - self.frames[0]) / max(len(self.frames) - 1, 1)


def reduce_motion(
    skeleton: Skeleton,
    camera: Camera,
    motion: Trajectory,
    tolerance: Tolerance,
    required: Collection[int] = (),
    parts: Collection[int] | None = None,
    progress: Callable[[int, int], None] = lambda done, expected: None,
) -> Reduction:
    """The fewest frames from which `interpolate` makes a motion again, to a tolerance.

    The first and the last frame with a pose are among them. No fewer keyframes with poses of the
    motion do; of as few, these have the least sum of squared misses. Frames without a pose, NaN in
    the motion, are no keyframes and are not compared.

    camera: for tolerances in the picture.  required: frames of the video that are keyframes anyway.
    parts: those that are interpolated and compared, all where None; the others move as they do.
    progress: is given how many frames are reached, of how many; what it raises ends the work.
    ReductionError in one sentence where fewer than two frames have a pose, or a required one has
    none.
    """
    chosen = None if parts is None else frozenset(parts)
    comparison = Comparison(skeleton, camera, motion, tolerance, chosen)
    frames = np.flatnonzero(comparison.known)
    if len(frames) < 2:
        raise ReductionError(
            f"A motion needs poses at two frames to be reduced to keyframes; this one has "
            f"{'one' if len(frames) else 'none'}."
        )
    fixed = _required(comparison, required)
    ends = sorted({int(frames[0]), int(frames[-1]), *fixed})
    kept, misses = [ends[0]], np.full(len(motion), np.nan)
    for a, b in pairwise(ends):
        between = frames[(frames >= a) & (frames <= b)]
        before = int((frames < a).sum())
        tell = partial(_tell, progress, before, len(frames))
        kept += fewest_frames(comparison, between, tell)[1:]
    misses[kept] = 0.0
    for a, b in pairwise(kept):
        misses[a + 1 : b] = np.where(comparison.known[a + 1 : b], comparison.misses(a, b), np.nan)
    first = motion.first_frame
    return Reduction(tuple(first + n for n in kept), first, frozen(misses), tolerance)


def _tell(progress: Callable[[int, int], None], before: int, expected: int, done: int) -> None:
    progress(before + done, expected)


def _required(comparison: Comparison, frames: Collection[int]) -> set[int]:
    """Frames of the video as counted from the motion's first."""
    motion = comparison.motion
    for frame in frames:
        n = frame - motion.first_frame
        if not (0 <= n < len(motion) and comparison.known[n]):
            raise ReductionError(f"Frame {frame} is a keyframe, but the motion has no pose there.")
    return {frame - motion.first_frame for frame in frames}


def require_range(motion: Trajectory, first: int, last: int) -> Trajectory:
    """The frames of a motion from first to last; ReductionError where it has not all of them."""
    if not motion.first_frame <= first <= last <= motion.last_frame:
        raise ReductionError(
            f"The motion has frames {motion.first_frame} to {motion.last_frame}: choose a range "
            "within them."
        )
    rows = slice(first - motion.first_frame, last - motion.first_frame + 1)
    return Trajectory(first, motion.Rs_parent_part[rows], motion.ps_camera_root[rows])
