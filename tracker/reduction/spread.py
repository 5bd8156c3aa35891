"""One frame of a motion in so many, where interpolation between them misses it least.

For a motion that is kept between its keyframes, so that these need not lead to it: they are where
it is held when it is edited. Of all paths over so many intervals the one with the least sum of
squared misses, by dynamic programming over the number of intervals. None is much longer than
others, since a motion that repeats itself would be missed by as much over one of its rounds as over
many.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.reduction.compare import Comparison, Frames

LONGEST = 1.3
"""Of an interval, as a share of the usual one."""
AT_A_TIME = 16
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
    for way in reversed(ways):
        path.append(path[-1] - 1 - int(way[path[-1]]))
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
        if i % AT_A_TIME == 0:
            progress(i)
        if stop > i + 1:
            costs[i, : stop - i - 1] = comparison.costs(frames[i : i + 1], frames[i + 1 : stop])[0]
    return costs
