"""Many sessions side by side: what `keypose batch` and `keypose run` have in common."""

from __future__ import annotations

import argparse
import os
import sys
import threading
import time
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from keypose.app.cli.arguments import order_of
from keypose.app.cli.batch_progress import BatchReporter, batch_reporter
from keypose.app.cli.exit_codes import DONE, INTERRUPTED, NOT_ALL_DONE
from keypose.app.cli.long_work import set_when_interrupted, warm_tracker
from keypose.app.export.motion_formats import require_meant
from keypose.app.jobs.batch import scheduler
from keypose.app.jobs.batch.cluster import ClusterPool
from keypose.app.jobs.batch.journal import Journal
from keypose.app.jobs.batch.make_session import is_made_here
from keypose.app.jobs.batch.pool import LocalPool, WorkerPool
from keypose.app.jobs.batch.report import NAME, Entry, batch_html, is_report
from keypose.app.jobs.batch.run_one import export_of, places
from keypose.app.jobs.batch.scheduler import TaskEvent, TaskFinished, TaskStarted
from keypose.app.jobs.batch.task import Export, Summary, Task
from keypose.app.orders.motion import MotionOrder
from keypose.app.orders.order import options_of
from keypose.tracker.errors import FormatError, KeyposeError
from keypose.tracker.storage.atomic import make_folder, require_absent, require_folder, write_file

WORKER_BYTES = 2_000_000_000
"""What a worker may want: the program and the clip of its longest segment."""


def run_tasks(
    tasks_of: Callable[[Journal], Sequence[Task]],
    names: Sequence[str],
    place: Path,
    asked: Mapping[str, Any],
    arguments: argparse.Namespace,
) -> int:
    """Do all tasks, report of them, and write the report into a folder; the exit code.

    tasks_of: the tasks, in the order of their names, by what an earlier run of the same has done.
    asked: what makes a run the same, so that it goes on where it was interrupted.
    arguments: workers, scheduler, json.
    """
    _require_place(place)
    began = time.monotonic()
    with _journal(place, asked) as journal:
        tasks = tasks_of(journal)
        batch = _Batch(tasks, names, journal)
        paths = [str(task.session) for task in tasks]
        processes = min(workers_of(arguments), len(tasks))
        with (
            _pool(arguments, processes) as pool,
            batch_reporter(batch.names, paths, arguments.json) as reporter,
        ):
            reporter.start(len(journal.done & set(paths)))
            whole = batch.run(pool, reporter)
        if whole:
            batch.note(journal.end)
    seconds = time.monotonic() - began
    report = _report(batch, place, seconds) if whole else None
    reporter.finish(batch.entries, report, seconds, interrupted=not whole)
    return _code(batch, whole)


def motion_order_of(arguments: argparse.Namespace, *, but: Container[str] = ()) -> MotionOrder:
    """How motion is exported; FormatError where it is not said what is, or it does not matter.
    but: as of `order_of`."""
    order = order_of(MotionOrder, arguments, but=but)
    if order != MotionOrder() and not arguments.export:
        raise FormatError("What is to be exported is missing: --export.")
    require_meant(order, arguments.export)
    return order


def asked_of(arguments: argparse.Namespace, *names: str) -> dict[str, Any]:
    """What was asked for by these arguments and by those of exports, to know the same run by."""
    asked = {name: getattr(arguments, name) for name in ("export", *names)}
    exports = {name: getattr(arguments, name) for name in options_of(MotionOrder)}
    return asked | {name: str(value) for name, value in exports.items() if value}


def export_for(
    task: Task,
    folder: Path,
    out: Path | None,
    order: MotionOrder,
    arguments: argparse.Namespace,
    journal: Journal,
) -> Export | None:
    """The files of a session's motion to write, a film's beside its session; None where none are
    asked for. FormatError where a file is in the way that no earlier run of the same wrote.

    folder, out: of all sessions, and the place below which files go; None: beside each.
    """
    if not arguments.export:
        return None
    of_film = task.film is not None
    export = export_of(task.session, folder, None if of_film else out, arguments.export, order)
    is_ours = str(task.session) in journal.begun or (of_film and is_made_here(task.session))
    if not (arguments.overwrite or is_ours):
        require_absent(places(export))
    return export


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
        return NOT_ALL_DONE if whole else INTERRUPTED
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
def _journal(place: Path, asked: Mapping[str, Any]) -> Iterator[Journal]:
    journal = Journal(place, asked)
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


def workers_of(arguments: argparse.Namespace) -> int:
    """As many workers as were asked for, or one for each core that has enough memory.

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
        """Whether all are done and nothing was lost."""
        return all(s.is_done and not s.count("lost") for s in self.summaries.values())
