"""Make the session of a film that nobody has opened: whom it shows, a draft, camera, keyframes.

What was done stands in the session's file, so that the same order goes on from there: drafts that
are left, drafts that are no keyframes yet. Beside it `person.json` says what was asked for.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from threading import Event
from typing import Final, TypeAlias

import cv2
import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError

from keypose.app.editor.drafted import (
    flipped_drafts,
    missing_frames,
    proposed_frames,
    require_draftable,
    with_accepted,
)
from keypose.app.export.report.images import jpeg
from keypose.app.jobs.add_film import found_film
from keypose.app.jobs.batch.films import SEPARATOR
from keypose.app.jobs.batch.task import Stage, Step, Task
from keypose.app.jobs.draft import drafted_people, progress_of
from keypose.app.jobs.film_session import (
    WhoIsDrafted,
    begun_session,
    frames_to_draft,
    opened_film,
    who_are_drafted,
    with_people_kept,
)
from keypose.app.jobs.find_camera import find_saved, found_words, with_found
from keypose.app.jobs.find_up import with_up_unseen
from keypose.app.jobs.rerun import with_repeats, with_settings
from keypose.app.jobs.with_film import added_words
from keypose.app.orders.film import FILM_ORDERS, BesideOrder, FilmToDraft
from keypose.app.orders.tracking import said
from keypose.app.words.bodies import after_id
from keypose.app.words.people import (
    accepted_words,
    another_person_words,
    assumed_words,
    flipped_words,
    found_person_words,
    undrafted_words,
)
from keypose.tracker.body.modify import height
from keypose.tracker.errors import KeypointError, KeyposeError, SessionError
from keypose.tracker.files import read_own
from keypose.tracker.fitting.draft import DraftProgress
from keypose.tracker.keypoints.on_animal import is_animals
from keypose.tracker.keypoints.region import Box
from keypose.tracker.session import Session
from keypose.tracker.session.settings import FrameIndex
from keypose.tracker.storage.atomic import write_file
from keypose.tracker.storage.files import LARGEST_SESSION_BYTES, load_session, save_session
from keypose.tracker.storage.journal import NAME as JOURNAL
from keypose.tracker.tracking.pool import Cancelled
from keypose.tracker.video import Video
from keypose.tracker.video.info import MissingFrame

RECORD: Final = "person.json"
PICTURE: Final = "person.jpg"
"""Beside the session, the frame of the box with the box."""
LARGEST_RECORD_BYTES: Final = 2**16
"""Of the record of who was found."""
PICTURE_PX: Final = 360
BOX_RGB: Final = (64, 200, 120)
SendStep: TypeAlias = Callable[[Step], None]


class _Record(BaseModel):
    """What was asked for of a film, and who is drafted in it; others: further people on the same
    frame; notes: what was found by itself."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    asked: dict[str, str]
    frame: FrameIndex
    box: Box
    others: tuple[Box, ...] = ()
    notes: tuple[str, ...] = ()

    def with_note(self, words: str) -> _Record:
        """The same with a sentence, unless it is empty or known."""
        if not words or words in self.notes:
            return self
        return self.model_copy(update={"notes": (*self.notes, words)})


def is_made_here(session_path: Path) -> bool:
    """Whether a session was made of a film without a person's hand."""
    return session_path.with_name(RECORD).is_file()


def notes_of(session_path: Path) -> tuple[str, ...]:
    """What was decided while such a session was made, a sentence each."""
    record = _record_of(session_path)
    return () if record is None else record.notes


def add_notes(session_path: Path, sentences: Iterable[str]) -> None:
    """Keep further sentences of what was decided."""
    record = _record_of(session_path)
    if record is None:
        return
    for words in sentences:
        record = record.with_note(words)
    _write_record(record, session_path)


def make_session(task: Task, film: FilmToDraft, send: SendStep, stop: Event) -> None:
    """Make the session of a film, or what of it is not made yet; a session that was begun by hand
    is left as it is.

    Cancelled once `stop` is set, with what is done kept; KeyposeError in one sentence where the
    film cannot be drafted, or the session is there and was made of another order.
    """
    path = task.session
    kept = _set_aside(path) if task.anew else ""
    is_there, record = path.is_file(), _record_of(path)
    if is_there and record is None:
        _require_nothing_asked(film, path)
        return
    if record is not None and record.asked != _asked(task, film):
        raise SessionError(
            f"{path.parent.name} is there and was made with other options: use the same, choose "
            "another folder, or begin anew with `keypose run` and --overwrite."
        )
    session = load_session(path) if is_there else None
    if record is None or session is None or _is_left(session):
        session, record = _drafted(task, film, record, kept, send, stop)
    if not session.subject.keyframes:
        session, record = _with_camera(session, path, record, _sender(send, "camera", stop))
        session, record = _accept(session, path, record)
    if film.beside:
        _with_films(session, path, record, film.beside, send, stop)


