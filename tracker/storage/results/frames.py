"""Results of neighbouring segments, read frame by frame over the whole video.

Tables have a row for each of the video's frames, NaN where nothing is known; `listed` makes them
ready for JSON.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import runs
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.tracking.result import SegmentResult, side_by_side

Fitting: TypeAlias = Mapping[Span, SegmentResult]


def pose_at(fitting: Fitting, frame: int) -> Pose | None:
    """The tracked pose at a frame, None where there is none."""
    for (first, last), segment_result in fitting.items():
        if first <= frame <= last and segment_result.tracked[frame - first]:
            return segment_result.trajectory.pose(frame)
    return None


def observability(fitting: Fitting, frame_count: int, part_count: int) -> Array:
    """(F, P) observability of a part's motion at a frame, 0 to 1."""
    steps = [
        (first, segment_result.diagnostics.observability)
        for (first, _), segment_result in fitting.items()
    ]
    return _by_frame(side_by_side(steps, max(frame_count - 1, 0), (part_count,)))[:frame_count]


def residual(fitting: Fitting, frame_count: int, part_count: int) -> Array:
    """(F, P) root mean square difference of brightness at a frame, grey levels."""
    steps = [
        (first, segment_result.diagnostics.residual)
        for (first, _), segment_result in fitting.items()
    ]
    return _by_frame(side_by_side(steps, max(frame_count - 1, 0), (part_count,)))[:frame_count]


def ranks(fitting: Fitting, frame_count: int) -> Array:
    """(F − 1,) singular values above the cut of every step, NaN where nothing was measured."""
    steps = [
        (first, segment_result.diagnostics.rank) for (first, _), segment_result in fitting.items()
    ]
    step_ranks = side_by_side(steps, max(frame_count - 1, 0))
    return np.where(step_ranks >= 0, step_ranks, np.nan)


def expected_gain(fitting: Fitting, frame_count: int) -> Array:
    """(F,) expected gain of a keyframe at each frame, NaN where not known."""
    gains = [
        (first, segment_result.diagnostics.expected_gain)
        for (first, _), segment_result in fitting.items()
        if segment_result.diagnostics.expected_gain is not None
    ]
    return side_by_side(gains, frame_count)


def rotations(fitting: Fitting, frame_count: int, part: int) -> Array:
    """(F, 3, 3) a part's rotation in its parent's frame."""
    rows = [
        (first, segment_result.where_tracked(segment_result.trajectory.Rs_parent_part[:, part]))
        for (first, _), segment_result in fitting.items()
    ]
    return side_by_side(rows, frame_count, (3, 3))


def root_positions(fitting: Fitting, frame_count: int) -> Array:
    """(F, 3) the root in the camera frame, metres."""
    rows = [
        (first, segment_result.where_tracked(segment_result.trajectory.ps_camera_root))
        for (first, _), segment_result in fitting.items()
    ]
    return side_by_side(rows, frame_count, (3,))


def listed(column: Array, decimals: int = 3) -> list[list[float]]:
    """Lay out one value a frame as JSON takes it, without the frames of which nothing is known: of
    every run of known values its first frame, then the values, rounded."""
    rounded = np.round(column, decimals)
    known_runs = runs(np.isfinite(rounded))
    return [[first, *rounded[first : last + 1].tolist()] for first, last in known_runs]


def _by_frame(steps: Array) -> Array:
    """(F, …) of (F − 1, …): a frame's value is the mean of those of the steps to it and from it."""
    is_known = np.isfinite(steps)
    values = np.where(is_known, steps, 0.0)
    none = np.zeros((1, *steps.shape[1:]))
    total, count = (
        np.concatenate([table, none]) + np.concatenate([none, table])
        for table in (values, is_known)
    )
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
