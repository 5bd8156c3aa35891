"""Measure what a tracked segment shows of its own errors: gains, fast motion, occlusion, doubts."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from keypose.tracker.body.angle_errors import GUESSED_RAD
from keypose.tracker.body.trajectory import Trajectory, runs
from keypose.tracker.geometry.rotations import Array, log_rotation, transpose
from keypose.tracker.storage.results import Span
from keypose.tracker.tracking.diagnostics.expected_gain import MENDED
from keypose.tracker.tracking.result import SegmentResult

OWN_PX: Final = 0.2
"""How much a motion can be expected to stray with every frame from the nearer keyframe. What seems
to be more is a keyframe's own error, and one more beside it would not mend it."""
FAST = 1.5
FAST_DEG = 2.0
FAST_SHARE = 0.6
"""Motion is fast where a part turns more than so many times the segment's mean, and more than so
many degrees a frame; and worth a word where that is less than this share of the segment."""
ROOT_LEVER_M = 0.3
"""The lever at which a turn of the root moves the body as far as a shift does."""
HIDDEN = 0.15
HIDDEN_FRAMES = 3
"""As in the verdict: a part below this observability, for so many frames, is not seen."""
IN_DOUBT = 0.0125
LEAST_PX = 3.0
"""A joint that is expected to be off by more than this share of the body's height, and by more than
so many pixels, is worth a look. Two people who mark a joint differ by little less."""
RIGHT_SHARE = 0.25
"""Of the joints those are taken to be right that are expected to be off by least."""
NEAR_PEAK = 0.9
"""Frames of nearly the largest error are as good a place: among them a keyframe gains most."""
GAP = 4
"""Frames in doubt that are so far apart are one run."""
REACH: Final = 36
"""One look settles what is in doubt so many frames before and after it, whichever limb it is: there
are at most 8 places in 300 frames between two keyframes."""


class Doubt(NamedTuple):
    """A moment in doubt, at the row where its worst part is to be looked at: rows from the
    segment's first frame on."""

    part: int
    first: int
    last: int
    row: int


def expected_gain(track: SegmentResult) -> Array:
    """(n + 1,) pixels that a keyframe at each frame would mend; asked only where it is known."""
    gain = track.diagnostics.expected_gain
    assert gain is not None
    return gain


def gain(track: SegmentResult) -> float:
    """Pixels that the best keyframe in a segment is expected to mend, in the mean over it."""
    return float(expected_gain(track).max() / (track.last - track.first))


def body_error_px(track: SegmentResult) -> Array:
    """(n + 1,) pixels by which the whole body is expected to be off in the mean."""
    mends = expected_gain(track)
    whole = float(mends.sum())
    return mends * (float(mends.max()) / MENDED / whole) if whole > 0 else np.zeros(len(mends))


def possible_drift_px(track: SegmentResult) -> Array:
    """(n + 1,) pixels by which the motion may be off without the keyframes' own errors."""
    away = np.arange(track.last - track.first + 1)
    most = OWN_PX * np.minimum(away, away[::-1])
    if not expected_gain(track).sum() > 0:
        return most
    return np.minimum(body_error_px(track), most)


def part_errors_px(track: SegmentResult) -> Array | None:
    """(n + 1, P) as `Diagnostics.expected_error`, −inf where nothing is known; None where that is
    so of all."""
    expected = track.diagnostics.expected_error
    if expected is None or not track.finished:
        return None
    tracked_errors = track.where_tracked(expected)
    if not np.isfinite(tracked_errors).any():
        return None
    return np.where(np.isfinite(tracked_errors), tracked_errors, -np.inf)


def depth_errors_m(track: SegmentResult) -> Array | None:
    """(n + 1, P) as `Diagnostics.expected_depth`, 0 where nothing is known; None where that is so
    of all."""
    expected = track.diagnostics.expected_depth
    if expected is None or not track.finished:
        return None
    return np.asarray(np.nan_to_num(track.where_tracked(expected)))


def right_error_px(track: SegmentResult) -> float | None:
    """Pixels by which joints that are right are expected to be off; None where none is observed."""
    errors = part_errors_px(track)
    inside = np.zeros(0) if errors is None else errors[1:-1]
    positive = inside[inside > 0]
    return float(np.quantile(positive, RIGHT_SHARE)) if len(positive) else None


