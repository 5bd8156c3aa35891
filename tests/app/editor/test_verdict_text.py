"""The verdict in the page's words, and what it is put down to."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast, get_args

import pytest

from keypose.app.words.problems import reason_with_frames, sentence, sentence_of, short_sentence
from keypose.tracker.review.problems import Problem, blames_keys
from keypose.tracker.session.verdict import GOOD, Cause, Verdict

HAND = "right_hand"
OF_A_PROBLEM = {
    (0, 24): "Right hand hidden",
    (1, 23): "Right hand hidden",
    (2, 23): "Right hand hidden, frames 2–23",
    (1, 22): "Right hand hidden, frames 1–22",
    (23, 23): "Right hand hidden, frame 23",
}


@pytest.mark.parametrize("frames", OF_A_PROBLEM)
def test_the_frames_of_a_problem_are_left_out_where_they_are_all_between_the_keyframes(
    frames: tuple[int, int],
) -> None:
    found = Problem((0, 24), "check", "not_seen", 12, frames, HAND, "key")
    assert sentence_of(found) == OF_A_PROBLEM[frames]


SAID = {
    "Good": GOOD,
    "Check: right hand hidden, frames 31–36": Verdict.check("not_seen", (31, 36), HAND),
    "Check: left foot may be wrong, frame 46": Verdict.check("uncertain", (46, 46), "left_foot"),
    "Check: left foot hidden": Verdict.check("not_seen", (25, 47), "left_foot"),
    "Check: right hand beyond its joint limits, frames 30–32": Verdict.check(
        "beyond_limits", (30, 32), HAND
    ),
    "Check: a pass diverged": Verdict.check("diverged", (24, 48)),
    "Check: frames 31–40 are damaged in the video": Verdict.check("damaged", (31, 40)),
    "Check: frame 31 is damaged in the video": Verdict.check("damaged", (31, 31)),
    "Check: no surface that can be used, frames 33–34": Verdict.check("no_surface", (33, 34)),
    "Check: not fitted yet, frames 40–48": Verdict.check("not_fitted", (40, 48)),
    "Check: fitted from one keyframe only so far": Verdict.check("one_keyframe", (25, 47)),
    "Check: the keyframe is off its surface, frame 48": Verdict.check(
        "keyframe_off_surface", (48, 48)
    ),
    "Check: at key 0 the body is off its surface": Verdict.check("body_off_surface", (0, 0)),
    "Check: at key 24 the left forearm is not where it is seen": Verdict.check(
        "keyframe_off_keypoints", (24, 24), "left_forearm"
    ),
    "Lost. At key 24 the body is not where it is seen": Verdict.off_person(24),
    "Check: the body does not match the silhouette, frames 31–36": Verdict.check(
        "moves_beside_body", (31, 36)
    ),
    "Check: left forearm a guess in depth, frames 31–36": Verdict.check(
        "depth", (31, 36), "left_forearm"
    ),
    "Lost. Add a keyframe at 37": Verdict.not_followed(37),
    "Lost. The body is not visible: check keyframes, camera and masks": Verdict.nothing_seen(
        24, 48
    ),
    "Lost. Keys 24 and 25 contradict each other": Verdict.contradiction(24, 25),
    "Check frames 30–40: the moon is full": Verdict(
        kind="check", cause="other", text="check frames 30–40: the moon is full"
    ),
}


@pytest.mark.parametrize("message", SAID)
def test_a_verdict_is_said_in_sentence_case_without_repeating_the_frames_of_its_segment(
    message: str,
) -> None:
    assert sentence(SAID[message], 24, 48) == message


def test_a_verdict_without_frames_names_none() -> None:
    nowhere = Verdict(kind="lost", cause="nothing_seen")
    words = "Lost. The body is not visible: check keyframes, camera and masks"
    assert sentence(nowhere, 24, 48) == words


def test_there_is_a_sentence_for_every_cause() -> None:
    assert {verdict.cause for verdict in SAID.values()} == set(get_args(Cause))


def test_beside_a_button_that_adds_the_keyframe_the_sentence_is_short() -> None:
    assert short_sentence(Verdict.not_followed(37), 24, 48) == "Lost"


def test_beside_the_sign_for_check_the_sentence_does_not_say_check_again() -> None:
    others = [verdict for verdict in SAID.values() if verdict.cause != "not_followed"]
    short = [short_sentence(verdict, 24, 48) for verdict in others]
    whole = [sentence(verdict, 24, 48).removeprefix("Check: ") for verdict in others]
    assert short == [words[:1].upper() + words[1:] for words in whole]


def test_as_a_reason_a_verdict_always_names_its_frames() -> None:
    hidden = Verdict.check("not_seen", (25, 47), "left_foot")
    assert reason_with_frames(hidden, capital=True) == "Left foot hidden, frames 25–47"
    damaged = Verdict.check("damaged", (31, 40))
    assert reason_with_frames(damaged, capital=True) == "Frames 31–40 are damaged in the video"


@pytest.mark.parametrize(
    ("verdict", "last", "blamed"),
    [
        (Verdict.not_followed(1), 1, True),
        (Verdict.not_followed(1), 2, False),
        (Verdict.check("uncertain", (0, 1), "head"), 1, False),
        (Verdict.nothing_seen(0, 40), 40, True),
        (Verdict.contradiction(0, 1), 40, True),
        (Verdict.off_person(40), 40, True),
        (None, 1, False),
    ],
)
def test_keyframes_are_to_blame_where_they_are_wrong_or_nothing_lies_between(
    verdict: Verdict | None, last: int, blamed: bool
) -> None:
    kind = None if verdict is None else verdict.kind
    track = SimpleNamespace(verdict=verdict, kind=kind, first=0, last=last)
    assert blames_keys(cast(Any, track)) is blamed
