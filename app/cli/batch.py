"""`keypose batch`: many saved sessions tracked anew, without the page."""

from __future__ import annotations

import argparse
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from keypose.app.cli.arguments import (
    order_of,
)
from keypose.app.cli.batch_progress import BatchReporter, batch_reporter
from keypose.app.cli.long_work import set_when_interrupted, warm_tracker
from keypose.app.export.motion_formats import require_meant
from keypose.app.jobs.batch import scheduler
from keypose.app.jobs.batch.cluster import ClusterPool
from keypose.app.jobs.batch.finding import common_folder, find_sessions, name_of
from keypose.app.jobs.batch.journal import Journal
from keypose.app.jobs.batch.pool import LocalPool, WorkerPool
from keypose.app.jobs.batch.report import NAME, Entry, batch_html, is_report
from keypose.app.jobs.batch.run_one import export_of, places
from keypose.app.jobs.batch.scheduler import TaskEvent, TaskFinished, TaskStarted
from keypose.app.jobs.batch.task import Summary, Task
from keypose.app.orders.motion import MotionOrder
from keypose.app.orders.order import options_of
from keypose.app.orders.tracking import TrackOrder
from keypose.tracker.errors import FormatError, KeyposeError, SessionError
from keypose.tracker.storage.atomic import make_folder, require_absent, require_folder, write_file

DONE, NOT_ALL, INTERRUPTED = 0, 1, 130
WORKER_BYTES = 2_000_000_000
"""What a worker may want: the program and the clip of its longest segment."""


def run(arguments: argparse.Namespace) -> int:
    if arguments.scheduler is not None and arguments.workers is not None:
        raise SessionError("--workers is for this computer: a cluster has its own workers.")
    sessions = find_sessions(arguments.paths)
    folder = common_folder(sessions)
    out = None if arguments.out is None else arguments.out.absolute()
    place = out or folder
    _require_place(place)
    began = time.monotonic()
    with _journal(place, arguments) as journal:
        tasks = _tasks(sessions, out, arguments, journal)
        batch = _Batch(tasks, [name_of(session, folder) for session in sessions], journal)
        processes = min(_workers(arguments), len(sessions))
        with (
            _pool(arguments, processes) as pool,
            batch_reporter(batch.names, [str(s) for s in sessions], arguments.json) as reporter,
        ):
            reporter.start(len(journal.done & {str(session) for session in sessions}))
            whole = batch.run(pool, reporter)
        if whole:
            batch.note(journal.end)
    seconds = time.monotonic() - began
    report = _report(batch, place, seconds) if whole else None
    reporter.finish(batch.entries, report, seconds, interrupted=not whole)
    return _code(batch, whole)


def _report(batch: _Batch, place: Path, seconds: float) -> Path | None:
    """The report, None where it cannot be written."""
    report = place / NAME
    content = batch_html(batch.entries, seconds)
    written = batch.note(lambda: write_file(report, content, overwrite=True))
    return report if written else None


def _code(batch: _Batch, whole: bool) -> int:
    """The exit code; what could not be written beside the sessions is said here, once."""
    if not whole or not batch.is_good:
        if batch.problem is not None:
            print(batch.problem, file=sys.stderr)
        return NOT_ALL if whole else INTERRUPTED
    if batch.problem is not None:
        raise batch.problem
    return DONE


def _require_place(out: Path) -> None:
    """Require before the work, not after, that the report can be written."""
    require_folder(out)
    make_folder(out)
    report = out / NAME
    if report.exists() and not is_report(report):
        raise FormatError(f"{str(report)!r} is not of a batch and is not overwritten.")


@contextmanager
def _journal(out: Path, arguments: argparse.Namespace) -> Iterator[Journal]:
    names = ("only", "method", "quality", "export")
    asked = {name: getattr(arguments, name) for name in names}
    asked |= {
        name: str(value) for name in options_of(MotionOrder) if (value := getattr(arguments, name))
    }
    paths = sorted({os.path.realpath(path) for path in arguments.paths})
    journal = Journal(out, {**asked, "paths": paths})
    try:
        yield journal
    finally:
        journal.close()


