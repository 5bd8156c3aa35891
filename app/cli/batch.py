"""`keypose batch`: many saved sessions, or the films of a table, tracked without the page."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from keypose.app.cli.arguments import order_of
from keypose.app.cli.many import asked_of, export_for, motion_order_of, run_tasks, workers_of
from keypose.app.jobs.batch.films import is_table, placed, read_table
from keypose.app.jobs.batch.finding import common_folder, find_sessions, name_of
from keypose.app.jobs.batch.journal import Journal
from keypose.app.jobs.batch.task import Task
from keypose.app.orders.tracking import TrackOrder
from keypose.tracker.errors import SessionError


def run(arguments: argparse.Namespace) -> int:
    if arguments.scheduler is not None and arguments.workers is not None:
        raise SessionError("--workers is for this computer: a cluster has its own workers.")
    order = motion_order_of(arguments)
    out = None if arguments.out is None else arguments.out.absolute()
    named = _named(arguments.paths, out)
    folder = common_folder([task.session for _, task in named])
    asked = asked_of(arguments, "only", "method", "quality")
    asked["paths"] = sorted({os.path.realpath(path) for path in arguments.paths})

    def tasks_of(journal: Journal) -> list[Task]:
        return [
            replace(
                _task(task, arguments, journal, len(named)),
                export=export_for(task, folder, out, order, arguments, journal),
            )
            for _, task in named
        ]

    return run_tasks(tasks_of, [name for name, _ in named], out or folder, asked, arguments)


def _named(paths: Sequence[Path], out: Path | None) -> list[tuple[str, Task]]:
    """The tasks by what each is called: sessions, and films of tables."""
    tables = [path for path in paths if is_table(path)]
    others = [path for path in paths if not is_table(path)]
    named = []
    if others:
        sessions = find_sessions(others)
        folder = common_folder(sessions)
        named += [(name_of(session, folder), Task(session)) for session in sessions]
    films = [film for table in tables for film in read_table(table)]
    rows = placed(films, out) if films else []
    return named + [(row.name, Task(row.session, film=row.film, stand=True)) for row in rows]


def _task(task: Task, arguments: argparse.Namespace, journal: Journal, count: int) -> Task:
    """How a session is tracked, one of `count`."""
    done = str(task.session) in journal.done
    return replace(
        task,
        order=order_of(TrackOrder, arguments),
        missing_only=arguments.only is not None or done or task.film is not None,
        threads=1 if arguments.scheduler else max(1, workers_of(arguments) // count),
    )
