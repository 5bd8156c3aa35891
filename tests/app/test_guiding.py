"""The guide ticks a step off when it is done, in whatever way, and not before."""

from __future__ import annotations

from typing import Any

import pytest

from app.editor.actions import ACTIONS
from app.guiding import guide_after
from app.outlook import Guide
from tracker.body import preset

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


def test_the_guide_begins_again_with_nothing_done() -> None:
    again = {"do": "begin_guide"}
    assert after(pull("root"), {"do": "add_key", "frame": 0}, again) == set()
    ends = ["left_hand", "right_hand", "left_foot", "right_foot"]
    assert after(*map(pull, ends[:3]), again, pull(ends[3])) == set()
    assert after(again, pull("root")) == {"hips"}
