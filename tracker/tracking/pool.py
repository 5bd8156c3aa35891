"""The one runner of segments: in parallel or in turn, for films and for surfaces.

`run_tasks` works on a caller's threads and reports from them: the page's worker stands on it.
`stream` makes an iterator of such work: `run`, for scripts, and the command line stand on that.
"""

from __future__ import annotations

import queue
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor, wait
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from threading import Event, Lock, Thread
from typing import TYPE_CHECKING, Protocol, TypeVar

from keypose.tracker.tracking.result import SegmentResult, TrackResult

if TYPE_CHECKING:
    from keypose.tracker.body.skeleton import Skeleton
    from keypose.tracker.body.trajectory import Pass, Trajectory
    from keypose.tracker.session.settings import TrackSettings

Item = TypeVar("Item")

POLL_S = 0.05
"""Between two looks at whether to stop, while nothing is reported."""


@dataclass(frozen=True)
class Task:
    """A segment to be tracked with these settings. Tasks of one segment have the same index.

    key: what its result is kept under, see `keypose.tracker.storage.fingerprints`; may be left out.
    """

    index: int
    span: tuple[int, int]
    settings: TrackSettings
    key: str = ""


@dataclass(frozen=True, eq=False)
class SegmentStarted:
    """Work on the session's segment `index` begins; `count` segments are to be tracked."""

    index: int
    count: int
    first_frame: int
    last_frame: int


@dataclass(frozen=True, eq=False)
class PassFinished:
    """One more trajectory of a segment, the `number`th from 0; `of` is how many are expected.

    result: not finished; it has the trajectory and its score alone.
    """

    index: int
    number: int
    of: int
    result: SegmentResult

    @property
    def trajectory(self) -> Trajectory:
        return self.result.trajectory

    @property
    def score(self) -> float:
        return self.result.scores[-1]


@dataclass(frozen=True, eq=False)
class SegmentFinished:
    """A segment is done."""

    index: int
    count: int
    result: SegmentResult


@dataclass(frozen=True, eq=False)
class SegmentFailed:
    """A segment cannot be tracked; the others are."""

    index: int
    span: tuple[int, int]
    error: Exception


@dataclass(frozen=True, eq=False)
class TrackFinished:
    """All segments are done, or those finished when tracking was cancelled."""

    result: TrackResult
    cancelled: bool = False


SegmentEvent = SegmentStarted | PassFinished | SegmentFinished | SegmentFailed
Progress = SegmentStarted | PassFinished | SegmentFinished | TrackFinished


def never() -> bool:
    """Not cancelled."""
    return False


class Cancelled(Exception):
    """Raised by the receiver of events to leave a segment unfinished."""


class SegmentTracker(Protocol):
    """What can track segments, of a film or of surfaces."""

    @property
    def skeleton(self) -> Skeleton: ...

    @property
    def spans(self) -> Sequence[tuple[int, int]]:
        """First and last frame of every segment."""
        ...

    def expected_steps(self, span: tuple[int, int], settings: TrackSettings) -> int:
        """The expected number of calls of `emit`."""
        ...

    def run_segment(
        self, span: tuple[int, int], settings: TrackSettings, emit: Callable[[Pass, int], None]
    ) -> SegmentResult:
        """Track one segment; `emit` is given trajectories and may raise Cancelled to stop the work;
        it is raised again unless a part of the result is of use."""
        ...


def run_tasks(
    tracker: SegmentTracker,
    tasks: Sequence[Task],
    threads: Executor,
    report: Callable[[SegmentEvent], None],
    cancelled: Callable[[], bool],
) -> bool:
    """Track segments on these threads, in this order; whether all of it was done.

    Each event is reported on the thread that works on its segment. Cancelling takes effect within
    one pass. A segment that fails does not stop the others; its later tasks are left out.
    """
    work = _TaskQueue(tracker, len({task.index for task in tasks}), report, cancelled)
    for future in wait([threads.submit(work.run, task) for task in tasks]).done:
        future.result()
    return work.is_complete


