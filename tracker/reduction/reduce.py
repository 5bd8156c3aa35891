"""A dense motion reduced to keyframes: which frames, and what interpolation makes of them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial
from itertools import pairwise

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import ReductionError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, frozen
from keypose.tracker.reduction.compare import Comparison, Frames
from keypose.tracker.reduction.fewest import fewest_frames
from keypose.tracker.reduction.result import LEAST_M, Every, Goal, Reduction, Tolerance
from keypose.tracker.reduction.spread import spread_frames


def reduce_motion(
    skeleton: Skeleton,
    camera: Camera,
    motion: Trajectory,
    goal: Goal,
    required: Collection[int] = (),
    parts: Collection[int] | None = None,
    progress: Callable[[int, int], None] = lambda done, expected: None,
) -> Reduction:
    """The fewest frames from which `interpolate` makes a motion again, to a tolerance; or, of one
    in so many frames, those from which it does so best.

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
    tolerance = goal if isinstance(goal, Tolerance) else None
    comparison = Comparison(skeleton, camera, motion, tolerance, chosen)
    frames = np.flatnonzero(comparison.known)
    if len(frames) < 2:
        raise ReductionError(
            f"A motion needs poses at two frames to be reduced to keyframes; this one has "
            f"{'one' if len(frames) else 'none'}."
        )
    fixed = _required(comparison, required)
    ends = sorted({int(frames[0]), int(frames[-1]), *fixed})
    report = partial(_report, progress, len(frames))
    if isinstance(goal, Every):
        kept = spread_frames(comparison, frames, ends, goal.frames, report)
    else:
        kept = _fewest(comparison, frames, ends, report)
    return _reduction(comparison, kept)


def reduced_to(
    skeleton: Skeleton, camera: Camera, motion: Trajectory, frames: Sequence[int]
) -> Reduction:
    """A motion reduced to given frames of the video, ascending, each with a pose."""
    comparison = Comparison(skeleton, camera, motion)
    return _reduction(comparison, [frame - motion.first_frame for frame in frames])


def _reduction(comparison: Comparison, kept: Sequence[int]) -> Reduction:
    first, tolerance = comparison.motion.first_frame, comparison.tolerance
    misses = _misses(comparison, kept)
    if tolerance is None:  # the misses are in metres
        tolerance = Tolerance(max(float(np.nanmax(misses)), LEAST_M))
        misses = misses / tolerance.metres
    return Reduction(tuple(first + n for n in kept), first, frozen(misses), tolerance)


def _fewest(
    comparison: Comparison, frames: Frames, ends: Sequence[int], report: Callable[[int], None]
) -> list[int]:
    """The fewest frames, through all of the ends."""
    kept = [ends[0]]
    for a, b in pairwise(ends):
        between = frames[(frames >= a) & (frames <= b)]
        before = int((frames < a).sum())
        kept += fewest_frames(comparison, between, partial(_after, report, before))[1:]
    return kept


def _after(report: Callable[[int], None], before: int, reached: int) -> None:
    report(before + reached)


def _misses(comparison: Comparison, kept: Sequence[int]) -> Array:
    """(N,) of every frame."""
    misses, known = np.full(len(comparison.motion), np.nan), comparison.known
    misses[kept] = 0.0
    for a, b in pairwise(kept):
        misses[a + 1 : b] = np.where(known[a + 1 : b], comparison.misses(a, b), np.nan)
    return misses


def _report(progress: Callable[[int, int], None], expected: int, done: int) -> None:
    progress(done, expected)


def _required(comparison: Comparison, frames: Collection[int]) -> set[int]:
    """Frames of the video as counted from the motion's first."""
    motion = comparison.motion
    for frame in frames:
        n = frame - motion.first_frame
        if not (0 <= n < len(motion) and comparison.known[n]):
            raise ReductionError(f"Frame {frame} is a keyframe, but the motion has no pose there.")
    return {frame - motion.first_frame for frame in frames}
