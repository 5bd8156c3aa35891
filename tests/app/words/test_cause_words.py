"""Every cause is worded, for files and for the page."""

from __future__ import annotations

import string
from typing import get_args

import pytest

from keypose.tracker.formats.cause_words import CAUSE_WORDS
from keypose.tracker.review.problems import ProblemCause
from keypose.tracker.session.verdict import Cause

IN_FILES = {"part", "first", "last"}
ON_THE_PAGE = {*IN_FILES, "frames"}
OF_A_PROBLEM = {"Part", "range", "span", "length", "within", "hidden", "differs"}


def named(words: str) -> set[str]:
    return {name for _, name, _, _ in string.Formatter().parse(words) if name is not None}


def test_every_cause_of_a_verdict_has_words_for_files() -> None:
    assert {cause for cause in get_args(Cause) if cause != "other"} <= CAUSE_WORDS.keys()
    assert all(CAUSE_WORDS[cause].file for cause in get_args(Cause) if cause != "other")


def test_what_is_a_problem_and_no_verdict_has_words_of_its_own() -> None:
    own = {cause for kinds in get_args(ProblemCause) for cause in get_args(kinds)}
    assert CAUSE_WORDS.keys() == own - {"other"}
    for cause in own - {*get_args(Cause)}:
        assert CAUSE_WORDS[cause].row
        assert CAUSE_WORDS[cause].alone


@pytest.mark.parametrize("cause", CAUSE_WORDS)
def test_words_name_nothing_but_what_is_known_where_they_are_said(cause: str) -> None:
    words = CAUSE_WORDS[cause]
    assert named(words.file) <= IN_FILES
    assert named(words.shown) <= ON_THE_PAGE
    assert named(words.row) | named(words.alone) <= OF_A_PROBLEM
