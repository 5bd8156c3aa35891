"""Reduce a dense motion to keyframes, by their number or by a tolerance.

By a tolerance: a frame leads to a later one where interpolation between the two is within the
tolerance everywhere between. What is wanted is the path from the first frame to the last over the
fewest frames, and of those the one with the least sum of squared misses: dynamic programming over
layers, the frames that are reached in one interval, in two, and so on. A frame's layer depends on
the layer before alone, so each pair of frames is compared once at most, most of them by one part of
one pose; sums are computed on the shortest paths only. No bound on the length of an interval is
needed, and the answer is exact. Lengthening an interval may bring it back within the tolerance, so
no bisection would be.

By their number, for a motion that is kept between its keyframes: they are where it is held when it
is edited. Of all paths over so many intervals the one with the least sum of
squared misses, by dynamic programming over the number of intervals. None is much longer than
others, since a motion that repeats itself would be missed by as much over one of its rounds as over
many.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from functools import partial
from itertools import pairwise

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import ReductionError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array, frozen
from keypose.tracker.reduction.compare import Comparison, Frames
from keypose.tracker.reduction.result import LEAST_M, Every, Goal, Reduction, Tolerance

FEWEST_AT_A_TIME = 256
"""Frames compared between two looks at whether the work was cancelled."""


def fewest_frames(
    comparison: Comparison,
    frames: Frames,
    progress: Callable[[int], None] = lambda reached: None,
) -> list[int]:
    """The frames of the path, of these ascending ones, from the first of them to the last.

    progress: is given the number of frames that are reached; what it raises ends the work.
    """
    layers = [frames[:1]]
    left = frames[1:]
    while layers[-1][-1] != frames[-1]:
        if comparison.reached(layers[-1], frames[-1:])[0]:
            layers.append(frames[-1:])
            break
        is_reached = _reached(comparison, layers[-1], left, progress, len(frames) - len(left))
        layers.append(left[is_reached])
        left = left[~is_reached]
    return _cheapest(comparison, layers, int(frames[-1]))


def _reached(
    comparison: Comparison, froms: Frames, tos: Frames, progress: Callable[[int], None], before: int
) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    is_reached = np.zeros(len(tos), dtype=np.bool_)
    for start in range(0, len(tos), FEWEST_AT_A_TIME):
        rows = slice(start, start + FEWEST_AT_A_TIME)
        is_reached[rows] = comparison.reached(froms, tos[rows])
        progress(before + int(is_reached.sum()))
    return is_reached


def _cheapest(comparison: Comparison, layers: list[Frames], last: int) -> list[int]:
    """Find of the shortest paths the one with the least sum, from the last layer back
    to the first.
    """
    goals, costs = np.array([last], dtype=np.int64), np.zeros(1)
    ways: list[dict[int, int]] = []
    for layer in layers[-2::-1]:
        sums: Array = comparison.costs(layer, goals) + costs
        best = sums.argmin(axis=1)
        least = sums[np.arange(len(layer)), best]
        on_path = np.isfinite(least)
        ways.append(dict(zip(layer.tolist(), goals[best].tolist(), strict=True)))
        goals, costs = layer[on_path], least[on_path]
    path = [int(layers[0][0])]
    for before in reversed(ways):
        path.append(before[path[-1]])
    return path


LONGEST = 1.3
"""Of an interval, as a share of the usual one."""
SPREAD_AT_A_TIME = 16
"""Frames compared between two looks at whether the work was cancelled."""


def spread_frames(
    comparison: Comparison,
    frames: Frames,
    ends: Sequence[int],
    every: int,
    progress: Callable[[int], None] = lambda compared: None,
) -> list[int]:
    """The frames of the path, of these ascending ones, from the first of them to the last.

    comparison: without a tolerance.  ends: frames that are on every path, the first
    and the last among them.  every: frames of an interval, on average at least, where the ends do
    not need more of them.
    progress: is given the number of frames that are compared; what it raises ends the work.
    """
    costs = _costs(comparison, frames, ends, longest_interval(every), progress)
    count, width = costs.shape
    most = max(int(frames[-1] - frames[0]) // every, 1)
    sums = np.full(count, np.inf)
    sums[0] = 0.0
    ways: list[np.ndarray[tuple[int], np.dtype[np.uint16]]] = []
    while len(ways) < most or not np.isfinite(sums[-1]):
        # reached[j, k]: in one more interval at frame k, over j frames
        reached = np.full((width, count), np.inf)
        for j in range(min(width, count - 1)):
            reached[j, j + 1 :] = sums[: count - 1 - j] + costs[: count - 1 - j, j]
        ways.append(reached.argmin(axis=0).astype(np.uint16))
        sums = reached.min(axis=0)
    path = [count - 1]
    for before in reversed(ways):
        path.append(path[-1] - 1 - int(before[path[-1]]))
    return [int(frames[k]) for k in reversed(path)]


def longest_interval(every: int) -> int:
    """The most frames from one keyframe to the next, where the motion has poses."""
    return math.ceil(LONGEST * every)


def _costs(
    comparison: Comparison,
    frames: Frames,
    ends: Sequence[int],
    longest: int,
    progress: Callable[[int], None],
) -> Array:
    """(N, w) the cost of the intervals from each frame to each of the w frames after it; infinite
    where one is too long, or leads over an end."""
    next_end = np.asarray(ends)[np.searchsorted(ends, frames, side="right").clip(max=len(ends) - 1)]
    stops = np.searchsorted(frames, np.minimum(frames + longest, next_end), side="right")
    stops = np.minimum(np.maximum(stops, np.arange(len(frames)) + 2), len(frames))
    costs = np.full((len(frames), int((stops - np.arange(len(frames))).max()) - 1), np.inf)
    for i, stop in enumerate(stops.tolist()):
        if i % SPREAD_AT_A_TIME == 0:
            progress(i)
        if stop > i + 1:
            costs[i, : stop - i - 1] = comparison.costs(frames[i : i + 1], frames[i + 1 : stop])[0]
    return costs


def reduce_motion(
    skeleton: Skeleton,
    camera: Camera,
    motion: Trajectory,
    goal: Goal,
    required: Collection[int] = (),
    parts: Collection[int] | None = None,
    progress: Callable[[int, int], None] = lambda done, expected: None,
    path: CameraPath | None = None,
) -> Reduction:
    """The fewest frames from which `interpolate` makes a motion again, to a tolerance; or, of one
    in so many frames, those from which it does so best.

    The first and the last frame with a pose are among them. No fewer keyframes with poses of the
    motion do; of as few, these have the least sum of squared misses. Frames without a pose, NaN in
    the motion, are no keyframes and are not compared.

    camera: for tolerances in the picture.  required: frames of the video that are keyframes anyway.
    parts: those that are interpolated and compared, all where None; the others move as they do.
    progress: is given how many frames are reached, of how many; what it raises ends the work.
    path: of the camera over the film, where it moves: interpolation is even in the world.
    ReductionError in one sentence where fewer than two frames have a pose, or a required one has
    none.
    """
    chosen = None if parts is None else frozenset(parts)
    tolerance = goal if isinstance(goal, Tolerance) else None
    over = None if path is None else path.between(motion.first_frame, motion.last_frame)
    comparison = Comparison(skeleton, camera, motion, tolerance, chosen, over)
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
    misses, is_known = np.full(len(comparison.motion), np.nan), comparison.known
    misses[kept] = 0.0
    for a, b in pairwise(kept):
        misses[a + 1 : b] = np.where(is_known[a + 1 : b], comparison.misses(a, b), np.nan)
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
