"""Part keyframes in a session: what may be keyed alone, and what is refused in one sentence."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import ValidationError

from keypose.tracker.errors import one_sentence
from keypose.tracker.session import Keyframe, PartKeyframe, Session
from tests.tracker import session_cases as cases

POSED = Keyframe.of(cases.SKELETON, cases.pose(0.2), 2, 0.08).model_dump(mode="json")
HAND = {**POSED, "parts": ["left_hand"]}
ROOT = cases.SKELETON.body.names[0]


def opened(*parts: dict[str, Any], **changes: Any) -> Session:
    """A session with these part keyframes, read as from its file."""
    fields = {**cases.flat(cases.session()), "part_keyframes": list(parts), **changes}
    return Session.begin(**fields)


def refusal(*parts: dict[str, Any], **changes: Any) -> str:
    with pytest.raises(ValidationError) as refused:
        opened(*parts, **changes)
    return one_sentence(refused.value)


def test_part_keyframes_are_kept_as_they_were_written_with_fields_from_elsewhere() -> None:
    session = opened({**HAND, "why": "dragged in review"}, {**HAND, "frame": 6, "time_s": 0.24})
    again = Session.model_validate_json(session.model_dump_json())
    assert again.subject.part_keyframes == session.subject.part_keyframes
    first = again.subject.part_keyframes[0]
    assert isinstance(first, PartKeyframe)
    assert first.parts == ("left_hand",)
    assert first.model_extra == {"why": "dragged in review"}
    assert [keyframe.frame for keyframe in again.subject.keyframes] == [0, 4, 8]
    assert again.spans == ((0, 4), (4, 8))


def test_a_session_without_part_keyframes_does_not_name_them() -> None:
    assert '"part_keyframes"' not in cases.session().model_dump_json()


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ([{**HAND, "parts": ["tail"]}], "'tail', which the body does not have; its parts are"),
        ([{**HAND, "parts": []}], "parts"),
        ([{**HAND, "parts": [ROOT]}], "carries all others; make it a keyframe"),
        ([{**HAND, "parts": ["left_hand", "left_hand"]}], "names a part twice"),
        ([{**HAND, "frame": 4, "time_s": 0.16}], "frame 4 is a keyframe; one is allowed"),
        ([{**HAND, "frame": 99, "time_s": 4.0}], "frame 99 is beyond the video"),
        ([HAND, HAND], "frame 2 has two keyframes; one is allowed"),
        ([{**HAND, "root_m": [0, 0, -3]}], "behind the camera"),
        ([HAND] * 10_001, "more than the 10000"),
    ],
    ids=["foreign", "none", "root", "twice", "keyframe", "beyond", "two", "behind", "many"],
)
def test_what_cannot_be_keyed_alone_is_refused_in_one_sentence(
    parts: list[dict[str, Any]], words: str
) -> None:
    message = refusal(*parts)
    assert words in message
    assert "\n" not in message


def test_a_body_is_fitted_to_surfaces_as_a_whole() -> None:
    surface = {"p_camera_surface": [0, 0, 3]}
    assert "surfaces as a whole; make them keyframes" in refusal(HAND, surface=surface)
