"""The other films of the motion: when each was taken, and that it is there, are edits like all."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.state import EditorState
from keypose.tracker.session.views import Clock
from keypose.tracker.storage.fingerprints import segment_keys
from tests.app.editor.desk import after, desk
from tests.app.film_beside_cases import ID, with_film


def two_films() -> EditorState:
    return replace(desk(), doc=with_film(desk().doc))


def clock_of(state: EditorState) -> Clock:
    clock = state.doc.views[1].clock
    assert clock is not None
    return clock


def moved(begins: float, **more: Any) -> dict[str, Any]:
    return {"do": "film_clock", "view": ID, "begins": begins, **more}


def test_a_clock_that_somebody_moved_has_no_sigma_and_undo_brings_back_what_was_found() -> None:
    before = two_films()
    state = after(before, moved(4.4))
    assert (clock_of(state).begins, clock_of(state).sigma) == (4.4, None)
    assert state.history.past[-1].label == "move the clock of person.mp4"
    assert clock_of(after(state, {"do": "undo"})) == clock_of(before)


def test_a_drag_of_the_clock_is_one_step() -> None:
    strokes = [moved(begins, stroke="a") for begins in (3.9, 4.2, 5.0)]
    state = after(two_films(), *strokes, {"do": "end_stroke", "stroke": "a"})
    assert clock_of(state).begins == 5.0
    assert len(state.history.past) == 1


def test_of_two_likely_clocks_the_one_that_was_left_stays_a_choice() -> None:
    state = after(two_films(), moved(31.5))
    assert (clock_of(state).begins, clock_of(state).also) == (31.5, (3.4,))
    assert clock_of(after(state, moved(3.4))).also == (31.5,)


def test_a_removed_film_is_there_again_after_undo() -> None:
    before = two_films()
    state = after(before, {"do": "remove_film", "view": ID})
    assert state.doc.views == before.doc.views[:1]
    assert after(state, {"do": "undo"}).doc.views == before.doc.views


@pytest.mark.parametrize("edit", [moved(4.0), {"do": "remove_film", "view": ID}])
def test_what_was_tracked_with_a_film_is_outdated_by_its_clock_and_without_it(
    edit: dict[str, Any],
) -> None:
    before = two_films()
    settings = before.doc.settings.model_copy(update={"cues": ("keypoints",)})
    before = replace(before, doc=before.doc.changed({"settings": settings}))
    keys = [segment_keys(state.doc) for state in (before, after(before, edit))]
    assert not set(keys[0].values()) & set(keys[1].values())


REFUSED = {
    "no common time": (moved(1000.0), "nothing of the first film's time: let it begin between"),
    "before all": (moved(-1000.0), "nothing of the first film's time: let it begin between"),
    "another film": (moved(4.0) | {"view": "film-9"}, "not in the session any more"),
    "the first film": ({"do": "remove_film", "view": "view"}, "not in the session any more"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_is_refused_in_one_sentence(name: str) -> None:
    message, words = REFUSED[name]
    with pytest.raises(ActionRefused, match=words):
        after(two_films(), message)