def _with_films(
    session: Session,
    path: Path,
    record: _Record,
    films: Sequence[Path],
    send: SendStep,
    stop: Event,
) -> None:
    """Add the films that are not in the session yet; written. One that cannot be synchronised with
    the first is left out, which is said."""
    folder = path.parent
    there = {os.path.realpath(folder / view.video.path) for view in session.views}
    for film in films:
        if os.path.realpath(film) in there:
            continue
        try:
            added = found_film(
                session, path, film, BesideOrder(), _sender(send, "films", stop), stop.is_set
            )
        except KeyposeError as error:
            record = record.with_note(f"{film.name} was left out. {error}")
        else:
            for words in added_words(session, added):
                record = record.with_note(words)
            session = added.saved(path)
        _write_record(record, path)
        save_session(session, path)


def _require_nothing_asked(film: FilmToDraft, path: Path) -> None:
    if film.beside or any(said(getattr(film, name)) for name in FILM_ORDERS):
        raise SessionError(
            f"{path.parent.name} is there and was begun by hand, so what is said of its film does "
            "not count: leave that out, or begin anew with `keypose run` and --overwrite."
        )


def _asked(task: Task, film: FilmToDraft) -> dict[str, str]:
    orders = {name: getattr(film, name) for name in FILM_ORDERS} | {"track": task.order}
    return {
        f"{name}.{field}": str(value)
        for name, order in orders.items()
        for field, value in said(order).items()
    } | ({"beside": SEPARATOR.join(map(str, film.beside))} if film.beside else {})


def _is_left(session: Session) -> bool:
    """Whether a draft was cancelled before its end, and nobody has posed anything since."""
    subject = session.subject
    is_whole = subject.drafted is not None and subject.drafted.rest is None
    is_posed = bool(subject.keyframes) or not all(draft.is_found for draft in subject.drafts)
    return not is_whole and not is_posed


def _drafted(
    task: Task,
    film: FilmToDraft,
    record: _Record | None,
    kept: str,
    send: SendStep,
    stop: Event,
) -> tuple[Session, _Record]:
    """The session with its drafts, written; and whom they are of.

    kept: what is said of a session that was there before.
    """
    path = task.session
    with opened_film(film) as video:
        session = with_settings(begun_session(film, video, path), task.order)
        frames = frames_to_draft(film.order, session)
        if record is None:
            report = _sender(send, "person", stop)
            people = who_are_drafted(film.order, session, video, report)
            record = _begin_record(task, film, people).with_note(kept)
            record = record.with_note(_assumed(film, session))
        people = [WhoIsDrafted(record.frame, box) for box in (record.box, *record.others)]
        for who in people:
            require_draftable(session, who.frame, who.box, frames)
        session, words = with_up_unseen(session, video)
        record = record.with_note(words)
        session = with_repeats(session, video, *frames)
        report_share = _sender(send, "draft", None)

        def report_draft(progress: DraftProgress) -> None:
            report_share(progress_of(progress)[0])

        drafts = drafted_people(
            session,
            video,
            record.frame,
            [who.box for who in people],
            frames,
            proportions=True,
            report=report_draft,
            cancelled=stop.is_set,
        )
        session = with_people_kept(session, video, path, people, frames, drafts)
        _write_picture(people[0], video, path.with_name(PICTURE))
    _write_record(record, path)
    save_session(session, path)
    if drafts[0].detected is not None:
        raise Cancelled
    return session, record


def _assumed(film: FilmToDraft, session: Session) -> str:
    """What depth and lengths rest on that nobody said."""
    body, camera = session.subject.body, session.view.camera
    height_cm = 100 * height(body) if film.order.height_cm is None else None
    lens_mm = camera.focal_mm if session.view.lens_is_guess else None
    return assumed_words(height_cm, lens_mm, body.name if is_animals(body) else "person")


def _with_camera(
    session: Session, path: Path, record: _Record, report: Callable[[float], None]
) -> tuple[Session, _Record]:
    """The session with its camera's motion, where it has one that nobody knows yet; written."""
    if session.has_static_camera or session.view.camera_motion is not None:
        return session, record
    found_camera = find_saved(session, path, None, report)
    session, record = with_found(session, found_camera), record.with_note(found_words(found_camera))
    _write_record(record, path)
    save_session(session, path)
    return session, record