def stream(
    work: Callable[[Callable[[Item], None]], None], stop: Event, look: Callable[[], object] = never
) -> Generator[Item]:
    """What `work` reports to the function it is given, in order; it works on a thread of its
    own.

    stop: set when the iterator is closed before the end, so that the work leaves.
    look: called on the caller's thread, again and again. An error of the work is raised last.
    """
    events: queue.SimpleQueue[tuple[Item] | None] = queue.SimpleQueue()
    errors: list[BaseException] = []

    def whole() -> None:
        try:
            work(lambda event: events.put((event,)))
        except BaseException as error:  # noqa: BLE001 — raised again in the caller's thread
            errors.append(error)
        finally:
            events.put(None)

    thread = Thread(target=whole, name="tracking")
    thread.start()
    try:
        while True:
            look()
            with suppress(queue.Empty):  # short turns: signals are handled on every system
                event = events.get(timeout=POLL_S)
                if event is None:
                    break
                yield event[0]
    except BaseException:
        stop.set()
        raise
    finally:
        thread.join()
    if errors:
        raise errors[0]


def run(
    tracker: SegmentTracker,
    settings: TrackSettings,
    segments: Sequence[int] | None = None,
    workers: int = 1,
    cancelled: Callable[[], bool] = never,
) -> Iterator[Progress]:
    """Track segments (all, or those of these indices) and yield events: see `run_chosen`."""
    chosen = range(len(tracker.spans)) if segments is None else sorted(set(segments))
    tasks = [Task(index, tracker.spans[index], settings) for index in chosen]
    return run_chosen(tracker, settings, tasks, workers, cancelled)


def run_chosen(
    tracker: SegmentTracker,
    settings: TrackSettings,
    tasks: Sequence[Task],
    workers: int,
    cancelled: Callable[[], bool],
) -> Iterator[Progress]:
    """Track segments and yield events.

    `workers` segments run side by side; the result does not depend on it. Cancelling takes effect
    within one pass and keeps what is finished. The first error, such as a VideoError where the
    video cannot be read, is raised last: it does not stop the other segments.
    """
    stop, complete = Event(), []

    def look() -> None:
        if cancelled():
            stop.set()

    def work(report: Callable[[SegmentEvent], None]) -> None:
        with ThreadPoolExecutor(max(1, workers)) as threads:
            complete.append(run_tasks(tracker, tasks, threads, report, stop.is_set))

    done: dict[int, SegmentResult] = {}
    errors: list[Exception] = []
    with closing(stream(work, stop, look)) as events:
        for event in events:
            if isinstance(event, SegmentFailed):
                errors.append(event.error)
                continue
            if isinstance(event, SegmentFinished):
                done[event.index] = event.result
            yield event
    if errors:  # last, after everything finished was reported
        raise errors[0]
    result = TrackResult(tracker.skeleton, settings, tuple(done[k] for k in sorted(done)))
    yield TrackFinished(result, cancelled=not all(complete))


class _TaskQueue:
    """The tasks of one run, shared by its threads."""

    def __init__(
        self,
        tracker: SegmentTracker,
        count: int,
        report: Callable[[SegmentEvent], None],
        cancelled: Callable[[], bool],
    ) -> None:
        self._tracker, self._count = tracker, count
        self._report, self._cancelled = report, cancelled
        self._lock = Lock()
        self._started: set[int] = set()
        self._failed: set[int] = set()
        self.is_complete = True

    def run(self, task: Task) -> None:
        """Track a segment, as far as possible."""
        try:
            self._track(task)
        except Cancelled:
            self.is_complete = False
        except Exception as error:  # noqa: BLE001 — reported as data; the others go on
            self._failed.add(task.index)
            self._report(SegmentFailed(task.index, task.span, error))

    def _track(self, task: Task) -> None:
        if task.index in self._failed:
            return
        self._leave_when_cancelled()
        expected = self._tracker.expected_steps(task.span, task.settings)
        if self._is_first(task):
            self._report(SegmentStarted(task.index, self._count, *task.span))

        def emit(step: Pass, number: int) -> None:
            self._leave_when_cancelled()
            segment_result = SegmentResult.on_the_way(step, task.key, task.settings.quality)
            self._report(PassFinished(task.index, number, expected, segment_result))

        result = self._tracker.run_segment(task.span, task.settings, emit)
        if result.missing:
            self.is_complete = False
        kept = replace(result, key=task.key, quality=task.settings.quality)
        self._report(SegmentFinished(task.index, self._count, kept))

    def _is_first(self, task: Task) -> bool:
        with self._lock:
            first = task.index not in self._started
            self._started.add(task.index)
        return first

    def _leave_when_cancelled(self) -> None:
        if self._cancelled():
            raise Cancelled
