"""The verdict in the page's words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.app.results_cases import told
from tests.tracker.tracking.diagnostics import test_verdict as verdicts
from tracker.storage.results import Finding
from tracker.tracking.diagnostics.judge import judge

SAID = [
    ("good", "good", "Good", None),
    ("check", "check frames 31–36: right hand not seen", "Check: right hand hidden 31–36", 34),
    ("check", "check frame 46: left foot uncertain", "Check: left foot uncertain 46", 46),
    ("check", "check frames 25–47: left foot not seen", "Check: left foot hidden", 36),
    ("check", "check frames 24–48: a pass diverged", "Check: a pass diverged", 36),
    (
        "check",
        "check frames 31–40: damaged in the video",
        "Check: frames 31–40 are damaged in the video",
        36,
    ),
    (
        "check",
        "check frame 31: damaged in the video",
        "Check: frame 31 is damaged in the video",
        31,
    ),
    ("lost", "lost: add a keyframe near 37", "Lost. Key frame 37", 37),
    (
        "lost",
        "lost: nothing of the body is seen; check keyframes, camera and masks",
        "Lost. Nothing of the body is seen: check keys, camera and masks",
        None,
    ),
    ("check", "check frames 30–40: the moon is full", "Check: the moon is full 30–40", 35),
    ("lost", "lost: gone", "Lost: gone", None),
]


@pytest.mark.parametrize(("kind", "words", "said", "go"), SAID, ids=[said[2] for said in SAID])
def test_verdicts_are_said_in_sentence_case_without_repeating_frames(
    kind: str, words: str, said: str, go: int | None
) -> None:
    track = told(24, 48, kind, words)  # type: ignore[arg-type]
    assert (track.words, track.go) == (said, go)


def test_keys_that_contradict_each_other_are_named() -> None:
    track = told(3, 4, "lost", "lost: the keyframes at 3 and 4 contradict each other")
    assert track.words == "Lost. Keys 3 and 4 contradict each other"
    assert track.go == 3


def test_whatever_the_tracker_says_is_understood() -> None:
    clear, marks, n = verdicts.clear(), verdicts.MARKS, verdicts.N
    far = np.full((n + 1, marks), verdicts.FAR)
    hidden = clear.observability.copy()
    hidden[5:10, verdicts.SKELETON.body.index("left_hand")] = 0.01
    hidden[5:10, verdicts.SKELETON.body.index("chest")] = 0.01
    drift = np.zeros((n, marks))
    drift[8] = 0.2 * verdicts.FAR
    said = [
        judge(verdicts.SCENE, verdicts.SEGMENT, outcome, seen)
        for outcome, seen in (
            (verdicts.outcome(), clear),
            (verdicts.outcome(far, far[1:]), clear),
            (verdicts.outcome(diverged=True), clear),
            (verdicts.outcome(), replace(clear, observability=hidden)),
            (verdicts.outcome(), replace(clear, shown=np.zeros_like(clear.shown))),
            (verdicts.outcome(drift=drift / n), clear),
        )
    ]
    found = [Finding.of(verdict.kind, verdict.words) for verdict in said]
    assert [finding.what for finding in found] == [
        *("good", "near", "diverged", "hidden", "nowhere"),
        "uncertain",
    ]
    assert [finding.frames for finding in found] == [
        None if what == "nowhere" else verdict.frames
        for what, verdict in zip([f.what for f in found], said, strict=True)
    ]