def best_row(track: SegmentResult, part: int, first: int, last: int) -> int:
    """Find of the rows first to last that with nearly the largest error of a part where a keyframe
    would gain most; the very largest where no gain is known.
    """
    errors = part_errors_px(track)
    assert errors is not None
    column = errors[first : last + 1, part]
    if track.diagnostics.expected_gain is None:
        return first + int(column.argmax())
    near = column >= NEAR_PEAK * column.max()
    return first + int(np.where(near, expected_gain(track)[first : last + 1], -1.0).argmax())


def doubts(track: SegmentResult, height_px: float | None) -> list[Doubt]:
    """The moments in doubt, the worst first, each by its worst part: one stands for all that is
    within its reach.

    height_px: of the body in the picture; None where nobody knows.
    """
    errors = part_errors_px(track)
    if errors is None:
        return []
    worth = max(LEAST_PX, IN_DOUBT * (height_px or 0.0))
    return [
        doubt._replace(row=best_row(track, doubt.part, doubt.first, doubt.last))
        for doubt in _peaks(errors, worth)
    ]


def depth_doubts(directions: Array) -> list[Doubt]:
    """The same of parts that are guessed in depth. directions (n + 1, P): see
    `keypose.tracker.body.angle_errors.direction_errors`."""
    between = np.where(np.isfinite(directions), directions, -np.inf)
    between[[0, -1]] = -np.inf  # a keyframe is what a person says
    return _peaks(between, GUESSED_RAD)


def _peaks(errors: Array, worth: float) -> list[Doubt]:
    """Where errors (n + 1, P) are over a bound, the worst first, each at its largest."""
    worst, found = errors.max(axis=1), []
    listed = _runs_over(worst, worth)
    while worst.max() > worth:
        peak = int(worst.argmax())
        start, end = next(run for run in listed if run[0] <= peak <= run[1])
        first, last = max(peak - REACH, start), min(peak + REACH, end)
        found.append(Doubt(int(errors[peak].argmax()), first, last, peak))
        worst[max(peak - REACH, 0) : peak + REACH + 1] = -np.inf
    return found


def _runs_over(values: Array, least: float) -> list[Span]:
    """The runs of values over a bound; small gaps between them do not count."""
    joined: list[Span] = []
    for first, last in runs(values > least):
        if joined and first - joined[-1][1] <= GAP + 1:
            first = joined.pop()[0]
        joined.append((first, last))
    return joined


def fast_about(motion: Trajectory, frame: int) -> Span | None:
    """The run of fast frames that a frame lies in, where it stands out of its segment.

    motion: of the segment, in the world.
    """
    first_frame, Rs, ps = motion.first_frame, motion.Rs_parent_part, motion.ps_camera_root
    turned = np.linalg.norm(log_rotation(transpose(Rs[:-1]) @ Rs[1:]), axis=-1).max(axis=1)
    shifted = np.linalg.norm(np.diff(ps, axis=0), axis=1) / ROOT_LEVER_M
    speed = np.rad2deg(np.maximum(turned, shifted))
    fast = speed > max(FAST * speed.mean(), FAST_DEG)
    step = min(frame - first_frame, len(speed) - 1)
    if not fast[step] or fast.mean() > FAST_SHARE:
        return None
    slow = np.flatnonzero(~fast)
    first = int(slow[slow < step].max(initial=-1)) + 1
    last = int(slow[slow > step].min(initial=len(speed)))
    return first_frame + first, first_frame + last


def unseen_share(track: SegmentResult, part: int, frames: Span) -> float:
    """The share of some frames in which the picture does not show a part; 0 where nobody knows."""
    observability = track.diagnostics.observability
    first = max(frames[0] - track.first - 1, 0)
    column = observability[first : max(frames[1] - track.first, first + 1), part]
    return float((column < HIDDEN).mean()) if len(column) else 0.0


def longest_occlusion(track: SegmentResult) -> tuple[int, Span] | None:
    """The part that goes unseen for the longest run of frames, and that run."""
    hidden_runs = []
    for part, column in enumerate(track.diagnostics.observability.T):
        hidden_runs += [(last - first + 1, first, part) for first, last in runs(column < HIDDEN)]
    hidden_runs = [run for run in hidden_runs if run[0] >= HIDDEN_FRAMES]
    if not hidden_runs:
        return None
    length, start, part = max(hidden_runs, key=lambda run: (run[0], run[1], run[2]))
    first = track.first + 1 + start
    return part, (first, min(first + length - 1, track.last - 1))
