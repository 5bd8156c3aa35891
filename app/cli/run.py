"""`keypose run`: from films to motion without a hand."""

from __future__ import annotations

import argparse
import os
from dataclasses import replace

from keypose.app.cli.arguments import film_orders_of, order_of
from keypose.app.cli.many import asked_of, export_for, motion_order_of, run_tasks, workers_of
from keypose.app.jobs.batch.films import PlacedFilm, films_in, placed
from keypose.app.jobs.batch.journal import Journal
from keypose.app.jobs.batch.task import Task
from keypose.app.orders.film import FilmOrder, FilmToDraft
from keypose.app.orders.order import options_of
from keypose.app.orders.tracking import TrackOrder
from keypose.tracker.errors import SessionError


def run(arguments: argparse.Namespace) -> int:
    said = film_orders_of(arguments)
    films = [FilmToDraft(path, **said) for path in films_in(arguments.films)]
    if len(films) > 1 and said["order"].box is not None:
        raise SessionError(
            "--box is for one film: give the boxes of several in a table to `keypose batch`."
        )
    if arguments.beside:
        if len(films) > 1:
            raise SessionError(
                "--beside is for one film: give the other films of several in a table to "
                "`keypose batch`."
            )
        films = [replace(films[0], beside=films_in(arguments.beside))]
    order = motion_order_of(arguments, but=options_of(FilmOrder))
    out = arguments.out.absolute()
    rows = placed(films, out)

    def task_of(row: PlacedFilm, journal: Journal) -> Task:
        task = Task(
            row.session,
            order_of(TrackOrder, arguments),
            missing_only=True,
            threads=max(1, workers_of(arguments) // len(rows)),
            film=row.film,
            anew=arguments.overwrite and str(row.session) not in journal.begun,
            stand=arguments.stand is not False,
        )
        return replace(task, export=export_for(task, out, None, order, arguments, journal))

    asked = asked_of(arguments, "stand", "overwrite")
    asked["films"] = sorted(os.path.realpath(film.path) for film in films)
    asked["said"] = repr((*said.values(), order_of(TrackOrder, arguments)))
    if arguments.beside:
        asked["beside"] = sorted(os.path.realpath(film) for film in films[0].beside)
    return run_tasks(
        lambda journal: [task_of(row, journal) for row in rows],
        [row.name for row in rows],
        out,
        asked,
        arguments,
    )
