"""Keyframes moved to where tracking between them comes nearest to the motion they were taken from.

A reduction chooses its frames by interpolation, which says little about where tracking strays. Here
each segment is tracked from the keyframes at its ends and compared with the motion itself, and the
keyframes beside the worst segment are moved by some frames as long as that lowers the greatest
deviation. A segment depends on nothing but its own keyframes, so a move costs two of them at most,
and none is tracked twice.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from keypose.tracker.body.trajectory import Pass, Trajectory
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.tracking.parts.keyed import KeyedParts
from keypose.tracker.tracking.tracker import Tracker

Span: TypeAlias = tuple[int, int]

MOVES = (2, 4, 1, 3)
"""By how many frames a keyframe is moved: first what is likely to help, then what is finer."""
TRACKED_AGAIN = 2.0
"""The most frames that are tracked besides those of the first time, as a share of these."""


@dataclass(frozen=True)
class TrackedReduction:
    """Keyframes, and how far tracking between them strays from the motion.

    frames: of the video, ascending.  deviations_m: of each segment, the greatest.
    before_m: the greatest before any keyframe was moved.
    """

    frames: tuple[int, ...]
    deviations_m: tuple[float, ...]
    before_m: float

    @property
    def worst_m(self) -> float:
        """The greatest of all."""
        return max(self.deviations_m)


class _Tracked:
    """The deviation of every segment that was tracked, and what is left to be spent on more."""

    def __init__(
        self,
        deviation: Callable[[Span], float],
        frames: Sequence[int],
        progress: Callable[[int, int], None],
    ) -> None:
        self._deviation, self._progress = deviation, progress
        self._known: dict[Span, float] = {}
        self._done, self._most = 0, round((1 + TRACKED_AGAIN) * (frames[-1] - frames[0]))

    def affords(self, span: Span) -> bool:
        return span in self._known or self._done + span[1] - span[0] <= self._most

    def of(self, span: Span) -> float:
        if span not in self._known:
            self._progress(self._done, self._most)
            self._known[span] = self._deviation(span)
            self._done += span[1] - span[0]
        return self._known[span]


def nearer_by_tracking(
    frames: Sequence[int],
    deviation: Callable[[Span], float],
    within_m: float,
    fixed: Collection[int] = (),
    allowed: Callable[[int], bool] = lambda frame: True,
    longest: int | None = None,
    progress: Callable[[int, int], None] = lambda done, most: None,
) -> TrackedReduction:
    """As many keyframes, moved until tracking stays within a deviation of the motion, or no move
    lowers the greatest one, or as much has been tracked as TRACKED_AGAIN allows.

    deviation: tracks the segment between two frames; its greatest deviation, metres.
    fixed: frames that stay.  allowed: whether a frame may be a keyframe.  longest: of a segment.
    progress: is given how many frames are tracked, of at most how many; what it raises ends the
    work.
    """
    tracked = _Tracked(deviation, frames, progress)
    path = list(frames)
    before = worst = max(tracked.of(span) for span in pairwise(path))
    while worst > within_m:
        better = next(_better(path, tracked, worst, fixed, allowed, longest), None)
        if better is None:
            break
        path = better
        worst = max(tracked.of(span) for span in pairwise(path))
    return TrackedReduction(tuple(path), tuple(map(tracked.of, pairwise(path))), before)


def tracked_deviation(
    tracker: Tracker,
    motion: Trajectory,
    settings: TrackSettings,
    keyed_parts: Sequence[KeyedParts] = (),
) -> Callable[[Span], float]:
    """What `nearer_by_tracking` asks for: a segment of the tracker's video tracked from its own
    motion, as it is after the reduction; the greatest distance of a joint or landmark, metres.

    motion: NaN at frames without a pose; these are not compared.
    """
    skeleton, first = tracker.skeleton, motion.first_frame
    known = np.asarray(np.isfinite(motion.ps_camera_root).all(axis=1))
    keyposes = {first + n: motion.pose(first + n) for n in np.flatnonzero(known).tolist()}
    joints = motion.joints(skeleton)
    source = tracker.keypoint_source(settings)
    edges = np.flatnonzero(np.diff(np.r_[0, known, 0])).reshape(-1, 2) + first
    runs = [(int(a), int(b) - 1) for a, b in edges]
    own = tracker.renewed(skeleton, keyposes, motion, source, keyed_parts, own=runs)

    def deviation(span: Span) -> float:
        found = own.run_segment(span, settings, _unwatched).trajectory
        rows = slice(span[0] - first, span[1] - first + 1)
        away = np.linalg.norm(found.joints(skeleton) - joints[rows], axis=-1)
        return float(away[known[rows]].max())

    return deviation


def _unwatched(_passed: Pass, _number: int) -> None:
    """Segments are short: between two of them is soon enough to look at whether to stop."""


def _better(
    path: Sequence[int],
    tracked: _Tracked,
    worst: float,
    fixed: Collection[int],
    allowed: Callable[[int], bool],
    longest: int | None,
) -> Iterator[list[int]]:
    """The paths with one keyframe beside the worst segment moved that are nearer, as found."""
    spans = list(pairwise(path))
    at = max(range(len(spans)), key=lambda i: tracked.of(spans[i]))
    for i, moved in _moves(path, at):
        if path[i] in fixed or not allowed(moved):
            continue
        beside = [(path[i - 1], moved), (moved, path[i + 1])]
        if longest is not None and any(b - a > longest for a, b in beside):
            continue
        if i == at:  # the worst segment first: where it stays as bad, the other does not matter
            beside.reverse()
        if all(tracked.affords(span) and tracked.of(span) < worst for span in beside):
            yield [*path[:i], moved, *path[i + 1 :]]


def _moves(path: Sequence[int], at: int) -> Iterator[tuple[int, int]]:
    """A keyframe of a segment, as its place in the path, and where it may be moved: into the
    segment first, which makes it shorter, then out of it. The ends of the path stay."""
    for into in (1, -1):
        for step in MOVES:
            for i, towards in ((at, into), (at + 1, -into)):
                if 0 < i < len(path) - 1 and path[i - 1] < path[i] + towards * step < path[i + 1]:
                    yield i, path[i] + towards * step
