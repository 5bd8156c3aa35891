"""A dense motion reduced to keyframes: which frames, and what interpolation makes of them."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial
from itertools import pairwise

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import ReductionError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import frozen
from keypose.tracker.reduction.compare import Comparison
from keypose.tracker.reduction.fewest import fewest_frames
from keypose.tracker.reduction.result import Reduction, Tolerance


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
        report = partial(_report, progress, before, len(frames))
        kept += fewest_frames(comparison, between, report)[1:]
    misses[kept] = 0.0
    for a, b in pairwise(kept):
        misses[a + 1 : b] = np.where(comparison.known[a + 1 : b], comparison.misses(a, b), np.nan)
    first = motion.first_frame
    return Reduction(tuple(first + n for n in kept), first, frozen(misses), tolerance)


def _report(progress: Callable[[int, int], None], before: int, expected: int, done: int) -> None:
    progress(before + done, expected)


def _required(comparison: Comparison, frames: Collection[int]) -> set[int]:
    """Frames of the video as counted from the motion's first."""
    motion = comparison.motion
    for frame in frames:
        n = frame - motion.first_frame
        if not (0 <= n < len(motion) and comparison.known[n]):
            raise ReductionError(f"Frame {frame} is a keyframe, but the motion has no pose there.")
    return {frame - motion.first_frame for frame in frames}
