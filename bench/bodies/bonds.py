"""Bonds: palms that meet, and a stick in a hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
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
)
from bench.bodies.promises import Promise
from bench.table import Report, Table
from bench.tracking import keyframes_every
from keypose.tracker.body.trajectory import joined
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.operations.solve_space import solved
from keypose.tracker.session import Session
from keypose.tracker.session.bonds import Bond, BondEnd
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
    """How far apart the places are that a bond holds together."""
    columns = ("tracked mm", "bonded mm", "off before", "off cm")
    report.note(
        "greatest distance of the places that meet, as tracked and with the bond; how far joints "
        "are off without it and with it, in the mean; keyframes that are disturbed are soft: exact "
        "ones stay as far apart as they are posed"
    )
    first, last = BONDED
    table = report.table(f"bonds over frames {first}–{last}, keyframes every {EVERY}", *columns)
    return [_meeting(table, meeting) for meeting in MEETINGS]


def _meeting(table: Table, meeting: Meeting) -> Promise:
    film = rendered_film(meeting.name, meeting.actors())
    true = film.keyposes(keyframes_every(EVERY, 0, FRAMES - 1))
    cases = {"exact": film.session(true)} | {
        f"disturbed {seed}": softened(film.session(disturbed(film, true, seed))) for seed in SEEDS
    }
    apart = [
        _bonded_mm(table, meeting, film, f"{meeting.name}, {kind}", session)
        for kind, session in cases.items()
    ]
    return Promise.at_most(f"{meeting.name}: places that meet", max(apart), meeting.most_mm, "mm")


def softened(session: Session) -> Session:
    """The session with keyframes that are met nearly."""
    bodies = tuple(
        body.model_copy(
            update={"keyframes": tuple(k.model_copy(update={"soft": True}) for k in body.keyframes)}
        )
        for body in session.bodies
    )
    return session.model_copy(update={"bodies": bodies})


def _bonded_mm(table: Table, meeting: Meeting, film: Film, name: str, session: Session) -> float:
    """One line, and how far apart the places are with the bond."""
    bound = session.model_copy(update={"bonds": (meeting.bond(film),)})
    results = all_tracked(session, film.video)
    together = in_space(bound, results)
    sessions = ((session, results), (bound, together))
    before, after = (float(_apart_mm(meeting, film, *each).max()) for each in sessions)
    table.row(name, before, after, *(_off_cm(film, *each) for each in sessions))
    return after


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
