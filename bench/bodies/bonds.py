"""Bonds and the floor: palms that meet, a stick in a hand, and the soles of all on one floor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np

from bench.bodies.film import SEEDS, Actor, Film, all_tracked, disturbed, rendered_film
from bench.bodies.people import (
    FRAMES,
    HAND,
    HANDLE_M,
    PALM_M,
    STICK,
    grip,
    handshake,
    place_path,
    speaking_before,
)
from bench.bodies.promises import Promise
from bench.standing_measures import MOST_SOLES_CM
from bench.table import Report, Table
from bench.tracking import keyframes_every
from keypose.app.jobs.stand import resolved, stood_beside
from keypose.tracker.body.trajectory import joined
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.operations.solve_space import solved
from keypose.tracker.operations.stand import stand
from keypose.tracker.session import Session
from keypose.tracker.session.bonds import Bond, BondEnd
from keypose.tracker.space.soles import soles_of
from keypose.tracker.storage.results import Results

EVERY: Final = 24
BONDED: Final = (8, 64)
"""First and last frame over which a bond holds."""


@dataclass(frozen=True)
class Meeting:
    """Two bodies of which a place each meets.

    places: part and place in its frame, of the one and of the other.  most_mm: between them.
    """

    name: str
    actors: Callable[[], tuple[Actor, Actor]]
    places: tuple[tuple[str, tuple[float, float, float]], ...]
    most_mm: float

    def bond(self, film: Film) -> Bond:
        holder, held = (
            BondEnd(body=actor.id, part=part, point_m=place)
            for actor, (part, place) in zip(film.actors, self.places, strict=True)
        )
        return Bond(holder=holder, held=held, first_frame=BONDED[0], last_frame=BONDED[1])


MEETINGS: Final = (
    Meeting("handshake", handshake, ((HAND, PALM_M), (HAND, PALM_M)), 2.0),
    Meeting("grip", grip, ((HAND, PALM_M), (STICK, HANDLE_M)), 1.0),
)


def bonds(report: Report) -> list[Promise]:
    """Palms, a grip, and soles."""
    columns = ("tracked mm", "bonded mm", "off before", "off cm")
    report.note("greatest distance of the places that meet, as tracked and with the bond; how far")
    report.note("joints are off without it and with it, in the mean; keyframes are exact")
    first, last = BONDED
    table = report.table(f"bonds over frames {first}–{last}, keyframes every {EVERY}", *columns)
    promises = [_meeting(table, meeting) for meeting in MEETINGS]
    return [*promises, *_floor(report)]


def _meeting(table: Table, meeting: Meeting) -> Promise:
    film = rendered_film(meeting.name, meeting.actors())
    frames = keyframes_every(EVERY, 0, FRAMES - 1)
    session = film.session(film.keyposes(frames))
    bound = session.model_copy(update={"bonds": (meeting.bond(film),)})
    results = all_tracked(session, film.video)
    together = in_space(bound, results)
    sessions = ((session, results), (bound, together))
    before, after = (float(_apart_mm(meeting, film, *each).max()) for each in sessions)
    table.row(meeting.name, before, after, *(_off_cm(film, *each) for each in sessions))
    return Promise.at_most(f"{meeting.name}: places that meet", after, meeting.most_mm, "mm")


def in_space(session: Session, results: Results) -> Results:
    """The results of all bodies with what is solved for in space."""
    for body in session.bodies:
        about = session.about(body.id)
        for stretch in results.unsolved(about):
            results = results.with_space(solved(about, stretch))
    return results


def _apart_mm(meeting: Meeting, film: Film, session: Session, results: Results) -> Array:
    """(n,) how far the places are from each other over the frames of the bond."""
    paths = []
    for actor, (part, place) in zip(film.actors, meeting.places, strict=True):
        fitting = results.fitting(session.about(actor.id))
        motion = joined([fitting[span].trajectory for span in sorted(fitting)])
        paths.append(place_path(actor.skeleton, motion, part, place))
    return 1000 * np.linalg.norm(paths[0] - paths[1], axis=-1)[BONDED[0] : BONDED[1] + 1]


def _off_cm(film: Film, session: Session, results: Results) -> float:
    """The mean distance of all bodies' joints from the truth."""
    off = []
    for actor in film.actors:
        fitting = results.fitting(session.about(actor.id))
        motion = joined([fitting[span].trajectory for span in sorted(fitting)])
        away = np.linalg.norm(motion.joints(actor.skeleton) - actor.joints[: len(motion)], axis=-1)
        off.append(away.mean())
    return 100 * float(np.mean(off))


def _floor(report: Report) -> list[Promise]:
    report.note(
        "soles: the greatest distance of a pinned heel or toe from the floor, where the body finds "
        "that itself, and where the other one has found it before"
    )
    table = report.table("soles, stood on a floor", "own cm", "other's cm")
    film = rendered_film("speaking", speaking_before())
    promises = []
    for kind, seeds in (("exact", (None,)), ("disturbed", SEEDS)):
        worst = dict.fromkeys((actor.id for actor in film.actors), 0.0)
        for seed in seeds:
            for name, (own, others) in _soles_of_each(film, seed).items():
                table.row(f"{name}, {kind}{'' if seed is None else f' {seed}'}", own, others)
                worst[name] = max(worst[name], others)
        promises += [
            Promise.at_most(f"soles of {name}, {kind}", off, MOST_SOLES_CM, "cm")
            for name, off in worst.items()
        ]
    return promises


def _soles_of_each(film: Film, seed: int | None) -> dict[str, tuple[float, float]]:
    """How far the soles of each are from its own floor, and from that of the other."""
    keyposes = disturbed(film, film.keyposes(keyframes_every(EVERY, 0, FRAMES - 1)), seed)
    session = film.session(keyposes)
    results = all_tracked(session, film.video)
    first, last = keyposes
    forward, backward = (
        soles_cm(session, results, order) for order in ((first, last), (last, first))
    )
    return {first: (forward[first], backward[first]), last: (backward[last], forward[last])}


def soles_cm(session: Session, results: Results, order: Sequence[str]) -> dict[str, float]:
    """How far pinned soles are from the floor at most, by the id of their body: all bodies stand
    one after the other on the floor that the first of them finds."""
    whole, off = session, dict[str, float]()
    for body_id in order:
        about = whole.about(body_id)
        stand_there = partial(stand, fitting=results.fitting(about))
        done = stood_beside(about, whole.world, stand_there) if off else stand_there(about)
        whole = done.session
        soles = soles_of(whole, resolved(whole, results).space(whole))
        assert soles is not None
        off[body_id] = 100 * abs(soles.off_m)
    return off
