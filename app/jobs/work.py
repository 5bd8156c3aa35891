"""One job: its segments at one quality after another, on the worker's threads."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from pathlib import Path
from threading import Event, Lock

from pydantic import ValidationError

from app.jobs.messages import (
    JobFailed,
    JobFinished,
    Order,
    PassFinished,
    Report,
    SegmentFinished,
    Started,
    Unit,
    Wanted,
)
from app.jobs.worker_cache import WorkerCache
from tracker.body.trajectory import Pass
from tracker.errors import KeyposeError, one_sentence
from tracker.session import Session
from tracker.session.settings import Quality, TrackSettings
from tracker.storage.results import SegmentTrack, Span
from tracker.tracking.pool import Cancelled, SegmentTracker

Tell = Callable[[Report], None]


class Job:
    """An order at work. Every segment ends at its next pass once `cancelled` is set."""

    def __init__(self, order: Order, cancelled: Event, tell: Tell) -> None:
        self.order = order
        self._cancelled = cancelled
        self._tell = tell
        self._lock = Lock()
        self._failed: dict[Span, str] = {}
        self._left = False

    def run(self, worker_cache: WorkerCache, threads: ThreadPoolExecutor) -> None:
        """Do the work and tell how it goes. Returns when all of it is done or left."""
        try:
            self._run(worker_cache, threads)
        except ValidationError as error:
            self._tell(JobFailed(self.order.job, one_sentence(error)))
        except Exception as error:  # noqa: BLE001 — a fault, told as such
            self._tell(JobFailed(self.order.job, _fault(error)))

    def _run(self, worker_cache: WorkerCache, threads: ThreadPoolExecutor) -> None:
        order = self.order
        session = Session.model_validate_json(order.session)
        stages = _stages(session.settings, order.stages)
        self._tell(Started(order.job, order.wanted, stages))
        trackers = {
            wanted[:2]: self._tracker(worker_cache, session, wanted) for wanted in order.wanted
        }
        wait(
            [
                threads.submit(self._segment, tracker, session, wanted, stage)
                for stage in stages
                for wanted in order.wanted
                if (tracker := trackers[wanted[:2]]) is not None
            ]
        )
        if self._failed:
            self._tell(JobFailed(order.job, next(iter(self._failed.values()))))
        else:
            self._tell(JobFinished(order.job, cancelled=self._left))

    def _tracker(
        self, worker_cache: WorkerCache, session: Session, wanted: Wanted
    ) -> SegmentTracker | None:
        """What is wrong with one segment does not stop the others."""
        first, last, _ = wanted
        try:
            return worker_cache.tracker(
                session, self.order.video_path, first, last, Path(self.order.folder)
            )
        except KeyposeError as error:
            self._fail((first, last), str(error))
            return None

    def _segment(
        self, tracker: SegmentTracker, session: Session, wanted: Wanted, stage: Quality
    ) -> None:
        """Track a segment, as far as it goes."""
        span = wanted[:2]
        if span in self._failed:
            return
        try:
            self._go_on()
            self._track(tracker, _settings(session.settings, stage), wanted, stage)
        except Cancelled:
            self._left = True
        except KeyposeError as error:
            self._fail(span, str(error))
        except MemoryError:
            self._fail(span, _too_long(*span))
        except Exception as error:  # noqa: BLE001 — a fault, told as such
            self._fail(span, _fault(error))

    def _track(
        self, tracker: SegmentTracker, settings: TrackSettings, wanted: Wanted, stage: Quality
    ) -> None:
        job, of = self.order.job, tracker.expected_steps(0, settings)

        def emit(step: Pass, number: int) -> None:
            self._go_on()
            if stage != "preview":  # the next pass would be there before this one is drawn
                told, unit = (step.score_or_nan, step.trajectory), _unit(step)
                self._tell(PassFinished(job, *wanted, stage, number, of, *told, unit))

        result = tracker.run_segment(0, settings, emit)
        if result.missing:
            self._left = True
        self._tell(SegmentFinished(job, SegmentTrack.of(wanted[2], stage, result)))

    def _go_on(self) -> None:
        if self._cancelled.is_set():
            raise Cancelled

    def _fail(self, span: Span, words: str) -> None:
        with self._lock:
            self._failed.setdefault(span, words)


def _stages(settings: TrackSettings, stages: tuple[Quality, ...]) -> tuple[Quality, ...]:
    """The published method knows no qualities: once is enough."""
    return stages[-1:] if settings.method == "paper" else stages


def _settings(settings: TrackSettings, stage: Quality) -> TrackSettings:
    """The session's settings at one quality; a preview keeps to its own number of passes."""
    passes = None if stage == "preview" and settings.method == "keypose" else settings.passes
    return settings.model_copy(update={"quality": stage, "passes": passes})


def _unit(step: Pass) -> Unit:
    """Surfaces are fitted step by step, films pass by pass."""
    return "step" if step.what == "fit" else "pass"


def _too_long(first: int, last: int) -> str:
    return (
        f"There is not enough memory to track {first}–{last}: set a keyframe between, "
        "or close other programs."
    )


def _fault(error: Exception) -> str:
    """One sentence for the person, all of it for whoever reads the log."""
    traceback.print_exception(error, file=sys.stderr)
    kind = type(error).__name__
    return f"Tracking met a fault of Keypose itself ({kind}); what was finished is kept, try again."