def _accept(session: Session, path: Path, record: _Record) -> tuple[Session, _Record]:
    """The session with the proposed drafts of all bodies as keyframes, written; and which these
    are. KeypointError where nobody is seen well enough."""
    posed, accepted, refused = session.subject.id, 0, list[KeypointError]()
    for body in session.bodies:
        try:
            session, words = _body_accepted(session.about(body.id))
            accepted += 1
        except KeypointError as error:
            refused.append(error)
            words = (str(error),)
        for sentence in words:
            record = record.with_note(after_id(sentence, body.id, session))
    if not accepted:
        raise refused[0]
    session = session.about(posed)
    _write_record(record, path)
    save_session(session, path)
    return session, record


def _body_accepted(session: Session) -> tuple[Session, tuple[str, ...]]:
    """The same of the body that is posed, not written; and sentences on what was accepted."""
    frames, drafted = proposed_frames(session), session.subject.drafted
    if len(frames) < 2 or drafted is None:
        raise KeypointError(
            "The person is seen well in too few frames to be tracked: give another box, or other "
            "frames."
        )
    others = [place.frame for place in drafted.places if place.reason == "person"]
    words = (
        accepted_words(frames),
        flipped_words(flipped_drafts(session)),
        undrafted_words(missing_frames(drafted)),
        another_person_words(others),
    )
    return with_accepted(session, frames), tuple(sentence for sentence in words if sentence)


def _sender(send: SendStep, stage: Stage, stop: Event | None) -> Callable[[float], None]:
    """What reports the share of a stage, once for each per cent, and leaves where it is to stop."""
    reported = -1

    def report(share: float) -> None:
        nonlocal reported
        if stop is not None and stop.is_set():
            raise Cancelled
        percent = int(100 * share)
        if percent > reported:
            reported = percent
            send(Step(percent, stage=stage))

    return report


# --- the record


def _set_aside(session_path: Path) -> str:
    """Set a session aside that is to be made anew, with its history; what is said of that."""
    session_path.with_name(RECORD).unlink(missing_ok=True)
    try:
        content = read_own(session_path, LARGEST_SESSION_BYTES)
    except OSError:
        return ""
    sign = f".theirs-{hashlib.sha256(content).hexdigest()[:8]}"
    aside = session_path.with_name(f"{session_path.stem}{sign}.json")
    journal = session_path.with_name(JOURNAL)
    if journal.is_file():
        journal.replace(journal.with_name(f"{journal.stem}{sign}{journal.suffix}"))
    session_path.replace(aside)
    return f"The session that was there is kept as {aside.name}."


def _begin_record(task: Task, film: FilmToDraft, people: Sequence[WhoIsDrafted]) -> _Record:
    who, *others = people
    words = () if who.found is None else (found_person_words(who.found),)
    return _Record(
        asked=_asked(task, film),
        frame=who.frame,
        box=who.box,
        others=tuple(each.box for each in others),
        notes=words,
    )


def _write_record(record: _Record, session_path: Path) -> None:
    content = record.model_dump_json(indent=2).encode()
    write_file(session_path.with_name(RECORD), content, overwrite=True, error=SessionError)


def _record_of(session_path: Path) -> _Record | None:
    """What was asked for; None where the session was not made here. SessionError for a damaged
    one."""
    path = session_path.with_name(RECORD)
    try:
        content = read_own(path, LARGEST_RECORD_BYTES)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise SessionError(f"{str(path)!r} cannot be read: {error.strerror or error}.") from None
    try:
        return _Record.model_validate_json(content)
    except ValidationError:
        raise SessionError(
            f"{str(path)!r} is damaged: remove it to track the session as it stands, or begin anew "
            "with `keypose run` and --overwrite."
        ) from None


def _write_picture(who: WhoIsDrafted, video: Video, path: Path) -> None:
    """The frame with the box, small."""
    try:
        picture = video.frame(who.frame).copy()
    except MissingFrame:
        return
    left, top, right, bottom = (round(edge) for edge in who.box)
    thick = max(2, picture.shape[1] // 300)
    cv2.rectangle(picture, (left, top), (right, bottom), BOX_RGB, thick)
    share = min(1.0, PICTURE_PX / max(picture.shape[:2]))
    small = cv2.resize(picture, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    write_file(path, jpeg(np.asarray(small, np.uint8)), overwrite=True, error=SessionError)
