"""`keypose track`: find the motion between the keyframes and save it beside the session."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from keypose.app.cli.arguments import note, order_of
from keypose.app.cli.bodies import about_each, about_one, heading
from keypose.app.cli.json_output import print_json
from keypose.app.cli.long_work import share_reporter
from keypose.app.cli.outcome import locked_place, track_and_save
from keypose.app.jobs.find_camera import find_saved, found_words, is_camera_wanted, with_found
from keypose.app.jobs.rerun import require_trackable, with_settings
from keypose.app.orders.tracking import FilmTaken, TrackOrder, said
from keypose.app.words.bonds import keyed_apart_sentences
from keypose.tracker.errors import SessionError
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session, save_session


def _as_taken(session: Session, arguments: argparse.Namespace) -> Session:
    """The session with what the command line says of how the film was taken. That is saved, too,
    unless a copy is tracked (`--out`)."""
    if not (taken := said(order_of(FilmTaken, arguments))):
        return session
    from keypose.app.editor.camera import as_taken  # which loads the page's edits

    session = as_taken(session, taken)
    if arguments.out is None:
        with locked_place(arguments) as place:
            save_session(session, place)
    return session


def _with_camera(session: Session, asked: Session, arguments: argparse.Namespace) -> Session:
    """The session with its camera's motion, which is found where that is asked for and it is not
    known. It is saved, too, unless a copy is tracked.

    asked: the session with the settings of this run, which are not saved.
    """
    if not is_camera_wanted(asked):
        return session
    with locked_place(arguments) as place, share_reporter(arguments.json) as report:
        found_camera = find_saved(asked, arguments.session, None, report)
        session = with_found(session, found_camera)
        if arguments.out is None:
            save_session(session, place)
    print(found_words(found_camera), file=sys.stderr, flush=True)
    return session


def run(arguments: argparse.Namespace) -> int:
    session = load_session(arguments.session)
    if arguments.out is not None and len(session.bodies) > 1:
        raise SessionError("A copy is made of sessions of one body: leave --out away.")
    session = _as_taken(session, arguments)
    if arguments.ahead is None:
        bodies = _trackable(about_each(session, arguments), arguments.session)
    elif arguments.frames is not None:
        raise SessionError("--frames is for segments: tracking ahead goes as far as it can.")
    order = order_of(TrackOrder, arguments)
    session = _with_camera(session, with_settings(session, order), arguments)
    asked = with_settings(session, order)
    if arguments.ahead is not None:
        from keypose.app.cli.ahead import track_ahead_and_save  # which loads the page's edits

        about = about_one(session, arguments)
        asked = asked.about(about.subject.id)
        return track_ahead_and_save(about, asked, session.subject.id, arguments)
    for words in keyed_apart_sentences(session):
        note(words)
    codes = []
    for name in bodies:
        _announce(session.about(name), session, arguments.json)
        codes.append(
            track_and_save(session.about(name), asked.about(name), arguments, arguments.frames)
        )
    return max(codes)


def _announce(about: Session, of: Session, as_json: bool) -> None:
    """Say which of several bodies what follows is about."""
    if as_json and len(of.bodies) > 1:
        print_json({"event": "body_started", "body": about.subject.id})
    elif not as_json:
        for line in heading(about, of):
            print(line, flush=True)


def _trackable(bodies: Sequence[Session], path: Path) -> list[str]:
    """The ids of the bodies that can be tracked, with a note of each of several that cannot;
    SessionError where none can."""
    ids, refused = [], list[SessionError]()
    for about in bodies:
        try:
            require_trackable(about, path)
        except SessionError as error:
            refused.append(error)
            if len(bodies) > 1:
                note(f"{about.subject.id} was not tracked. {error}")
        else:
            ids.append(about.subject.id)
    if not ids:
        raise refused[0]
    return ids
