"""One job: its segments at one quality after another, on the worker's threads."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from threading import Event

from pydantic import ValidationError

from keypose.app.jobs.failure import failure_message
from keypose.app.jobs.messages import (
    JobFailed,
    JobFinished,
    Order,
    PassFinished,
    Report,
    SegmentFinished,
    Started,
)
from keypose.app.jobs.worker_cache import WorkerCache
from keypose.tracker.errors import SessionError, one_sentence
from keypose.tracker.session import Session
from keypose.tracker.session.settings import Quality, TrackSettings
from keypose.tracker.tracking import pool as tracked
from keypose.tracker.tracking.pool import SegmentEvent, SegmentFailed, Task, run_tasks

Send = Callable[[Report], None]


class Job:
    """An order at work. Every segment ends at its next pass once `cancelled` is set."""

    def __init__(self, order: Order, cancelled: Event, send: Send) -> None:
        self.order = order
        self._cancelled = cancelled
        self._send = send
        self.error: Exception | None = None
        """The first that was met, as it was raised; SessionError where memory ran out."""

    def run(self, worker_cache: WorkerCache, threads: Executor) -> None:
        """Do the work and report how it goes. Returns when all of it is done or left."""
        try:
            self._run(worker_cache, threads)
        except Exception as error:  # noqa: BLE001 — said in a sentence; rerun raises it again
            self.error = error
            self._send(JobFailed(self.order.job, _message(error)))

    def _run(self, worker_cache: WorkerCache, threads: Executor) -> None:
        order = self.order
        session = Session.model_validate_json(order.session)
        stages = _stages(session.settings, order.stages)
        self._send(Started(order.job, order.wanted, stages))
        tasks = [
            Task(index, (first, last), _settings(session.settings, stage), key)
            for stage in stages
            for index, (first, last, key) in enumerate(order.wanted)
        ]
        complete = True
        if tasks:
            tracker = worker_cache.tracker(session, order.video_path, Path(order.folder))
            complete = run_tasks(tracker, tasks, threads, self._report, self._cancelled.is_set)
        if self.error is not None:
            self._send(JobFailed(order.job, _message(self.error)))
        else:
            self._send(JobFinished(order.job, cancelled=not complete))

    def _report(self, event: SegmentEvent) -> None:
        job = self.order.job
        match event:
            case SegmentFailed():
                self.error = self.error or _as_session_error(event)
            case tracked.SegmentFinished():
                self._send(SegmentFinished(job, event.result))
            case tracked.PassFinished() if event.result.quality != "preview":
                # of a preview the next pass would be there before this one is drawn
                self._send(PassFinished(job, event.number, event.of, event.result))


def _stages(settings: TrackSettings, stages: tuple[Quality, ...]) -> tuple[Quality, ...]:
    """The published method knows no qualities: once is enough."""
    return stages[-1:] if settings.method == "paper" else stages


def _settings(settings: TrackSettings, stage: Quality) -> TrackSettings:
    """The session's settings at one quality; a preview keeps to its own number of passes."""
    passes = None if stage == "preview" and settings.method == "keypose" else settings.passes
    return settings.model_copy(update={"quality": stage, "passes": passes})


def _too_long(first: int, last: int) -> str:
    return (
        f"There is not enough memory to track {first}–{last}: set a keyframe between, "
        "or close other programs."
    )


def _as_session_error(failed: SegmentFailed) -> Exception:
    too_large = isinstance(failed.error, MemoryError)
    return SessionError(_too_long(*failed.span)) if too_large else failed.error


def _message(error: Exception) -> str:
    """One sentence for the person; of a fault, all of it for whoever reads the log."""
    if isinstance(error, ValidationError):
        return one_sentence(error)
    return failure_message(
        error,
        "Tracking failed with an internal error ({}). Finished work is kept; try again.",
    )
