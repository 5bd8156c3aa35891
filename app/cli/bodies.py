"""The bodies of a session that a command is about."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from typing import Any

from keypose.app.cli.arguments import note, order_of
from keypose.app.orders.bodies import EachBody, OneBody
from keypose.tracker.session import Session
from keypose.tracker.session.bodies import TrackedBody, bodies_words, id_and_name


def about_one(
    session: Session,
    arguments: argparse.Namespace,
    is_preferred: Callable[[TrackedBody], bool] = lambda body: True,
) -> Session:
    """The session about the body that is asked for alone; SessionError where it is not there. The
    first of those preferred is taken where none is asked for, which is said where there are
    several."""
    name = order_of(OneBody, arguments).body
    if name is not None:
        return session.about_called(name)
    about = session.about(_first(session, is_preferred).id)
    if len(session.bodies) > 1:
        note(
            f"the session has {len(session.bodies)} bodies, {bodies_words(session.bodies)}. This "
            f"is {about.subject.id}; choose with --body."
        )
    return about


def about_drawn(session: Session, arguments: argparse.Namespace) -> tuple[Session, bool]:
    """The session about the body that is drawn in full, the first with a pose where none is asked
    for; and whether it is drawn alone. SessionError where it is not there."""
    name = order_of(EachBody, arguments).body
    if name is not None:
        return session.about_called(name), True
    return session.about(_first(session, _has_poses).id), False


def _has_poses(body: TrackedBody) -> bool:
    return bool(body.keyframes) or body.results is not None


def _first(session: Session, is_preferred: Callable[[TrackedBody], bool]) -> TrackedBody:
    """The body that is posed, where it is preferred or none is; else the first that is."""
    return next(filter(is_preferred, (session.subject, *session.bodies)), session.subject)


def about_each(session: Session, arguments: argparse.Namespace) -> list[Session]:
    """The session about each of its bodies alone, or about the one that is asked for; SessionError
    where it is not there."""
    name = order_of(EachBody, arguments).body
    if name is not None:
        return [session.about_called(name)]
    return [session.about(body.id) for body in session.bodies]


def heading(about: Session, of: Session) -> list[str]:
    """A line over what is printed of one body, where the session has several."""
    return [f"{id_and_name(about.subject)}:"] if len(of.bodies) > 1 else []


def by_body(facts: Mapping[str, Mapping[str, Any]], of: Session) -> Mapping[str, Any]:
    """What JSON says of bodies, by their ids: of the only body of a session its facts alone."""
    return {"bodies": facts} if len(of.bodies) > 1 else next(iter(facts.values()))
