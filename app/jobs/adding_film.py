"""Add another film of the motion to the open session."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self

from keypose.app.jobs.fit import Fit, filmed_by, sent
from keypose.app.jobs.found_film import FoundFilm
from keypose.app.jobs.job import Context
from keypose.app.jobs.progress import seconds_left
from keypose.app.orders.film import BesideOrder
from keypose.app.words.films import film_words, lens_words, mended_words, opposite_words, whom_words
from keypose.tracker.errors import KeypointError
from keypose.tracker.session import Session
from keypose.tracker.storage.atomic import make_folder

if TYPE_CHECKING:
    from keypose.app.document.open import OpenSession
    from keypose.app.editor.actions import FilmToAdd
    from keypose.app.editor.state import EditorState
    from keypose.app.state.app_state import AppState

LABEL: Final = "add a film"
POSED: Final = ("keyframes", "part_keyframes", "drafts")
"""What is posed, which another lens moves and all films mend."""
TAKEN: Final = (*POSED, "camera", "lens_source")
"""Of the first view and the body, what may be another once the film is there."""
FOUND_FROM: Final = 0.2
FOUND_TO: Final = 0.9
"""The shares of the work between which the person is looked for in the film."""


@dataclass(frozen=True)
class AddFilm(Fit):
    """film: its path."""

    film: str

    asked = ("add_film",)
    kind = "film"
    title = "Adding a film"
    needs_loops = False  # before the last tenth of it
    fault = "Adding the film failed with an internal error ({}). Nothing was changed."
    died = "Adding the film stopped unexpectedly; everything is as it was, add it again."
    why_cancelled = "Adding the film was cancelled because a pose, a film or the camera changed."
    not_of_surfaces = "A session about surfaces takes no film beside them."

    @classmethod
    def of(cls, opened: OpenSession, edit: EditorState, action: FilmToAdd) -> Self:
        return cls(*sent(opened, edit.doc, drafts=edit.doc.subject.drafts), str(action.path))

    def work(self, session: Session, context: Context) -> FoundFilm:
        from keypose.app.jobs.add_film import WhoIsMeant, found_film  # loads what only this needs

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
        lens = lens_words(session.view, added.session.view)
        opposite = opposite_words(added.session, added.view)
        parts = film_words(added.view), opposite, lens, mended_words(added.mended)
        words = " ".join(filter(None, parts))
        return added.film._replace(words=words)

    def inputs(self, doc: Session) -> tuple[Any, ...]:
        posed = (doc.value(name) for name in POSED)
        return doc.subject.body, *filmed_by(doc), *posed, doc.view.keypoints, *doc.views[1:]

    def apply(self, result: FoundFilm, state: AppState) -> tuple[AppState, str]:
        assert state.opened is not None
        path, doc = Path(state.opened.session_path), state.editing.doc
        make_folder(path.parent, error=KeypointError)  # a new film's is there from its first edit
        with_film = result.saved(path)
        after = doc.changed({name: with_film.value(name) for name in TAKEN})
        films = with_film.views[1:]
        after = after.model_copy(update={"views": (after.view, *films)})
        return replace(state, edit=state.editing.with_step(after, LABEL)), result.words


def _words_at(share: float) -> str:
    if share < FOUND_FROM:
        return "Looking at the first film"
    if share < FOUND_TO:
        percent = 100 * (share - FOUND_FROM) / (FOUND_TO - FOUND_FROM)
        return f"Looking for the person: {percent:.0f} %"
    return "Finding when it was taken, and where its camera stands"
