"""A recording at a constant rate, or low-pass filtered, before it is written.

Frame n of a recording at a rate of its own is shown n / rate seconds after the video's first frame,
so that times are right in formats that know only a rate and numbers, too. Poses lie between the
first tracked frame and the last; where the video's frames around one are not tracked, it is not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.resampling import (
    filtered_positions,
    filtered_rotations,
    least_frames,
    low_pass_kernel,
    resampled,
)
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.recording import Recording
from keypose.tracker.geometry.rotations import Array, frozen, log_rotation, transpose
from keypose.tracker.storage.tracks import Tracks
from keypose.tracker.tracking.result import COLUMNS, Diagnostics

SLACK = 1e-3
"""Of a frame, that a pose may lie beyond an end: times are rounded."""

MOST_FRAMES = 1_000_000


def at_rate(recording: Recording, rate: float) -> Recording:
    """The recording at so many frames a second.

    FormatError where none of them falls between the first frame and the last.
    """
    _require_times(recording)
    old_s = recording.times_s
    first = int(np.ceil(old_s[0] * rate - SLACK))
    last = int(np.floor(old_s[-1] * rate + SLACK))
    if last <= first or last - first > MOST_FRAMES:
        many = "too many" if last > first else "no two"
        raise FormatError(f"At {rate:g} frames a second this motion has {many} frames.")
    times_s = np.clip(np.arange(first, last + 1) / rate, old_s[0], old_s[-1])
    film = np.interp(times_s, old_s, recording.film_frames)
    Rs, ps = _poses_at(recording, times_s)
    row = np.interp(times_s, old_s, np.arange(len(old_s)))
    tracks = Tracks(
        first, recording.tracks.part_names, Rs, ps, _diagnostics_at(recording.tracks, row)
    )
    return replace(
        recording,
        tracks=tracks,
        times_s=frozen(np.arange(first, last + 1) / rate),
        rate=rate,
        sampled_at=frozen(film),
        repeats=None,
    )


def from_zero(recording: Recording) -> Recording:
    """The recording with its first frame as frame 0 at time 0, as players of clips expect it."""
    tracks = replace(recording.tracks, first_frame=0)
    times_s = frozen(recording.times_s - recording.times_s[0])
    return replace(
        recording, tracks=tracks, times_s=times_s, sampled_at=recording.film_frames, repeats=None
    )


def low_passed(recording: Recording, cutoff_hz: float) -> Recording:
    """The recording without motion that is faster than the cut-off; an uneven one is made even.

    FormatError where the rate is too low for the cut-off, or too few frames lie side by side.
    """
    even = recording if recording.is_even else at_rate(recording, recording.frames_per_second)
    rate = even.frames_per_second
    if not 0.0 < cutoff_hz < rate / 2:
        raise FormatError(
            f"A filter at {cutoff_hz:g} Hz needs more than {2 * cutoff_hz:g} frames a second, and "
            f"this film has {rate:.5g}: choose a cut-off below {rate / 2:.4g} Hz."
        )
    kernel = low_pass_kernel(cutoff_hz, rate)
    Rs, ps = even.tracks.Rs_parent_part.copy(), even.tracks.ps_camera_root.copy()
    for run in _runs(even.tracks.tracked):
        count, least = run.stop - run.start, least_frames(cutoff_hz, rate)
        if count < least:
            first = even.frames[run.start]
            raise FormatError(
                f"Frames {first} to {first + count - 1} are too few to be filtered at "
                f"{cutoff_hz:g} Hz: that takes {least}."
            )
        Rs[run], ps[run] = filtered_rotations(Rs[run], kernel), filtered_positions(ps[run], kernel)
    tracks = replace(even.tracks, Rs_parent_part=Rs, ps_camera_root=ps)
    return replace(even, tracks=tracks, filter_hz=cutoff_hz)


def moved_at_keyframes(recording: Recording, before: Recording) -> tuple[float, float]:
    """How far a filter took joints (metres) and parts (radians) from keyframes, at most.

    `before` is the recording that `low_passed` was given.
    """
    even = before if before.is_even else at_rate(before, before.frames_per_second)
    at = recording.at_keyframe & recording.tracks.tracked
    if not at.any():
        return 0.0, 0.0
    joints = recording.ps_camera_joint[at] - even.ps_camera_joint[at]
    Rs, Rs_before = recording.tracks.Rs_parent_part[at], even.tracks.Rs_parent_part[at]
    turns = log_rotation(transpose(Rs_before) @ Rs)
    return (
        float(np.linalg.norm(joints, axis=-1).max()),
        float(np.linalg.norm(turns, axis=-1).max()),
    )


def _require_times(recording: Recording) -> None:
    if len(recording) < 2 or not (np.diff(recording.times_s) > 0).all():
        raise FormatError("Another rate needs two frames, and times that ascend.")


def _poses_at(recording: Recording, times_s: Array) -> tuple[Array, Array]:
    """Rotations and root positions, NaN where the frames around are not tracked."""
    tracks = recording.tracks
    Rs = np.full((len(times_s), *tracks.Rs_parent_part.shape[1:]), np.nan)
    ps = np.full((len(times_s), 3), np.nan)
    for run in _runs(tracks.tracked):
        own_s = recording.times_s[run]
        inside = (times_s >= own_s[0]) & (times_s <= own_s[-1])
        if len(own_s) > 1 and inside.any():
            Rs[inside], ps[inside] = resampled(
                tracks.Rs_parent_part[run], tracks.ps_camera_root[run], own_s, times_s[inside]
            )
    return Rs, ps


def _diagnostics_at(tracks: Tracks, row: Array) -> Diagnostics:
    """Take diagnostics of the frame nearest to each pose, and of the step most of a
    step lies in.
    """
    steps = np.floor((row[1:] + row[:-1]) / 2).astype(int)
    nearest = np.rint(row).astype(int)
    arrays = {}
    for column in COLUMNS:
        values = tracks.diagnostics.rows(column)
        if values is not None:
            arrays[column.name] = values[steps if column.rows == "step" else nearest]
    return Diagnostics(**arrays)


def _runs(tracked: NDArray[np.bool_]) -> Iterator[slice]:
    """The stretches of tracked frames."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], tracked.astype(int), [0]])))
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        yield slice(int(start), int(end))
