"""The worker process of a server that must stay quick: jobs to it, reports from it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

from keypose.app.jobs.job import Failed, Finished, Job, Report, Warming
from keypose.app.jobs.process import WorkerProcess
from keypose.app.jobs.worker import Cancel, Order, Pause

WARM_AFTER_S = 2.0
"""The page that a person waits for comes first; the worker takes as long to load as the server."""


class JobRunner:
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
        self._open: dict[int, Job] = {}
        """Those that have not ended."""
        self._warming: Warming | None = None
        self._closed = False
        loop.call_soon_threadsafe(loop.call_later, WARM_AFTER_S, self._warm_up)

    def start(self, job: Job) -> int:
        """Begin a job; its number.

        Ends a job that is at work. Every job ends in one Finished or Failed; one that has to wait
        until the worker is ready receives a Warming of its own.
        """
        if self._closed:
            raise RuntimeError("the worker is closed")
        self._last_job += 1
        self._open[self._last_job] = job
        if self._warming is not None and job.needs_loops:
            self._loop.call_soon(self._report, replace(self._warming, job=self._last_job))
        self._ensure_worker().send(Order(self._last_job, job))
        return self._last_job

    def cancel(self) -> None:
        """Leave the newest job within one pass; it then ends with a cancelled Finished."""
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
        """The id of the worker process, if there is one."""
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

    def _on_loop(self, call: Callable[..., None], *arguments: Any) -> None:
        with suppress(RuntimeError):  # the loop has been closed
            self._loop.call_soon_threadsafe(call, *arguments)

    def _on_message(self, worker: WorkerProcess, report: Report) -> None:
        if worker is not self._worker:
            return
        if isinstance(report, Finished | Failed):
            self._open.pop(report.job, None)
        elif isinstance(report, Warming):
            waits = self.job is not None and self._open[self.job].needs_loops
            report = replace(report, job=self.job if waits else None)
            self._warming = report if report.words else None
        self._report(report)

    def _on_died(self, worker: WorkerProcess) -> None:
        """The worker is gone without having been asked to go; the next job gets a new one."""
        if worker is not self._worker:
            return
        self._worker = self._warming = None
        worker.stop()
        jobs, self._open = self._open, {}
        for number, job in jobs.items():
            self._report(Failed(number, job.died))
