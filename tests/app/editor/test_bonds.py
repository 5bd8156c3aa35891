"""What a body holds: set where both are posed, over the frames at which they stay together."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from keypose.app.editor.bonds import apart_m
from keypose.app.editor.shown import part_at
from keypose.app.editor.state import EditorState
from keypose.tracker.errors import KeyposeError
from keypose.tracker.session.bonds import Bond
from tests.app.editor.desk import after, desk

PARTS = (("box", "box"), ("body", "left_hand"))
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


def put(state: EditorState, preset: str, place: Any) -> EditorState:
    """A thing posed at a place of the camera frame."""
    x, y, z = np.asarray(place).tolist()
    added = after(state, {"do": "add_body", "preset": preset})
    return after(added, {"do": "root", "x": x, "y": y, "z": z}, {"do": "add_key", "frame": 0})


def test_what_is_over_a_thing_in_the_picture_goes_before_what_is_nearer_in_space() -> None:
    hand = part_at(desk(), "left_hand", 0)[:3, 3]
    nearer = hand * (1 - 0.4 / np.linalg.norm(hand))
    beside = put(desk(), "box", nearer - [0.4, 0.0, 0.0])
    state = put(beside, "stick", nearer - [0.0, -0.55, 0.0])
    box, on_hand = (part_at(state.about(body), part, 0)[:3, 3] for body, part in PARTS)
    assert np.linalg.norm(box - nearer) < np.linalg.norm(on_hand - nearer) + 0.01
    bond = bond_of(after(state, {**HOLD, "part": "stick"}))
    assert (bond.holder.body, bond.holder.part) == ("body", "left_hand")


def test_what_is_far_behind_a_thing_in_the_picture_does_not_go_before_what_it_touches() -> None:
    hand = part_at(desk(), "left_hand", 0)[:3, 3]
    nearer = hand * (1 - 1.5 / np.linalg.norm(hand))
    beside = put(desk(), "box", nearer - [0.2, 0.0, 0.0])
    state = put(beside, "stick", nearer - [0.0, -0.55, 0.0])
    bond = bond_of(after(state, {**HOLD, "part": "stick"}))
    assert {end.body for end in bond.ends} == {"box", "stick"}


def hand_moved(state: EditorState, **about: Any) -> EditorState:
    """The forearm turned at frame 0, where both are posed."""
    bonded = after(state, HOLD, {"do": "change_bond", "index": 0, **about})
    return after(bonded, {"do": "angles", "part": "right_forearm", "x": -40.0})


def test_a_thing_goes_along_with_the_hand_that_holds_it_in_the_same_step() -> None:
    before = after(with_box(), HOLD)
    state = hand_moved(with_box())
    assert apart_m(state, bond_of(state), 0) == pytest.approx(apart_m(before, bond_of(before), 0))
    in_hand = [
        np.linalg.inv(part_at(each, "right_hand", 0)) @ part_at(each.about("box"), "box", 0)
        for each in (before, state)
    ]
    np.testing.assert_allclose(in_hand[1], in_hand[0], atol=1e-4)
    assert state.doc.subject.id == "body"
    undone = after(state, {"do": "undo"})
    assert undone.doc.bodies == before.doc.bodies


STAYS = {
    "as it is not to move": {"moves": "holder"},
    "before it is held": {"first": 3},
}


@pytest.mark.parametrize("why", STAYS)
def test_a_thing_stays(why: str) -> None:
    state = hand_moved(with_box(), **STAYS[why])
    assert state.about("box").doc.subject == with_box().about("box").doc.subject


def test_a_hand_reaches_after_the_thing_that_it_holds_where_it_is_to_move() -> None:
    state = after(with_box(), HOLD, {"do": "change_bond", "index": 0, "moves": "holder"})
    apart = apart_m(state, bond_of(state), 0)
    y = float(part_at(state.about("box"), "box", 0)[1, 3])
    moved = after(state, {"do": "pose_body", "body": "box"}, {"do": "root", "y": y - 0.04})
    assert part_at(moved, "box", 0)[1, 3] == pytest.approx(y - 0.04, abs=1e-4)
    assert apart_m(moved, bond_of(moved), 0) == pytest.approx(apart, abs=2e-3)
    shoulder = [part_at(each.about("body"), "right_upper_arm", 0)[:3, 3] for each in (state, moved)]
    np.testing.assert_allclose(*shoulder, atol=1e-9)


def test_two_hands_stay_on_a_thing_that_one_of_them_carries_away() -> None:
    state = with_box()
    hands = [part_at(state, hand, 0)[:3, 3] for hand in ("left_hand", "right_hand")]
    x, y, z = np.mean(hands, axis=0).tolist()
    between = [{"do": "pose_body", "body": "box"}, {"do": "root", "x": x, "y": y, "z": z}]
    state = after(state, *between, GO_BACK, HOLD, {**HOLD, "part": "left_hand", "body": "box"})
    second = state.doc.bonds[1]
    apart = apart_m(state, second, 0)
    moved = after(state, {"do": "angles", "part": "right_forearm", "x": -30.0})
    assert apart_m(moved, second, 0) == pytest.approx(apart, abs=1e-4)


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
