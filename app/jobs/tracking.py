"""Tracking and fitting for a server that must stay quick: a worker process, orders to it, reports
from it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from keypose.app.jobs.messages import (
    Cancel,
    FitOrder,
    Fitted,
    JobFailed,
    JobFinished,
    Learned,
    Order,
    Pause,
    Ready,
    Report,
    SpaceOrder,
    Wanted,
    Warming,
)
from keypose.app.jobs.process import WorkerProcess
from keypose.tracker.session import Session
from keypose.tracker.session.settings import Quality
from keypose.tracker.storage.stretches import SegmentRun

WARM_AFTER_S = 2.0
"""The page that a person waits for comes first; the worker takes as long to load as the server."""

LIVE: tuple[Quality, ...] = ("preview", "full")
"""The stages while a person poses: something to see at once, then what is meant."""

_DIED = "Tracking stopped unexpectedly; what was finished is kept, track again."
_DIED_SOLVING = "Smoothing stopped unexpectedly; the motion is as it was tracked."
_DIED_FITTING = "Fitting stopped unexpectedly; everything is as it was, fit again."


class Tracking:
    """One worker process, started and made ready in the background, soon or when it is needed.

    All methods are called on the loop's thread, and `report` is called there. One job at a time: a
    newer one ends the older within one pass, and what that one finished is still reported, with
    the key it is good for.
    """

    def __init__(self, report: Callable[[Report], None], loop: asyncio.AbstractEventLoop) -> None:
        self._report = report
        self._loop = loop
        self._worker: WorkerProcess | None = None
        self._last_job = 0
        self._open: dict[int, str] = {}
        """Jobs that have not ended, with what is said should the worker die."""
        self._warming: Warming | None = None
        self._closed = False
        loop.call_soon_threadsafe(loop.call_later, WARM_AFTER_S, self._warm_up)

    def start(
        self,
        session: Session,
        video_path: Path,
        wanted: Sequence[Wanted],
        stages: Sequence[Quality] = ("full",),
        folder: Path | None = None,
    ) -> int:
        """Track these segments, in this order, at one quality after another; the job's number.

        folder: of the session's file, which may have an imported motion beside it.

        Ends a job that is at work. Every job ends in one JobFinished or JobFailed; one that has to
        wait until the worker is ready receives a Warming of its own.
        """
        job = self._begin(_DIED)
        content = _only_needed(session, wanted).model_dump_json().encode()
        place = "" if folder is None else str(folder)
        self._ensure_worker().send(
            Order(job, content, str(video_path), tuple(wanted), tuple(stages), place)
        )
        return job

    def fit(self, order: FitOrder) -> int:
        """Fit a pose or the sizes, draft a clip or track ahead; the job's number, which takes the
        place of the order's own.

        Ends a job that is at work, as tracking does. Ends in one Fitted, or as other jobs do.
        """
        job = self._begin(_DIED_FITTING)
        self._ensure_worker().send(replace(order, job=job))
        return job

    def solve_space(self, session: Session, stretches: Sequence[SegmentRun]) -> int:
        """Solve for the motion in space of these stretches; the job's number.

        Ends a job that is at work. Every job ends in one JobFinished or JobFailed.
        """
        job = self._begin(_DIED_SOLVING)
        content = session.model_copy(update={"drafts": (), "results": None}).model_dump_json()
        self._ensure_worker().send(SpaceOrder(content.encode(), tuple(stretches), job))
        return job

    def _begin(self, died: str) -> int:
        """The number of one more job."""
        if self._closed:
            raise RuntimeError("tracking is closed")
        self._last_job += 1
        self._open[self._last_job] = died
        if self._warming is not None:
            self._loop.call_soon(self._report, replace(self._warming, job=self._last_job))
        return self._last_job

    def cancel(self) -> None:
        """Leave the newest job within one pass; it then ends with JobFinished(cancelled=True)."""
        if self._worker is not None and self._last_job in self._open:
            self._worker.send(Cancel(self._last_job))

    def pause(self, on: bool) -> None:
        """Pause during a drag, so that the page follows it; then continue."""
        if self._worker is not None and self.job is not None:
            self._worker.send(Pause(on))

    def close(self) -> None:
        """End the worker, within a second; nothing is reported any more."""
        self._closed = True
        worker, self._worker = self._worker, None
        if worker is not None:
            worker.stop()

    @property
    def job(self) -> int | None:
        """The newest job if it has not ended."""
        return self._last_job if self._last_job in self._open else None

    @property
    def pid(self) -> int | None:
        """Return the id of the worker process, if there is one."""
        return None if self._worker is None else self._worker.pid

    def _warm_up(self) -> None:
        if not self._closed:
            self._ensure_worker()

    def _ensure_worker(self) -> WorkerProcess:
        """The worker, or a new one where there is none."""
        if self._worker is None:
            self._worker = WorkerProcess(
                lambda worker, report: self._on_loop(self._on_message, worker, report),
                lambda worker: self._on_loop(self._on_died, worker),
            )
        return self._worker

    def _on_loop(self, call: Callable[..., None], *given: Any) -> None:
        with suppress(RuntimeError):  # the loop has been closed
            self._loop.call_soon_threadsafe(call, *given)

    def _on_message(self, worker: WorkerProcess, report: Report) -> None:
        if worker is not self._worker:
            return
        if isinstance(report, JobFinished | JobFailed | Fitted | Learned):
            self._open.pop(report.job, None)
        if isinstance(report, Warming | Ready):
            report = replace(report, job=self.job)
            self._warming = report if isinstance(report, Warming) else None
        self._report(report)

    def _on_died(self, worker: WorkerProcess) -> None:
        """The worker is gone without having been asked to go; the next job gets a new one."""
        if worker is not self._worker:
            return
        self._worker = self._warming = None
        worker.stop()
        jobs, self._open = self._open, {}
        for job, words in jobs.items():
            self._report(JobFailed(job, words))


def _only_needed(session: Session, wanted: Sequence[Wanted]) -> Session:
    """The session without what these segments do not need: it is read anew for every job."""
    frames = {frame for first, last, _ in wanted for frame in (first, last)}
    if session.model_keyframe is not None:  # its surface moves with the body, everywhere
        frames.add(session.model_keyframe.frame)
    keyframes = tuple(k for k in session.keyframes if k.frame in frames)
    return session.model_copy(update={"keyframes": keyframes, "drafts": (), "results": None})
