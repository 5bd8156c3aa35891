"""Undo and redo as a list: one goes to any step at once, as if step by step."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from keypose.app.editor.actions import ACTIONS
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.state import EditorState
from keypose.app.state.app_state import AppState
from keypose.app.store.sections.work_values import MOST_LISTED, history
from tests.app.editor.desk import after, desk


def edited(count: int) -> EditorState:
    """A note a step, each at a time of its own."""
    state = desk()
    for k in range(count):
        now = after(state, {"do": "set_note", "frame": k % 60, "text": f"step {k}"})
        state = now.stamped(state, 1000.0 + k)
    return state


def go_to(state: EditorState, done: int) -> EditorState:
    return after(state, {"do": "go_to_step", "done": done, "of": state.history.total})


def test_going_to_a_step_is_undoing_one_after_another() -> None:
    state = edited(6)
    there = go_to(state, 2)
    step_by_step = after(state, *[{"do": "undo"}] * 4)
    assert there.doc is step_by_step.doc
    assert there.frame == step_by_step.frame
    assert [s.label for s in there.history.future] == [s.label for s in step_by_step.history.future]
    assert go_to(there, 6).doc is state.doc


def test_going_to_where_one_is_changes_nothing() -> None:
    state = edited(3)
    assert go_to(state, 3) is state


def test_a_step_of_a_history_that_has_changed_is_refused() -> None:
    state = edited(3)
    with pytest.raises(ActionRefused, match="history has changed"):
        after(state, {"do": "go_to_step", "done": 1, "of": 5})
    with pytest.raises(ActionRefused, match="history has changed"):
        after(state, {"do": "go_to_step", "done": 4, "of": 3})
    with pytest.raises(ValidationError):
        ACTIONS.validate_python({"do": "go_to_step", "done": -1, "of": 3})


def test_a_step_keeps_the_time_it_was_made_at_through_undo_and_redo() -> None:
    state = edited(4)
    undone = after(state, {"do": "undo"}).stamped(state, 5000.0)
    redone = after(undone, {"do": "redo"}).stamped(undone, 6000.0)
    assert [step.made_s for step in redone.history.past] == [1000.0, 1001.0, 1002.0, 1003.0]
    back = go_to(redone, 0).stamped(redone, 7000.0)
    assert [step.made_s for step in go_to(back, 4).stamped(back, 8000.0).history.past] == [
        1000.0, 1001.0, 1002.0, 1003.0,
    ]  # fmt: skip


def test_a_step_without_a_time_gets_none_by_being_done_again() -> None:
    state = after(desk(), {"do": "set_note", "frame": 1, "text": "a"})
    undone = after(state, {"do": "undo"})
    redone = after(undone, {"do": "redo"}).stamped(undone, 6000.0)
    assert redone.history.past[-1].made_s is None


def test_the_page_receives_the_steps_around_the_present_one() -> None:
    reported = history(AppState(edit=go_to(edited(5), 3)))
    assert (reported["done"], reported["total"], reported["first"]) == (3, 5, 0)
    assert [step["made"] for step in reported["steps"]] == [1000.0, 1001.0, 1002.0, 1003.0, 1004.0]
    assert reported["steps"][1] == {"label": "write the note at 1", "frame": 0, "made": 1001.0}
    assert history(AppState()) is None


def test_a_long_history_is_reported_in_part() -> None:
    many = MOST_LISTED + 30
    reported = history(AppState(edit=edited(many)))
    assert (reported["first"], len(reported["steps"]), reported["total"]) == (30, MOST_LISTED, many)
