"""What the page may send, and how much work an answer is."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from keypose.app.posing import Gesture, angles_deg, at_limit, drag, handles, parts_at
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import BodyError
from tests.app.posing.posing_cases import PERSON, as_sent, gesture, points, sights, walking

MOST_CALLS = 5000
MOST_CALLS_OF_TRUNK = 8000
"""Of one move of the pointer; the trunk is found in a few steps of least squares."""
"""About two milliseconds of a usual computer. Calls are counted: a time would depend on it, and on
what else it does."""

SENT: dict[str, Any] = {
    "view": "main",
    "handle": {"kind": "ring", "part": "chest", "axis": "x"},
    "from": [1.5, 2],
    "at": [3, 4],
    "snap": False,
    "free": True,
    "axis": None,
    "depth": False,
}


@pytest.mark.parametrize(
    "handle",
    [
        {"kind": "ring", "part": "chest", "axis": "z"},
        {"kind": "root"},
        {"kind": "end", "name": "left_hand"},
        {"kind": "joint", "name": "left_elbow"},
        {"kind": "surface", "part": "chest"},
        {"kind": "surface", "part": "chest", "tool": "ends"},
        {"kind": "size", "part": "chest", "key": "length"},
        {"kind": "size", "part": "chest", "key": "joint", "side": "joint"},
    ],
    ids=lambda handle: handle["kind"],
)
def test_every_handle_of_the_page_is_understood(handle: dict[str, str]) -> None:
    sent = Gesture.model_validate({**SENT, "handle": handle})
    assert sent.handle.kind == handle["kind"]
    assert sent.from_ == (1.5, 2)
    drag(PERSON, walking(), sent, sights())


@pytest.mark.parametrize(
    "spoilt",
    [
        {"at": [math.nan, 0]},
        {"at": [1e7, 0]},
        {"from": [math.inf, 0]},
        {"from": [1]},
        {"view": "back"},
        {"axis": "w"},
        {"handle": {"kind": "ring", "part": "chest", "axis": "w"}},
        {"handle": {"kind": "thumb"}},
        {"handle": {"kind": "end"}},
        {"handle": {"kind": "size", "part": "chest", "key": ""}},
        {"snap": "perhaps"},
        {"colour": "red"},
    ],
    ids=str,
)
def test_what_is_out_of_range_is_refused_at_the_door(spoilt: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        Gesture.model_validate({**SENT, **spoilt})


def test_names_that_the_body_does_not_have_are_refused_in_a_sentence() -> None:
    for handle in (
        {"kind": "ring", "part": "wing", "axis": "x"},
        {"kind": "end", "name": "wing"},
        {"kind": "surface", "part": "wing"},
        {"kind": "size", "part": "wing", "key": "length"},
        {"kind": "size", "part": "chest", "key": "girth"},
    ):
        sent = Gesture.model_validate({**SENT, "handle": handle})
        with pytest.raises(BodyError, match=r"^.* has no .*\.$"):
            drag(PERSON, walking(), sent, sights())


def test_a_move_of_the_pointer_is_little_work() -> None:
    pose, views, skeleton = walking(), sights(), Skeleton.of(PERSON)
    p = points(PERSON, pose)
    calls: dict[str, Any] = {}
    most: dict[str, int] = {}
    for handle in handles(PERSON):
        start = views["main"].project(p[handle.anchor])
        sent = gesture("main", as_sent(handle), start, start + np.array([30, -20]))
        most[handle.name] = MOST_CALLS_OF_TRUNK if handle.kind == "corner" else MOST_CALLS
        calls[handle.name] = lambda sent=sent: drag(PERSON, pose, sent, views)
    for axis in "xyz":
        ring = {"kind": "ring", "part": "left_upper_arm", "axis": axis}
        sent = gesture("main", ring, (330, 180), (380, 150))
        calls[f"ring {axis}"] = lambda sent=sent: drag(PERSON, pose, sent, views)
    calls["pick"] = lambda: parts_at(skeleton, pose, views["main"], (330, 170))
    calls["angles"] = lambda: (angles_deg(skeleton, pose), at_limit(skeleton, pose))
    for name, call in calls.items():
        assert work(call) < most.get(name, MOST_CALLS), name


def work(act: Callable[[], object]) -> int:
    """How many functions are called meanwhile, those of C included."""
    events: list[str] = []
    sys.setprofile(lambda frame, event, argument: events.append(event))
    try:
        act()
    finally:
        sys.setprofile(None)
    return sum(event in ("call", "c_call") for event in events)
