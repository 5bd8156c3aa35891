"""`keypose track`: find the motion between the keyframes and save it beside the session."""

from __future__ import annotations

import argparse

from keypose.app.cli.ahead import track_ahead_and_save
from keypose.app.cli.arguments import order_of
from keypose.app.cli.outcome import locked_place, track_and_save
from keypose.app.editor.camera import as_taken
from keypose.app.jobs.rerun import require_trackable, with_settings
from keypose.app.orders.tracking import FilmTaken, TrackOrder, said
from keypose.tracker.errors import SessionError
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session, save_session


def _as_taken(session: Session, arguments: argparse.Namespace) -> Session:
    """The session as the film was taken, which its file says too, unless a copy is tracked."""
    if not (taken := said(order_of(FilmTaken, arguments))):
        return session
    session = as_taken(session, taken)
    if arguments.out is None:
        with locked_place(arguments) as place:
            save_session(session, place)
    return session


def run(arguments: argparse.Namespace) -> int:
    session = _as_taken(load_session(arguments.session), arguments)
    if arguments.ahead is None:
        for body in session.bodies:
            require_trackable(session.about(body.id), arguments.session)
    elif arguments.frames is not None:
        raise SessionError("--frames is for segments: tracking ahead goes as far as it can.")
    asked = with_settings(session, order_of(TrackOrder, arguments))
    if arguments.ahead is not None:
        return track_ahead_and_save(session, asked, arguments)
    if arguments.out is not None and len(session.bodies) > 1:
        raise SessionError("A copy is made of sessions of one body: leave --out away.")
    codes = [
        track_and_save(session.about(body.id), asked.about(body.id), arguments, arguments.frames)
        for body in session.bodies
    ]
    return max(codes)
