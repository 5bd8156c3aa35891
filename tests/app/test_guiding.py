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
        ({"do": "toggle_key"}, {"key"}),
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
