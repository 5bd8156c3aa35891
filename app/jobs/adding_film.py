"""Add another film of the motion to the open session, or find its camera anew."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self

from keypose.app.editor.documents import film_of
from keypose.app.editor.films import require_overlap
from keypose.app.jobs.fit import Fit, filmed_by, sent
from keypose.app.jobs.found_film import FoundFilm
from keypose.app.jobs.job import Context
from keypose.app.jobs.progress import seconds_left
from keypose.app.orders.film import BesideOrder
from keypose.app.words.films import (
    whom_words,
)
from keypose.tracker.errors import KeypointError
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.session import Session
from keypose.tracker.session.views import View
from keypose.tracker.storage.atomic import make_folder

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor.actions import FilmToAdd
    from keypose.app.editor.actions import PlaceFilm as Asked
    from keypose.app.editor.state import EditorState
    from keypose.app.jobs.with_film import AddedFilm
    from keypose.app.state.app_state import AppState

LABEL: Final = "add a film"
PLACED: Final = "find the film's camera"
POSED: Final = ("keyframes", "part_keyframes", "drafts")
"""What is posed, which another lens moves and all films mend."""
TAKEN: Final = (*POSED, "camera", "lens_source", "floor_m")
"""Of the first view, the body and the world, what may be another once the film is there."""
FOUND_FROM: Final = 0.2
FOUND_TO: Final = 0.9
"""The shares of the work between which the person is looked for in the film."""


class _OfFilms(Fit):
    """A second film synchronised with the first: its clock, its camera, and keyframes mended."""

    kind = "film"
    needs_loops = False  # before the last tenth of it
    not_of_surfaces = "A session about surfaces takes no film beside them."

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        posed = (doc.value(name) for name in POSED)
        return doc.subject.body, *filmed_by(doc), *posed, doc.view.keypoints, *doc.views[1:]


@dataclass(frozen=True)
class AddFilm(_OfFilms):
    """film: its path."""

    film: str

    asked = ("add_film",)
    title = "Adding a film"
    fault = "Adding the film failed with an internal error ({}). Nothing was changed."
    died = "Adding the film stopped unexpectedly; everything is as it was, add it again."
    why_cancelled = "Adding the film was cancelled because a pose, a film or the camera changed."

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, action: FilmToAdd) -> Self:
        return cls(*sent(opened, edit.doc, drafts=edit.doc.subject.drafts), str(action.path))

    def work(self, session: Session, context: Context) -> FoundFilm:
        from keypose.app.jobs.add_film import found_film  # loads what only this needs
        from keypose.app.jobs.seen_in_films import WhoIsMeant

        began, path = time.monotonic(), Path(self.film)

        def report(share: float) -> None:
            left = seconds_left(time.monotonic() - began, share)
            context.report(share, _words_at(share), seconds_left=left)

        report(0.0)
        session_path = Path(self.folder) / "session.json"
        try:
            added = found_film(
                session, session_path, path, BesideOrder(), report, context.cancelled
            )
        except WhoIsMeant as error:
            raise KeypointError(whom_words(error.people, path.name)) from None
        return _with_words(session, added)

    def apply(self, result: FoundFilm, state: AppState) -> tuple[AppState, str]:
        assert state.opened is not None
        path = Path(state.opened.session_path)
        make_folder(path.parent, error=KeypointError)  # a new film's is there from its first edit
        with_film = result.saved(path)
        return _taken(state, with_film, with_film.views[1:], LABEL), result.words


@dataclass(frozen=True)
class PlaceFilm(_OfFilms):
    """view: of the film, by its id.  begins: the frame of the first film at which it does."""

    view: str
    begins: float

    asked = ("place_film",)
    title = "Finding the film's camera"
    fault = "Finding the film's camera failed with an internal error ({}). Nothing was changed."
    died = "Finding the film's camera stopped unexpectedly; everything is as it was, find it again."
    why_cancelled = "Cancelled because a pose, a film or the camera changed."

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, action: Asked) -> Self:
        view = film_of(edit.doc, action.view)
        require_overlap(edit.doc, view, FilmClock(action.begins, view.film_clock.rate))
        work_inputs = sent(opened, edit.doc, drafts=edit.doc.subject.drafts)
        return cls(*work_inputs, view.id, action.begins)

    def work(self, session: Session, context: Context) -> FoundFilm:
        from keypose.app.jobs.add_film import placed_again  # loads what only this needs

        def report(share: float) -> None:
            context.report(share, _words_at(FOUND_TO))

        report(0.0)
        session_path = Path(self.folder) / "session.json"
        return _with_words(
            session,
            placed_again(session, session_path, self.view, self.begins, report, context.cancelled),
        )

    def apply(self, result: FoundFilm, state: AppState) -> tuple[AppState, str]:
        film, films = result.session.views[-1], state.editing.doc.views[1:]
        placed = tuple(film if each.id == film.id else each for each in films)
        return _taken(state, result.session, placed, PLACED), result.words


def _with_words(session: Session, added: AddedFilm) -> FoundFilm:
    from keypose.app.jobs.with_film import added_words  # loads what only this needs

    return added.film._replace(words=" ".join(added_words(session, added)))


def _taken(state: AppState, with_film: Session, films: tuple[View, ...], label: str) -> AppState:
    """The state with these views after the first, as one step, and with what is posed and seen
    otherwise by them."""
    doc = state.editing.doc.changed({name: with_film.value(name) for name in TAKEN})
    doc = doc.model_copy(update={"views": (doc.view, *films)})
    return replace(state, edit=state.editing.with_step(doc, label))


def _words_at(share: float) -> str:
    if share < FOUND_FROM:
        return "Looking at the first film"
    if share < FOUND_TO:
        percent = 100 * (share - FOUND_FROM) / (FOUND_TO - FOUND_FROM)
        return f"Looking for the person: {percent:.0f} %"
    return "Finding when it was taken, and where its camera stands"
