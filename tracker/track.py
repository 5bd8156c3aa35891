"""Tracking a session: its segments, side by side or in turn, as a stream of events."""

from __future__ import annotations

import queue
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from threading import Event

import numpy as np
from numpy.typing import NDArray

from tracker.drift import closing_error
from tracker.errors import SessionError
from tracker.geometry import Array
from tracker.loading import MEMORY_BYTES, ClipLoader, WorkingSize
from tracker.methods import method_of
from tracker.observe import observe
from tracker.pose import Pose
from tracker.scene import Scene
from tracker.segment import Outcome, Pass, Segment, track_segment
from tracker.session.schema import Session, TrackSettings
from tracker.skeleton import Skeleton
from tracker.trajectory import Trajectory, joined
from tracker.verdict import Verdict, judge
from tracker.video import Video


@dataclass(frozen=True, eq=False)
class SegmentResult:
    """The motion between two keyframes and all that was noticed on the way.

    trajectory: both keyframes included, N frames; the arrays below have a row for each of the
        n = N − 1 frame pairs and are explained in tracker.observe.
    scores: of the first trajectory and after every pass; comparable within the segment only.
    best_pass: which of them was kept.  closing_error: distance from the keyframes, must be ~0.
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


class Tracker:
    """A session made ready to be tracked: scene, pictures, keyposes.

    Keep it to track again after a keyframe has changed: pictures stay prepared.
    """

    def __init__(self, session: Session, video: Video, memory: int = MEMORY_BYTES) -> None:
        _demand_keyframes(session)
        frames = [k.frame for k in session.keyframes]
        longest = max(b - a for a, b in zip(frames, frames[1:], strict=False)) + 1
        size = WorkingSize.for_camera(session.camera, longest, memory)
        self.session = session
        self.skeleton = Skeleton.of(session.body)
        self.keyposes = {k.frame: k.pose(self.skeleton) for k in session.keyframes}
        poses = list(self.keyposes.values())
        self.scene = Scene.of(self.skeleton, size.camera(session.camera), poses)
        self.loader = ClipLoader(
            video, session.camera, size, session.ignore_masks, session.settings.static_camera,
            memory,
        )  # fmt: skip

    @property
    def spans(self) -> list[tuple[int, int]]:
        """First and last frame of every segment."""
        frames = sorted(self.keyposes)
        return list(zip(frames, frames[1:], strict=False))

    def move_keyframe(self, frame: int, pose: Pose) -> None:
        """Give an existing keyframe another pose."""
        if frame not in self.keyposes:
            raise SessionError(f"Frame {frame} has no keyframe; add it to the session first.")
        self.keyposes[frame] = pose

    def run_segment(
        self, index: int, settings: TrackSettings, emit: Callable[[Pass, int], None]
    ) -> SegmentResult:
        """Track one segment; `emit` is told every trajectory and may raise to stop the work."""
        first, last = self.spans[index]
        start, end = self.keyposes[first], self.keyposes[last]
        segment = Segment(first, last, start, end, self.loader.load(first, last))
        work, number = track_segment(self.scene, segment, method_of(settings)), 0
        while True:
            try:
                step = next(work)
            except StopIteration as done:
                return self._result(segment, done.value)
            emit(step, number)
            number += 1

    def _result(self, segment: Segment, outcome: Outcome) -> SegmentResult:
        seen = observe(self.scene, segment.clip, outcome.trajectory)
        return SegmentResult(
            trajectory=outcome.trajectory,
            scores=tuple(p.score for p in outcome.passes),
            steps=tuple(p.what for p in outcome.passes),
            best_pass=outcome.best,
            closing_error=closing_error(outcome.trajectory, segment.start, segment.end),
            verdict=judge(self.scene, segment, outcome, seen),
            rank=seen.rank,
            singular_values=seen.singular_values,
            observability=seen.observability,
            residual=seen.residual,
        )


class _Cancelled(Exception):
    """Raised inside a worker to leave a segment unfinished."""


def track_session(
    session: Session,
    video: Video,
    *,
    segments: Sequence[int] | None = None,
    workers: int = 1,
    cancelled: Callable[[], bool] = never,
) -> Iterator[Progress]:
    """Track a session's segments (all, or those of these indices) and tell how it goes.

    `workers` segments run side by side; the result does not depend on it. Cancelling takes effect
    within one pass and keeps the finished segments. Raises SessionError with fewer than two
    keyframes, VideoError where the video cannot be read.
    """
    tracker = Tracker(session, video, MEMORY_BYTES // max(1, workers))
    yield from run(tracker, session.settings, segments, workers, cancelled)


def run(
    tracker: Tracker,
    settings: TrackSettings,
    segments: Sequence[int] | None = None,
    workers: int = 1,
    cancelled: Callable[[], bool] = never,
) -> Iterator[Progress]:
    """Run a prepared tracker; events as in `track_session`."""
    chosen = list(range(len(tracker.spans))) if segments is None else sorted(set(segments))
    events: queue.Queue[Progress | BaseException | None] = queue.Queue()
    closing = Event()

    def work(index: int) -> None:
        try:
            _one_segment(tracker, settings, index, len(chosen), events, closing)
        except _Cancelled:
            events.put(None)
        except BaseException as error:  # handed to the caller's thread, where it is raised again
            events.put(error)

    done: dict[int, SegmentResult] = {}
    stopped = False
    with ThreadPoolExecutor(max(1, workers)) as pool:
        waiting = [pool.submit(work, index) for index in chosen]
        try:
            for _ in range(len(chosen)):
                for event in _until_finished(events, cancelled, closing):
                    if isinstance(event, SegmentFinished):
                        done[event.index] = event.result
                    yield event
                stopped = stopped or closing.is_set()
        finally:
            closing.set()
            for future in waiting:
                future.cancel()
    result = TrackResult(tracker.skeleton, settings, tuple(done[k] for k in sorted(done)))
    yield TrackFinished(result, cancelled=stopped)


def _one_segment(
    tracker: Tracker, settings: TrackSettings, index: int, count: int,
    events: queue.Queue[Progress | BaseException | None], closing: Event,
) -> None:  # fmt: skip
    if closing.is_set():
        raise _Cancelled
    expected = _expected_steps(settings)
    first, last = tracker.spans[index]
    events.put(SegmentStarted(index, count, first, last))

    def emit(step: Pass, number: int) -> None:
        if closing.is_set():
            raise _Cancelled
        events.put(PassFinished(index, number, expected, step.score, step.trajectory))

    result = tracker.run_segment(index, settings, emit)
    events.put(SegmentFinished(index, count, result))


def _until_finished(
    events: queue.Queue[Progress | BaseException | None],
    cancelled: Callable[[], bool],
    closing: Event,
) -> Iterator[Progress]:
    """Events up to the end of one segment, whichever ends first."""
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
            raise event
        yield event
        if isinstance(event, SegmentFinished):
            return


def _expected_steps(settings: TrackSettings) -> int:
    """Trajectories a segment will yield: start, both ways, passes, refinement."""
    method = method_of(settings)
    return method.passes + (1 if settings.method == "paper" else 3)


def _demand_keyframes(session: Session) -> None:
    if len(session.keyframes) < 2:
        have = "none" if not session.keyframes else f"one, at frame {session.keyframes[0].frame}"
        raise SessionError(
            f"keyframes: at least two are needed to track between, and the session has {have}."
        )
