"""A job done here, without a worker process, and what jobs report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from threading import Event
from typing import Any

from keypose.app.jobs.job import Context, Job, Progress, Report, do
from keypose.app.jobs.track import Found, Tracked, found_in
from keypose.app.jobs.worker_cache import WorkerCache
from keypose.tracker.tracking.pool import PassFinished, SegmentFinished
from keypose.tracker.tracking.result import SegmentResult

NUMBER = 7
"""Of every job that is done here."""


def reported(
    job: Job, cache: Any, cancelled: Event | None = None, threads: int = 1,
    received: Callable[[Report], None] = lambda _: None,
) -> list[Report]:  # fmt: skip
    """All that a job reports; `received` gets each of them."""
    reports: list[Report] = []

    def send(report: Report) -> None:
        reports.append(report)
        received(report)

    with ThreadPoolExecutor(threads) as pool:
        do(job, Context(NUMBER, cache, pool, (cancelled or Event()).is_set, send))
    return reports


def reported_until(job: Job, cancel_after: int | None) -> list[Report]:
    """All that a job reports, which is cancelled after so many reports."""
    cancelled, cache, count = Event(), WorkerCache(), 0

    def received(_: Report) -> None:
        nonlocal count
        count += 1
        if count == cancel_after:
            cancelled.set()

    try:
        return reported(job, cache, cancelled, received=received)
    finally:
        cache.close()


def segment_done(job: int, result: SegmentResult) -> Progress:
    """A segment is done, as a job reports it."""
    return Progress(job, 1.0, partial=Tracked(SegmentFinished(0, 1, result), 1.0))


def found(reports: Sequence[Report]) -> list[Found]:
    """What was reported of segments."""
    return [event for report in reports if (event := found_in(report)) is not None]


def segments(reports: Sequence[Report]) -> list[SegmentResult]:
    """The segments that are done."""
    return [event.result for event in found(reports) if isinstance(event, SegmentFinished)]


def passes(reports: Sequence[Report]) -> list[PassFinished]:
    """The trajectories on the way."""
    return [event for event in found(reports) if isinstance(event, PassFinished)]
