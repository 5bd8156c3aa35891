"""Keypoints that a person set right, and what drafting found, as a session keeps them."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError

from keypose.tracker.session import Session
from keypose.tracker.session.annotations import Drafted, KeypointCorrection
from keypose.tracker.storage.files import session_json
from tests.tracker import session_cases as cases

WRIST: dict[str, Any] = {"frame": 2, "joint": "left_wrist", "uv": (20.0, 30.5)}


def with_corrections(*given: dict[str, Any]) -> Session:
    return Session.begin(**{**cases.flat(cases.session()), "keypoint_corrections": list(given)})


def test_a_session_without_any_is_written_as_before_there_were_any() -> None:
    written = session_json(cases.session())
    assert b"keypoint_corrections" not in written
    assert b"drafted" not in written


def test_they_are_read_back_as_they_were_written() -> None:
    hidden = {"frame": 3, "joint": "nose"}
    given = with_corrections(WRIST, hidden)
    drafted = Drafted.model_validate(
        {
            "first_frame": 0,
            "last_frame": 8,
            "missing": [{"first_frame": 0, "last_frame": 1}],
            "places": [{"frame": 4, "reason": "hidden", "parts": ["left_arm"]}],
        }
    )
    given = given.changed({"drafted": drafted})
    again = Session.model_validate_json(session_json(given))
    assert again.view.keypoint_corrections == (
        KeypointCorrection(frame=2, joint="left_wrist", uv=(20.0, 30.5)),
        KeypointCorrection(frame=3, joint="nose", uv=None),
    )
    assert again.subject.drafted == drafted


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ([{**WRIST, "frame": 9}], "frame 9 is beyond the video, whose frames are 0 to 8"),
        ([WRIST, WRIST], "each once"),
        ([WRIST, {**WRIST, "frame": 1}], "sort them by frame and joint"),
        ([{**WRIST, "uv": (200.0, 3.0)}], r"far outside the picture of 64×48"),
        ([{**WRIST, "uv": (float("nan"), 3.0)}], "finite number"),
        ([{**WRIST, "joint": "Left wrist"}], "joint"),
    ],
)
def test_what_is_not_of_this_video_is_refused_in_one_sentence(
    given: list[dict[str, Any]], words: str
) -> None:
    with pytest.raises(ValidationError, match=words):
        with_corrections(*given)