@contextmanager
def _pool(arguments: argparse.Namespace, processes: int) -> Iterator[WorkerPool]:
    pool: WorkerPool
    if arguments.scheduler is not None:
        pool = ClusterPool(arguments.scheduler)
        if not pool.free_slots():
            print("The cluster has no workers yet: waiting for one.", file=sys.stderr)
    else:
        warm_tracker()  # here, before several processes would do it at the same time
        pool = LocalPool(processes)
    try:
        yield pool
    finally:
        pool.close()


def _workers(arguments: argparse.Namespace) -> int:
    """Return as many workers as were asked for, or one for each core that has enough memory.

    Two processes on two cores compute together no longer than one does alone, so that more of them
    than there are cores would gain nothing.
    """
    if arguments.workers is not None:
        return int(arguments.workers)
    can_ask = hasattr(os, "sched_getaffinity")
    cores = len(os.sched_getaffinity(0)) if can_ask else os.cpu_count() or 1
    if not hasattr(os, "sysconf") or "SC_PHYS_PAGES" not in os.sysconf_names:
        return cores
    memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return max(1, min(cores, memory // WORKER_BYTES))


def _tasks(
    sessions: Sequence[Path], out: Path | None, arguments: argparse.Namespace, journal: Journal
) -> list[Task]:
    """Return what is to be done with every session; FormatError where a file is in the way."""
    folder = common_folder(sessions)
    workers = _workers(arguments)
    tasks = []
    order = order_of(MotionOrder, arguments)
    if order != MotionOrder() and not arguments.export:
        raise FormatError("What is to be exported is missing: --export.")
    require_meant(order, arguments.export)
    for session in sessions:
        export = None
        if arguments.export:
            export = export_of(session, folder, out, arguments.export, order)
            if not arguments.overwrite and str(session) not in journal.begun:
                require_absent(places(export))
        done = str(session) in journal.done
        missing_only = arguments.only is not None or done
        threads = 1 if arguments.scheduler else max(1, workers // len(sessions))
        how = (order_of(TrackOrder, arguments), missing_only, export, threads)
        tasks.append(Task(session, *how))
    return tasks


def _report_event(reporter: BatchReporter, event: TaskEvent) -> None:
    """KeyposeError where it cannot be printed, unless nobody reads the output."""
    try:
        reporter.event(event)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise FormatError(f"The output cannot be written: {error.strerror}.") from None


@dataclass(eq=False)
class _Batch:
    """The sessions of this run by their numbers, and what has become of them.

    problem: the first reason why journal or report could not be written.
    """

    tasks: Sequence[Task]
    names: Sequence[str]
    journal: Journal
    summaries: dict[int, Summary] = field(default_factory=dict)
    problem: KeyposeError | None = None

    def note(self, write: Callable[[], None]) -> bool:
        """Write something about the batch; where that fails, the sessions go on all the same."""
        try:
            write()
        except KeyposeError as error:
            self.problem = self.problem or error
            return False
        return True

    def run(self, pool: WorkerPool, reporter: BatchReporter) -> bool:
        """Do all; False when it was interrupted."""
        stop = threading.Event()
        with set_when_interrupted(stop):
            for event in scheduler.run(self.tasks, pool, stop):
                session = self.tasks[event.number].session
                if isinstance(event, TaskStarted):
                    self.note(partial(self.journal.begin, session))
                elif isinstance(event, TaskFinished):
                    self.summaries[event.number] = event.summary
                    if event.summary.is_done:
                        self.note(partial(self.journal.finish, session))
                self.note(partial(_report_event, reporter, event))
        had_all = len(self.summaries) == len(self.tasks)
        return had_all and all(s.state != "interrupted" for s in self.summaries.values())

    @property
    def entries(self) -> list[Entry]:
        return [Entry(self.names[n], self.summaries[n]) for n in sorted(self.summaries)]

    @property
    def is_good(self) -> bool:
        """Return whether all are done and nothing was lost."""
        return all(s.is_done and not s.count("lost") for s in self.summaries.values())
