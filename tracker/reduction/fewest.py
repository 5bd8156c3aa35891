"""The fewest frames of a motion between which interpolation stays within a tolerance.

A frame leads to a later one where interpolation between the two is within the tolerance everywhere
between. What is wanted is the path from the first frame to the last over the fewest frames, and of
those the one with the least sum of squared misses: dynamic programming over layers, the frames that
are reached in one interval, in two, and so on. A frame's layer depends on the layer before alone,
so each pair of frames is compared once at most, most of them by one part of one pose; sums are
computed on the shortest paths only. No bound on the length of an interval is needed, and the answer
is exact. Lengthening an interval may bring it back within the tolerance, so no bisection would be.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.reduction.compare import Comparison, Frames

AT_A_TIME = 256
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
        found = _reached(comparison, layers[-1], left, progress, len(frames) - len(left))
        layers.append(left[found])
        left = left[~found]
    return _cheapest(comparison, layers, int(frames[-1]))


def _reached(
    comparison: Comparison, froms: Frames, tos: Frames, progress: Callable[[int], None], before: int
) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    found = np.zeros(len(tos), dtype=np.bool_)
    for start in range(0, len(tos), AT_A_TIME):
        rows = slice(start, start + AT_A_TIME)
        found[rows] = comparison.reached(froms, tos[rows])
        progress(before + int(found.sum()))
    return found


def _cheapest(comparison: Comparison, layers: list[Frames], last: int) -> list[int]:
    """Of the shortest paths the one with the least sum, from the last layer back to the first."""
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
    for way in reversed(ways):
        path.append(way[path[-1]])
    return path
