"""Results of neighbouring segments, read frame by frame over the whole video.

Tables have a row for each of the video's frames, NaN where nothing is known; `listed` makes them
ready for JSON.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeAlias

import numpy as np

from tracker.body.pose import Pose
from tracker.geometry.rotations import Array
from tracker.storage.results.keys import Span
from tracker.storage.results.track import SegmentTrack

Fitting: TypeAlias = Mapping[Span, SegmentTrack]


def pose_at(fitting: Fitting, frame: int) -> Pose | None:
    """The tracked pose at a frame, None where there is none."""
    for (first, last), track in fitting.items():
        if first <= frame <= last and track.tracked[frame - first]:
            return track.trajectory.pose(frame)
    return None


def observability(fitting: Fitting, frame_count: int, part_count: int) -> Array:
    """(F, P) how much the picture tells of a part's motion about a frame, 0 to 1."""
    return _by_frame(fitting, (frame_count, part_count), lambda track: track.observability)


def residual(fitting: Fitting, frame_count: int, part_count: int) -> Array:
    """(F, P) root mean square difference of brightness about a frame, grey levels."""
    return _by_frame(fitting, (frame_count, part_count), lambda track: track.residual)


def rotations(fitting: Fitting, frame_count: int, part: int) -> Array:
    """(F, 3, 3) a part's rotation in its parent's frame."""
    table = np.full((frame_count, 3, 3), np.nan)
    for (first, last), track in fitting.items():
        Rs = track.trajectory.Rs_parent_part[:, part]
        table[first : last + 1] = np.where(track.tracked[:, None, None], Rs, np.nan)
    return table


def listed(column: Array, decimals: int = 3) -> list[float | None]:
    """A column of a table as JSON takes it: rounded, None where nothing is known."""
    return [
        None if unknown else value
        for value, unknown in zip(
            np.round(column, decimals).tolist(), np.isnan(column).tolist(), strict=True
        )
    ]


def _by_frame(
    fitting: Fitting, shape: tuple[int, int], of: Callable[[SegmentTrack], Array]
) -> Array:
    """A frame's value is the mean of those of the steps to it and from it."""
    total, count = np.zeros(shape), np.zeros(shape)
    for (first, last), track in fitting.items():
        steps = of(track)
        if len(steps) != last - first:
            continue  # not finished, or not measured
        known = np.isfinite(steps)
        for frames in (slice(first, last), slice(first + 1, last + 1)):
            total[frames] += np.where(known, steps, 0.0)
            count[frames] += known
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
