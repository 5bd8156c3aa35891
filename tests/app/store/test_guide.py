"""The guide ticks a step off when it is done, in whatever way, and not before."""

from __future__ import annotations

from typing import Any

import pytest

from keypose.app.editor.actions import ACTIONS
from keypose.app.state.app_state import Guide
from keypose.app.store.guide import guide_after
from keypose.tracker.body.body import preset

BODY = preset("adult_male")


def after(*messages: dict[str, Any]) -> frozenset[str]:
    guide = Guide(first=True)
    for message in messages:
        guide = guide_after(guide, ACTIONS.validate_python(message), BODY)  # type: ignore[arg-type]
    return guide.done


def pull(name: str, **more: Any) -> dict[str, Any]:
    handle = {"kind": "root"} if name == "root" else {"kind": "end", "name": name}
    return {"do": "drag", "view": "main", "handle": handle, "from": [1, 1], "at": [9, 9], **more}


def turn(part: str) -> dict[str, Any]:
    ring = {"kind": "ring", "part": part, "axis": "y"}
    return {"do": "drag", "view": "main", "handle": ring, "from": [1, 1], "at": [9, 9]}


@pytest.mark.parametrize(
    ("message", "steps"),
    [
        (pull("root"), {"hips"}),
        (pull("root", depth=True), {"height"}),
        (pull("root", view="side"), {"height"}),
        (pull("left_hand", view="side"), {"depth"}),
        (pull("left_hand"), set()),
        ({"do": "height", "cm": 170}, set()),
        ({"do": "paste_pose"}, {"limbs"}),
        ({"do": "add_key", "frame": 0}, {"key"}),
        ({"do": "face", "way": "away"}, {"facing"}),
        ({"do": "angles", "part": "waist", "y": 90}, {"facing"}),
        ({"do": "angles", "part": "head", "y": 20}, set()),
        (turn("waist"), {"facing"}),
        (turn("head"), set()),
        ({"do": "go", "frame": 3}, set()),
    ],
    ids=str,
)
def test_an_action_does_its_own_step(message: dict[str, Any], steps: set[str]) -> None:
    assert after(message) == steps


def test_limbs_are_done_when_both_hands_and_both_feet_were_pulled() -> None:
    ends = ["left_hand", "right_hand", "left_foot", "right_foot"]
    assert after(*(pull(name) for name in ends[:3]), pull("left_hand")) == set()
    assert after(*map(pull, ends)) == {"limbs"}


END, CANCEL = ({"do": what, "stroke": "s"} for what in ("end_stroke", "cancel_stroke"))


def test_a_step_is_done_when_its_drag_ends_and_not_under_the_hand() -> None:
    moves = [pull("root", stroke="s"), pull("root", stroke="s", at=[20, 9])]
    assert after(*moves) == set()
    assert after(*moves, {"do": "select", "part": None}) == set()
    assert after(*moves, {"do": "end_stroke", "stroke": "other"}) == set()
    assert after(*moves, END) == {"hips"}
    assert after(*moves, {"do": "go", "frame": 3}) == {"hips"}
    assert after(*moves, {"do": "add_key", "frame": 0}) == {"hips", "key"}
    assert after(*moves, turn("waist") | {"stroke": "t"}) == {"hips"}


def test_a_drag_that_is_taken_back_or_comes_back_does_no_step() -> None:
    moved = pull("root", stroke="s")
    assert after(moved, CANCEL) == set()
    assert after(moved, CANCEL, {"do": "go", "frame": 3}) == set()
    assert after({"do": "add_key", "frame": 0}, moved, CANCEL) == {"key"}
    assert after(moved, pull("root", stroke="s", at=[1, 1]), END) == set()
    ends = ["left_hand", "right_hand", "left_foot", "right_foot"]
    pulls = [pull(name, stroke=name) for name in ends]
    assert after(*pulls, {"do": "cancel_stroke", "stroke": ends[3]}) == set()
    assert after(*pulls, {"do": "end_stroke", "stroke": ends[3]}) == {"limbs"}


def test_what_a_drag_does_depends_on_how_it_ends() -> None:
    held = pull("root", stroke="s", depth=True)
    assert after(held, pull("root", stroke="s"), END) == {"hips"}
    assert after(pull("root", stroke="s"), held, END) == {"height"}


def test_the_guide_begins_again_with_nothing_done() -> None:
    again = {"do": "begin_guide"}
    assert after(pull("root"), {"do": "add_key", "frame": 0}, again) == set()
    ends = ["left_hand", "right_hand", "left_foot", "right_foot"]
    assert after(*map(pull, ends[:3]), again, pull(ends[3])) == set()
    assert after(again, pull("root")) == {"hips"}
