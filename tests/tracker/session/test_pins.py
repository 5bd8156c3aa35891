"""Pins in a session: what may be pinned, and what is refused in one sentence."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError

from keypose.tracker.errors import one_sentence
from keypose.tracker.session import Session
from keypose.tracker.session.pins import Pin
from tests.tracker import session_cases as cases

TIP = {"part": "left_hand", "landmarks": ["tip"], "first_frame": 1, "last_frame": 5}


def opened(*pins: dict[str, Any]) -> Session:
    """A session with these pins, read as from its file."""
    return Session.begin(**{**cases.flat(cases.session()), "pins": list(pins)})


def refusal(*pins: dict[str, Any]) -> str:
    with pytest.raises(ValidationError) as refused:
        opened(*pins)
    return one_sentence(refused.value)


def test_pins_of_joints_landmarks_and_points_are_kept_as_they_were_written() -> None:
    pins = (
        TIP,
        {"part": "trunk", "first_frame": 0, "last_frame": 8, "floor": True},
        {"part": "left_arm", "point_m": [0.1, 0.2, 0.0], "first_frame": 3, "last_frame": 3},
    )
    again = Session.model_validate_json(opened(*pins).model_dump_json())
    assert again.subject.pins == opened(*pins).subject.pins
    points = [pin.points(again.subject.body) for pin in again.subject.pins]
    assert points == [((0.0, 0.18, 0.03),), ((0.0, 0.0, 0.0),), ((0.1, 0.2, 0.0),)]


def test_a_session_without_pins_does_not_name_them() -> None:
    reported = cases.session().model_dump_json()
    assert '"pins"' not in reported
    assert '"floor_m"' not in reported
    assert '"point_m"' not in opened(TIP).model_dump_json()


@pytest.mark.parametrize(
    ("pins", "words"),
    [
        ([{**TIP, "part": "tail"}], "'tail' is no part of the body; its parts are trunk"),
        ([{**TIP, "landmarks": ["nail"]}], "has no landmark 'nail'; it has thumb, tip"),
        ([{**TIP, "part": "trunk"}], "'trunk' has no landmark 'tip'; it has none"),
        ([{**TIP, "last_frame": 9}], "frame 9 is beyond the video, whose frames are 0 to 8"),
        ([{**TIP, "last_frame": 0}], "last_frame must not be before first_frame"),
        ([{**TIP, "point_m": [0, 0, 0]}], "name landmarks or give point_m, not both"),
        ([TIP, {**TIP, "first_frame": 5, "last_frame": 7}], "has two pins at frame 5; one is"),
        ([TIP, {"part": "left_hand", "first_frame": 4, "last_frame": 7}], "two pins at frame 4"),
        ([{**TIP, "first_frame": -1}], "first_frame"),
        ([TIP] * 10_001, "10001 are more than the 10000"),
    ],
    ids=["foreign part", "foreign landmark", "none there", "beyond", "backward", "both",
         "overlapping", "whole hand and tip", "negative", "too many"],
)  # fmt: skip
def test_what_cannot_be_pinned_is_refused_in_one_sentence(
    pins: list[dict[str, Any]], words: str
) -> None:
    message = refusal(*pins)
    assert any(word in message for word in words.split("|"))
    assert "\n" not in message


def test_heel_and_toe_may_be_held_over_different_ranges() -> None:
    thumb = {**TIP, "landmarks": ["thumb"], "first_frame": 3, "last_frame": 8}
    after = {**TIP, "first_frame": 6, "last_frame": 8}
    assert len(opened(TIP, thumb, after).subject.pins) == 3


@pytest.mark.parametrize(
    ("other", "overlaps"),
    [
        (Pin(part="left_hand", landmarks=("tip",), first_frame=5, last_frame=9), True),
        (Pin(part="left_hand", landmarks=("tip",), first_frame=6, last_frame=9), False),
        (Pin(part="left_hand", landmarks=("thumb",), first_frame=1, last_frame=5), False),
        (Pin(part="left_hand", first_frame=1, last_frame=5), True),
        (Pin(part="left_arm", first_frame=1, last_frame=5), False),
    ],
)
def test_pins_overlap_where_they_hold_the_same_at_one_frame(other: Pin, overlaps: bool) -> None:
    tip = Pin.model_validate(TIP)
    assert tip.overlaps(other) is overlaps
    assert other.overlaps(tip) is overlaps
