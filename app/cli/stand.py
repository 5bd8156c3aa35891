"""`keypose stand`: the tracked motion with its feet on the floor."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

from keypose.app.cli.arguments import note
from keypose.app.cli.bodies import about_each, by_body, heading
from keypose.app.cli.change import Change, run_change
from keypose.app.jobs.stand import BodyStood, resolved, stood_together
from keypose.app.words.bodies import after_id
from keypose.app.words.problems import pin_sentence
from keypose.app.words.standing import along_words, refused_words, soles_words, standing_words
from keypose.tracker.geometry.up import Disagreement
from keypose.tracker.operations.stand import Standing, with_things_along
from keypose.tracker.session import Session
from keypose.tracker.session.pins import Pin
from keypose.tracker.space.harm import Harm
from keypose.tracker.space.soles import Soles
from keypose.tracker.storage.results import Results, load_results, save_results


def run(arguments: argparse.Namespace) -> int:
    return run_change(arguments, _stood)


def _stood(session: Session, arguments: argparse.Namespace) -> Change:
    """Stand the bodies one after the other on one floor: that which the first of them finds."""
    path, asked = arguments.session, [about.subject.id for about in about_each(session, arguments)]
    whole, standing, refused = stood_together(session, path, asked)
    along = with_things_along(whole, standing)[1]
    for body_id, words in refused.items():
        if body_id in along:
            continue
        refusal = refused_words(words, next(iter(standing)))
        note(after_id(refusal, body_id, session))
    results = {body_id: each.results for body_id, each in standing.items()}
    for body in whole.bodies:
        if body.id not in standing and body.results is not None:
            about = whole.about(body.id)
            results[body.id] = resolved(about, load_results(about, path))
    lines = [
        line
        for each in standing.values()
        for line in (*heading(each.done.session, session), *_lines(each))
    ]
    lines += [along_words(body_id) for body_id in along]
    facts = {name: _facts(each.done, each.soles) for name, each in standing.items()}
    return Change(lambda: _saved(whole, path, results), tuple(lines), by_body(facts, session))


def _saved(whole: Session, path: Path, results: Mapping[str, Results]) -> Session:
    for name, each in results.items():
        whole = save_results(whole.about(name), path, each).about(whole.subject.id)
    return whole


def _lines(stood_body: BodyStood) -> tuple[str, ...]:
    done, soles = stood_body.done, stood_body.soles
    held = [pin for stretch in stood_body.results.space(done.session) for pin in stretch.pins]
    return (
        standing_words(done, beside=stood_body.beside),
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
