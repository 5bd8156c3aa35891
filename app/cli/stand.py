"""`keypose stand`: the tracked motion with its feet on the floor."""

from __future__ import annotations

import argparse

from keypose.app.cli.change import Change, run_change
from keypose.app.jobs.stand import stood
from keypose.app.words.problems import pin_sentence
from keypose.app.words.standing import soles_words, standing_words
from keypose.tracker.geometry.up import Disagreement
from keypose.tracker.operations.stand import Standing
from keypose.tracker.session import Session
from keypose.tracker.session.pins import Pin
from keypose.tracker.space.harm import Harm
from keypose.tracker.space.soles import Soles, soles_of
from keypose.tracker.storage.results import Results, load_results, save_results


def run(arguments: argparse.Namespace) -> int:
    return run_change(arguments, _stood)


def _stood(session: Session, arguments: argparse.Namespace) -> Change:
    path = arguments.session
    done, results = stood(session, path, load_results(session, path))
    soles = soles_of(done.session, results.space(done.session))
    return Change(
        lambda: save_results(done.session, path, results),
        _lines(done, soles, results),
        _facts(done, soles),
    )


def _lines(done: Standing, soles: Soles | None, results: Results) -> tuple[str, ...]:
    held = [pin for stretch in results.space(done.session) for pin in stretch.pins]
    return (
        standing_words(done),
        *(() if soles is None else (soles_words(soles),)),
        *(pin_sentence(pin) for pin in held if pin.keyframe is not None),
    )


def _facts(done: Standing, soles: Soles | None) -> dict[str, object]:
    session: Session = done.session
    return {
        "pins_on_floor": done.on_floor,
        "pins_taken": done.taken,
        "softened": list(done.softened),
        "up_camera": session.world.up_world,
        "up_from": list(done.up.sources),
        "up_sigma_rad": done.up.sigma_rad,
        "up_apart": [_apart(disagreement) for disagreement in done.up.apart],
        "floor_m": session.world.floor_m,
        "tilted_rad": done.tilted_rad,
        "released": [_harm(harm) for harm in done.released],
        "pins": [_harm(harm) for harm in done.harms],
        "hanging": [{**_pin(pin), "above_floor_m": high} for pin, high in done.hanging],
        "raised": [_pin(pin) for pin in done.raised],
        "unscaled": [list(span) for span in done.unscaled],
        "soles_off_m": None if soles is None else soles.off_m,
        "in_air": [] if soles is None else [list(run) for run in soles.in_air],
    }


def _apart(disagreement: Disagreement) -> dict[str, object]:
    """A source that disagrees with what up rests on."""
    return {
        "from": disagreement.evidence.source,
        "up_camera": disagreement.evidence.up.tolist(),
        "sigma_rad": disagreement.evidence.sigma_rad,
        "sigmas": disagreement.sigmas,
    }


def _harm(harm: Harm) -> dict[str, object]:
    """What a pin does: pixels or radians."""
    unit = {"picture": "moves_px", "knee": "bends_rad"}[harm.kind]
    return {**_pin(harm.pin), unit: harm.amount, "at_part": harm.part, "at_frame": harm.frame}


def _pin(pin: Pin) -> dict[str, object]:
    return {"part": pin.part, "frames": list(pin.span)}
