"""The soles of two on one floor, that which the first of them finds.

Their feet are exactly on one floor in truth. Keyframes are exact, disturbed as by a hand, or of
distances that are wrong, as somebody poses who sees one film.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Final

from bench.bodies.film import SEEDS, Film, Keyposes, all_tracked, disturbed, rendered_film
from bench.bodies.people import FRAMES, on_one_floor
from bench.bodies.promises import Promise
from bench.standing_cases import posed_at
from bench.standing_measures import MOST_SOLES_CM
from bench.table import Report
from bench.tracking import keyframes_every
from keypose.app.jobs.stand import resolved, stood_beside
from keypose.tracker.operations.stand import in_standing_order, stand
from keypose.tracker.session import Session
from keypose.tracker.space.soles import soles_of
from keypose.tracker.storage.results import Results

EVERY: Final = 24
SHARES: Final = (0.97, 1.03)
"""Of the true distances of the two, where these are wrong."""


def floor(report: Report) -> list[Promise]:
    """How far soles are from the floor, of each body that stands first, and second."""
    report.note(
        "soles: the greatest distance of a pinned heel or toe from the floor, where the body finds "
        "that itself, and where the other one has found it before; the program takes that of the "
        "one who walks farther"
    )
    table = report.table("soles, stood on a floor", "own cm", "other's cm")
    film = rendered_film("floor", on_one_floor())
    true = film.keyposes(keyframes_every(EVERY, 0, FRAMES - 1))
    kinds = {
        "exact": [true],
        "disturbed": [disturbed(film, true, seed) for seed in SEEDS],
        "distances wrong": [_at_wrong_distances(film, true)],
    }
    promises = []
    for kind, cases in kinds.items():
        worst = 0.0
        for number, keyposes in enumerate(cases, 1):
            soles = _soles_of_each(film, keyposes)
            for name, (own, others) in soles.items():
                table.row(f"{name}, {kind} {number}", own, others)
            (own, _), (_, others) = soles.values()
            worst = max(worst, own, others)
        promises.append(Promise.at_most(f"soles, {kind}", worst, MOST_SOLES_CM, "cm"))
    return promises


def _at_wrong_distances(film: Film, keyposes: Keyposes) -> Keyposes:
    return {
        actor.id: {
            frame: posed_at(actor.skeleton, film.camera, pose, share)
            for frame, pose in keyposes[actor.id].items()
        }
        for actor, share in zip(film.actors, SHARES, strict=True)
    }


def _soles_of_each(film: Film, keyposes: Keyposes) -> dict[str, tuple[float, float]]:
    """How far the soles of each are from its own floor, and from that of the other; the one whose
    floor the program takes comes first."""
    session = film.session(keyposes)
    results = all_tracked(session, film.video)
    first, last = keyposes
    forward, backward = (
        soles_cm(session, results, order) for order in ((first, last), (last, first))
    )
    own_and_others = {
        first: (forward[first], backward[first]),
        last: (backward[last], forward[last]),
    }
    fittings = {body_id: results.fitting(session.about(body_id)) for body_id in keyposes}
    return {body_id: own_and_others[body_id] for body_id in in_standing_order(session, fittings)}


def soles_cm(session: Session, results: Results, order: Sequence[str]) -> dict[str, float]:
    """How far pinned soles are from the floor at most, by the id of their body: all bodies stand
    one after the other on the floor that the first of them finds."""
    whole, off = session, dict[str, float]()
    for body_id in order:
        about = whole.about(body_id)
        stand_there = partial(stand, fitting=results.fitting(about), tilts=not off)
        done = stood_beside(about, whole.world, stand_there) if off else stand_there(about)
        whole = done.session
        soles = soles_of(whole, resolved(whole, results).space(whole))
        assert soles is not None
        off[body_id] = 100 * abs(soles.off_m)
    return off
