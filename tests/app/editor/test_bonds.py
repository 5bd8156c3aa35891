"""What a body holds: set where both are posed, over the frames at which they stay together."""

from __future__ import annotations

from typing import Any

import pytest

from keypose.app.editor.bonds import apart_m
from keypose.app.editor.shown import part_at
from keypose.app.editor.state import EditorState
from keypose.tracker.errors import KeyposeError
from keypose.tracker.session.bonds import Bond
from tests.app.editor.desk import after, desk

HOLD = {"do": "set_bond", "part": "right_hand", "frame": 0}
GO_BACK = {"do": "pose_body", "body": "body"}


def with_box(*, at_hand: bool = True) -> EditorState:
    """A box at the right hand of the person at frames 0 and 24, posed and no more."""
    state = after(desk(), {"do": "add_body", "preset": "box"})
    for frame in (0, 24):
        person = state.about("body")
        x, y, z = part_at(person, "right_hand", frame)[:3, 3].tolist()
        messages: list[dict[str, Any]] = [
            {"do": "go", "frame": frame},
            {"do": "root", "x": x if at_hand else x + 2.0, "y": y, "z": z},
            {"do": "add_key", "frame": frame},
        ]
        state = after(state, *messages)
    return after(state, GO_BACK, {"do": "go", "frame": 0})


def bond_of(state: EditorState) -> Bond:
    (bond,) = state.doc.bonds
    return bond


def test_the_nearest_part_of_another_body_is_held_as_long_as_it_stays_near() -> None:
    state = after(with_box(), HOLD)
    bond = bond_of(state)
    assert (bond.holder.part, bond.held.body, bond.moves) == ("right_hand", "box", "held")
    assert bond.first_frame == 0
    assert 5 < bond.last_frame <= 24
    assert apart_m(state, bond, 0) < 1e-3
    assert state.history.past[-1].label == "hold right hand"
    assert after(state, {"do": "undo"}).doc.bonds == ()


def test_a_part_of_the_same_body_is_held_where_that_is_said() -> None:
    state = after(desk(), {**HOLD, "body": "body", "onto": "right_thigh"})
    bond = bond_of(state)
    assert bond.bodies == ("body", "body")
    assert bond.moves == "both"


def test_a_hold_is_longer_or_shorter_and_let_go() -> None:
    state = after(with_box(), HOLD, {"do": "change_bond", "index": 0, "first": 6, "last": 500})
    assert bond_of(state).span == (6, 72)
    state = after(state, {"do": "change_bond", "index": 0, "moves": "both"})
    assert bond_of(state).moves == "both"
    assert after(state, {"do": "delete_bond", "index": 0}).doc.bonds == ()


def test_a_body_that_is_removed_is_held_no_more() -> None:
    state = after(with_box(), HOLD, {"do": "remove_body", "body": "box"})
    assert state.doc.bonds == ()


REFUSED: dict[str, tuple[EditorState, dict[str, Any], str]] = {
    "alone": (desk(), HOLD, "no other body to hold: add one"),
    "far away": (with_box(at_hand=False), HOLD, "m apart at frame 0: pose them together"),
    "itself": (desk(), {**HOLD, "body": "body", "onto": "right_hand"}, "no other body"),
    "gone": (desk(), {"do": "delete_bond", "index": 0}, "not there any more"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_hold_that_cannot_be_is_refused_in_one_sentence(name: str) -> None:
    state, message, words = REFUSED[name]
    with pytest.raises(KeyposeError, match=words):
        after(state, message)
