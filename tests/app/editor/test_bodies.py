"""Several bodies in one film: each with its own keyframes, one of them posed at a time."""

from __future__ import annotations

from typing import Any

import pytest

from keypose.app.editor.frames import BESIDE_M
from keypose.app.editor.state import EditorState
from keypose.tracker.errors import KeyposeError, SessionError
from keypose.tracker.session.schema import MOST_BODIES
from tests.app.editor.desk import after, desk

BOX = {"do": "add_body", "preset": "box"}
POSE_FIRST = {"do": "pose_body", "body": "body"}
POSE_SECOND = {"do": "pose_body", "body": "box"}


def ids(state: EditorState) -> list[str]:
    return [body.id for body in state.doc.bodies]


def test_a_body_that_is_added_is_posed_next_and_has_no_keyframes_yet() -> None:
    state = after(desk(), BOX)
    assert (ids(state), state.doc.subject.id) == (["body", "box"], "box")
    assert (state.keys, state.skeleton.body.name) == ((), "box")
    assert state.selected is None
    assert after(state, {"do": "undo"}).doc == desk().doc


@pytest.mark.parametrize("across", [0.4, -0.4])
def test_it_first_stands_beside_one_that_is_posed_as_far_away(across: float) -> None:
    state = desk()
    moved = [
        k.model_copy(update={"root_m": (across, 0.1, 4.0)}) for k in state.doc.subject.keyframes
    ]
    state = after(state.with_doc(state.doc.changed({"keyframes": tuple(moved)})), BOX)
    x, y, z = state.opening.p_camera_root
    assert (y, z) == (0.1, 4.0)
    assert abs(x - across) == pytest.approx(BESIDE_M)
    assert abs(x) < BESIDE_M


def test_another_body_is_posed_without_a_step_and_nothing_is_lost() -> None:
    state = after(desk(), BOX, {"do": "add_key", "frame": 0}, POSE_FIRST)
    assert (state.keys, len(state.history.past)) == (desk().keys, 2)
    assert state.skeleton.body.names == desk().skeleton.body.names
    assert after(state, POSE_SECOND).keys == (0,)


def test_undo_goes_to_the_body_whose_edit_it_undoes() -> None:
    state = after(desk(), BOX, {"do": "add_key", "frame": 0}, POSE_FIRST, {"do": "undo"})
    assert (state.doc.subject.id, state.keys) == ("box", ())
    assert after(state, {"do": "redo"}).keys == desk().keys


def test_a_body_that_is_removed_leaves_another_to_pose_and_undo_brings_it_back() -> None:
    state = after(desk(), BOX)
    without = after(state, {"do": "remove_body", "body": "box"})
    assert (ids(without), without.keys) == (["body"], desk().keys)
    assert after(without, {"do": "undo"}).doc == state.doc
    without = after(state, {"do": "remove_body", "body": "body"})
    assert (ids(without), without.doc.subject.body.name) == (["box"], "box")


def test_a_body_is_called_as_a_person_calls_it() -> None:
    state = after(desk(), BOX, {"do": "call_body", "body": "body", "name": " Anna "})
    assert [body.called for body in state.doc.bodies] == ["Anna", ""]


REFUSED = {
    "another": (POSE_SECOND, "not in the session any more"),
    "unknown": ({"do": "add_body", "preset": "unicorn"}, "no body of that name"),
    "the last": ({"do": "remove_body", "body": "body"}, "add another before you remove"),
    "gone": ({"do": "remove_body", "body": "box"}, "not in the session any more"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_is_refused_in_one_sentence(name: str) -> None:
    message, words = REFUSED[name]
    with pytest.raises(KeyposeError, match=words):
        after(desk(), message)


def test_more_bodies_than_a_session_holds_are_refused() -> None:
    messages: list[dict[str, Any]] = [BOX] * (MOST_BODIES - 1)
    with pytest.raises(SessionError, match="the most that it can"):
        after(desk(), *messages, BOX)
