"""The journal holds how the other films of a session were edited."""

from __future__ import annotations

from typing import Any

import pytest

from keypose.tracker.session import Session
from keypose.tracker.session.views import Clock
from keypose.tracker.storage.changes import apply_changes, changes
from tests.app.film_beside_cases import beside, with_film
from tests.tracker import session_cases as cases


def _another(doc: Session) -> Session:
    return doc.model_copy(
        update={"views": (*doc.views, beside(doc, Clock(begins=-2.0), id="film-3"))}
    )


def _turned_round(doc: Session) -> Session:
    first, *films = _another(doc).views
    return doc.model_copy(update={"views": (first, *reversed(films))})


def _moved(doc: Session) -> Session:
    film = doc.views[1].model_copy(update={"clock": Clock(begins=2.25)})
    return doc.model_copy(update={"views": (doc.view, film)})


JOURNALED = {
    "moved": _moved,
    "removed": lambda doc: doc.model_copy(update={"views": doc.views[:1]}),
    "added": _another,
    "in another order": _turned_round,
    "moved beside a keyframe that is deleted": lambda doc: _moved(
        doc.changed({"keyframes": doc.subject.keyframes[1:]})
    ),
}


@pytest.mark.parametrize("name", JOURNALED)
def test_what_the_journal_holds_of_an_edit_of_films_makes_it_again_both_ways(name: str) -> None:
    doc = with_film(cases.session())
    edited = JOURNALED[name](doc)
    assert edited != doc
    assert apply_changes(doc, changes(doc, edited)) == edited
    assert apply_changes(edited, changes(edited, doc)) == doc


@pytest.mark.parametrize("change", [[], {"set": []}, {"set": [], "ids": ["film-9"]}])
def test_a_journal_that_names_no_film_of_the_session_is_refused(change: Any) -> None:
    with pytest.raises(ValueError, match="film"):
        apply_changes(cases.session(), {"films": change})
