"""Segments worked on side by side or in turn, as a stream of events; whatever they are seen in."""

from __future__ import annotations

import queue
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from threading import Event
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from tracker.body.trajectory import Trajectory, joined
from tracker.geometry.rotations import Array

if TYPE_CHECKING:
    from tracker.body.skeleton import Skeleton
    from tracker.body.trajectory import Pass
    from tracker.session.settings import TrackSettings
    from tracker.session.verdict import Verdict


@dataclass(frozen=True, eq=False)
class SegmentResult:
    """The motion between two keyframes and all that was noticed on the way.

    trajectory: both keyframes included, N frames; the arrays below have a row for each of the
        n = N − 1 frame pairs and are explained in tracker.tracking.diagnostics.observability.
    scores: of the first trajectory and after every pass; comparable within the segment only.
    best_pass: which of them was kept.  closing_error: distance from the keyframes, must be ~0.
    notes: what could not be done as wished, in sentences for a person.
    need: (N,) what a keyframe at each frame would mend, see `expected_gain`; None where not known.
    missing: steps of the work that were not done, because it was left; 0 where all is done.
    unreached: the first and last frame that therefore have no pose of their own; the nearest one's
        stands there.
    """

    trajectory: Trajectory
    scores: tuple[float, ...]
    steps: tuple[str, ...]
    best_pass: int
    closing_error: float
    verdict: Verdict
    rank: NDArray[np.int64]
    singular_values: Array
    observability: Array
    residual: Array
    notes: tuple[str, ...] = ()
    need: Array | None = None
    missing: int = 0
    unreached: tuple[int, int] | None = None


@dataclass(frozen=True, eq=False)
class TrackResult:
    """The segments that were tracked, in order."""

    skeleton: Skeleton
    settings: TrackSettings
    segments: tuple[SegmentResult, ...]

    @property
    def trajectory(self) -> Trajectory:
        """One trajectory over all segments; they must be neighbours."""
        return joined([segment.trajectory for segment in self.segments])


@dataclass(frozen=True, eq=False)
class SegmentStarted:
    """Work on the session's segment `index` begins; `count` segments are to be tracked."""

    index: int
    count: int
    first_frame: int
    last_frame: int


@dataclass(frozen=True, eq=False)
class PassFinished:
    """One more trajectory of a segment; `of` is how many are to be expected."""

    index: int
    number: int
    of: int
    score: float
    trajectory: Trajectory


@dataclass(frozen=True, eq=False)
class SegmentFinished:
    """A segment is done."""

    index: int
    count: int
    result: SegmentResult


@dataclass(frozen=True, eq=False)
class TrackFinished:
    """All that was asked for is done, or what was finished when tracking was cancelled."""

    result: TrackResult
    cancelled: bool = False


Progress = SegmentStarted | PassFinished | SegmentFinished | TrackFinished


def never() -> bool:
    """Not cancelled."""
    return False


class Cancelled(Exception):
    """Raised by who is told how it goes, to leave a segment unfinished."""


class SegmentTracker(Protocol):
    """What can track segments, whatever they are seen in."""

    @property
    def skeleton(self) -> Skeleton: ...

    @property
    def spans(self) -> Sequence[tuple[int, int]]:
        """First and last frame of every segment."""
        ...

    def expected_steps(self, index: int, settings: TrackSettings) -> int:
        """Numbers that `emit` is to be expected to count up to."""
        ...

    def run_segment(
        self, index: int, settings: TrackSettings, emit: Callable[[Pass, int], None]
    ) -> SegmentResult:
        """Track one segment; `emit` is told trajectories and may raise Left to stop the work, which
        comes out of here again unless a part of the result can be of use."""
        ...


def run(
    tracker: SegmentTracker,
    settings: TrackSettings,
    segments: Sequence[int] | None = None,
    workers: int = 1,
    cancelled: Callable[[], bool] = never,
) -> Iterator[Progress]:
    """Track segments (all, or those of these indices) and tell how it goes.

    `workers` segments run side by side; the result does not depend on it. Cancelling takes effect
    within one pass and keeps what is finished. Raises VideoError where the video cannot be
    read.
    """
    chosen = list(range(len(tracker.spans))) if segments is None else sorted(set(segments))
    events: queue.Queue[Progress | BaseException | None] = queue.Queue()
    closing = Event()

    def work(index: int) -> None:
        try:
            _one_segment(tracker, settings, index, len(chosen), events, closing)
        except Cancelled:
            events.put(None)
        except BaseException as error:  # noqa: BLE001 — raised again in the caller's thread
            events.put(error)

    done: dict[int, SegmentResult] = {}
    errors: list[BaseException] = []
    stopped = False
    with ThreadPoolExecutor(max(1, workers)) as pool:
        waiting = [pool.submit(work, index) for index in chosen]
        try:
            for _ in range(len(chosen)):
                for event in _until_finished(events, cancelled, closing, errors):
                    if isinstance(event, SegmentFinished):
                        done[event.index] = event.result
                    yield event
                stopped = stopped or closing.is_set()
        finally:
            closing.set()
            for future in waiting:
                future.cancel()
    if errors:  # told last, so that what is finished has been handed over
        raise errors[0]
    result = TrackResult(tracker.skeleton, settings, tuple(done[k] for k in sorted(done)))
    yield TrackFinished(result, cancelled=stopped)


def _one_segment(
    tracker: SegmentTracker, settings: TrackSettings, index: int, count: int,
    events: queue.Queue[Progress | BaseException | None], closing: Event,
) -> None:  # fmt: skip
    if closing.is_set():
        raise Cancelled
    expected = tracker.expected_steps(index, settings)
    first, last = tracker.spans[index]
    events.put(SegmentStarted(index, count, first, last))

    def emit(step: Pass, number: int) -> None:
        if closing.is_set():
            raise Cancelled
        events.put(PassFinished(index, number, expected, step.score_or_nan, step.trajectory))

    result = tracker.run_segment(index, settings, emit)
    events.put(SegmentFinished(index, count, result))


def _until_finished(
    events: queue.Queue[Progress | BaseException | None],
    cancelled: Callable[[], bool],
    closing: Event,
    errors: list[BaseException],
) -> Iterator[Progress]:
    """Events up to the end of one segment, whichever ends first; an error ends the others too."""
    while True:
        if cancelled():
            closing.set()
        try:
            event = events.get(timeout=0.05)
        except queue.Empty:
            continue
        if event is None:
            return
        if isinstance(event, BaseException):
            errors.append(event)
            closing.set()
            return
        yield event
        if isinstance(event, SegmentFinished):
            return
