"""A verdict is complete, so that everything can be said of it."""

from __future__ import annotations

from typing import Any, get_args

import pytest
from pydantic import ValidationError

from keypose.tracker.formats.verdict_words import verdict_words
from keypose.tracker.session.verdict import CAUSES, Cause, Verdict, worst_of

INCOMPLETE: dict[str, dict[str, Any]] = {
    "needs a part": {"cause": "not_seen", "frames": (3, 4), "go": 3},
    "needs frames and go": {"cause": "diverged", "go": 3},
    "cause damaged needs frames and go": {"cause": "damaged", "frames": (3, 4)},
    "cause good does not go with check": {"cause": "good"},
    "cause diverged does not go with good": {
        "kind": "good", "cause": "diverged", "frames": (3, 4), "go": 3,
    },
    "the first must not be after the last": {"cause": "diverged", "frames": (4, 3), "go": 3},
}  # fmt: skip


@pytest.mark.parametrize("words", INCOMPLETE)
def test_a_verdict_that_could_not_be_said_is_refused(words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        Verdict.model_validate({"kind": "check", **INCOMPLETE[words]})


def test_the_frame_to_go_to_is_the_middle_of_what_is_to_be_checked() -> None:
    assert Verdict.check("diverged", (31, 36)).go == 34
    assert Verdict.check("diverged", (46, 46)).go == 46
    assert Verdict.contradiction(3, 4).go == 3
    assert Verdict.not_followed(7).go == 7


def test_the_worst_verdict_of_several_is_found_where_some_have_none() -> None:
    assert worst_of(["good", None, "lost", "check"]) == "lost"
    assert worst_of(["good", "check", "good"]) == "check"
    assert worst_of([None]) is None


def test_every_cause_is_explained_in_the_schema() -> None:
    assert [line.partition(":")[0] for line in CAUSES.splitlines()] == list(get_args(Cause))


def test_in_files_a_verdict_begins_with_its_kind() -> None:
    part = Verdict.check("not_seen", (31, 36), "right_hand")
    assert verdict_words(part) == "check frames 31–36: right hand not seen"


@pytest.mark.parametrize("cause", [one for one in get_args(Cause) if one != "other"])
def test_every_cause_has_words_for_files_and_the_command_line(cause: Cause) -> None:
    given = {"kind": "good" if cause == "good" else "check", "cause": cause, "part": "left_hand"}
    verdict = Verdict.model_construct(**given, frames=(3, 4), go=3)
    assert verdict_words(verdict).startswith(given["kind"])
