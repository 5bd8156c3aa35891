"""Edit the other films of the motion: when one was taken, and whether it is there."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from pydantic import Field, FiniteFloat

from keypose.app.editor.documents import ActionRefused, film_of
from keypose.app.editor.message import Edit
from keypose.app.editor.state import EditorState
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import SceneId
from keypose.tracker.session.views import Clock, View

DECIMALS = 4
"""Of the frame at which a film begins."""
Moment: TypeAlias = Annotated[FiniteFloat, Field(ge=-1e8, le=1e8)]


class _OfFilm(Edit):
    """A view after the first, by its id."""

    view: SceneId

    def label(self, state: EditorState) -> str:
        return f"{self.verb} {_name(film_of(state.doc, self.view))}"


class MoveFilmClock(_OfFilm):
    """When a film was taken. begins: the frame of the first film, with its fraction, at which it
    begins; where it was likely, the frame that it replaces stays a choice."""

    do: Literal["film_clock"] = "film_clock"
    verb = "move the clock of"
    begins: Moment

    def apply(self, state: EditorState) -> Session:
        doc, view = state.doc, film_of(state.doc, self.view)
        before, begins = view.film_clock, round(self.begins, DECIMALS)
        if begins == before.begins:
            return doc
        require_overlap(doc, view, FilmClock(begins, before.rate))
        clock = Clock(begins=begins, rate=before.rate, also=choices_beside(view, begins))
        moved = view.model_copy(update={"clock": clock})
        return _with_films(doc, (moved if each is view else each for each in doc.views[1:]))


class RemoveFilm(_OfFilm):
    """A film is not in the session any more; its file stays."""

    do: Literal["remove_film"] = "remove_film"
    verb = "remove"

    def apply(self, state: EditorState) -> Session:
        view = film_of(state.doc, self.view)
        return _with_films(state.doc, (each for each in state.doc.views[1:] if each is not view))


MESSAGES = (MoveFilmClock, RemoveFilm)


def _with_films(doc: Session, films: Iterable[View]) -> Session:
    return doc.model_copy(update={"views": (doc.view, *films)})


def choices_beside(view: View, begins: float) -> tuple[float, ...]:
    """Where a film may begin as well, once it begins at a frame of the first film: where it began
    before stays a choice in the place of one that is taken."""
    also = () if view.clock is None else view.clock.also
    return tuple(view.film_clock.begins if each == begins else each for each in also)


def require_overlap(doc: Session, view: View, clock: FilmClock) -> None:
    """Refused where a film would show nothing of the first film's time."""
    count, first_count = view.video.frame_count, doc.view.video.frame_count
    if not clock.overlap(count, first_count):
        earliest = -(count - 1) / clock.rate
        raise ActionRefused(
            f"{_name(view)} would show nothing of the first film's time: let it begin between "
            f"{earliest:.0f} and {first_count - 1}."
        )


def _name(view: View) -> str:
    return Path(view.video.path).name
