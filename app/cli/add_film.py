"""`keypose add-film`: another film of the same motion."""

from __future__ import annotations

import argparse

from keypose.app.cli.arguments import order_of
from keypose.app.cli.change import Change, run_change
from keypose.app.cli.long_work import share_reporter
from keypose.app.jobs.add_film import found_film
from keypose.app.jobs.with_film import AddedFilm, added_words
from keypose.app.orders.film import BesideOrder
from keypose.app.orders.tracking import FilmTaken
from keypose.app.words.films import place_of, turned_deg
from keypose.tracker.session import Session


def run(arguments: argparse.Namespace) -> int:
    return run_change(arguments, _added)


def _added(session: Session, arguments: argparse.Namespace) -> Change:
    path = arguments.session
    order = order_of(BesideOrder, arguments)
    with share_reporter(arguments.json) as report:
        added = found_film(
            session,
            path,
            arguments.video,
            order,
            report,
            calibration=arguments.calibration,
            taken=order_of(FilmTaken, arguments),
        )
    return Change(lambda: added.saved(path), added_words(session, added), _facts(added))


def _facts(added: AddedFilm) -> dict[str, object]:
    view, clock, placed = added.view, added.view.clock, added.view.placed
    assert clock is not None
    assert placed is not None
    return {
        "view": view.id,
        "begins": clock.begins,
        "begins_sigma": clock.sigma,
        "also": list(clock.also),
        "rate": clock.rate,
        "camera_m": place_of(view).tolist(),
        "camera_sigma_m": placed.place_sigma_m,
        "turned_deg": turned_deg(view),
        "turned_sigma_rad": placed.turn_sigma_rad,
        "focal_mm": view.camera.focal_mm,
        "keyframes_moved_m": {str(frame): m for frame, m in added.mended.moved_m.items()},
    }
