"""What version 2 said in sentences is read once, and nothing of it is lost."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from keypose.tracker.errors import SessionError
from keypose.tracker.formats.verdict_words import verdict_words
from keypose.tracker.session.migrate import verdict_of
from keypose.tracker.session.verdict import GOOD, Cause, Kind, Verdict
from keypose.tracker.storage.edit_history import Moment, base_record, edit_record, without_results
from keypose.tracker.storage.files import journal_path, load_session, open_session, save_session
from keypose.tracker.storage.journal import lines
from keypose.tracker.storage.tracks import save_result
from tests.tracker import session_cases as cases

NAMES = ("chest", "right_hand", "left foot")
SPAN = (24, 48)
SENTENCES = {
    "good": GOOD,
    "check frames 31–36: right hand not seen": Verdict.check("not_seen", (31, 36), "right_hand"),
    "check frame 46: left foot uncertain": Verdict.check("uncertain", (46, 46), "left foot"),
    "check frames 30–40: chest beyond its joint limits": Verdict.check(
        "beyond_limits", (30, 40), "chest"
    ),
    "check frames 24–48: a pass diverged": Verdict.check("diverged", SPAN),
    "check frames 31–40: damaged in the video": Verdict.check("damaged", (31, 40)),
    "check frames 3–4: no surface that can be used": Verdict.check("no_surface", (3, 4)),
    "check frames 4–7: not fitted yet": Verdict.check("not_fitted", (4, 7)),
    "check frames 1–7: fitted from one keyframe only so far": Verdict.check("one_keyframe", (1, 7)),
    "check frame 8: the keyframe lies off its surface": Verdict.check(
        "keyframe_off_surface", (8, 8)
    ),
    "check frame 0: the body lies off the surface that moves with it": Verdict.check(
        "body_off_surface", (0, 0)
    ),
    "lost: add a keyframe near 37": Verdict.not_followed(37),
    "lost: nothing of the body is seen; check keyframes, camera and masks": Verdict.nothing_seen(
        *SPAN
    ),
    "lost: the keyframes at 24 and 48 contradict each other": Verdict.contradiction(*SPAN),
    "lost: gone": Verdict(kind="lost", cause="other", text="lost: gone"),
}
"""Of every cause that version 2 knew, in its words."""
SINCE = {"keyframe_off_keypoints", "moves_beside_body", "depth"}


def _read(kind: Any, words: str) -> Verdict:
    return verdict_of(kind, words, SPAN, NAMES)


@pytest.mark.parametrize("words", SENTENCES)
def test_every_sentence_is_read_as_what_it_says(words: str) -> None:
    found = _read(SENTENCES[words].kind, words)
    assert found == SENTENCES[words]
    assert verdict_words(found) == words


def test_there_is_a_sentence_of_every_cause() -> None:
    assert {verdict.cause for verdict in SENTENCES.values()} == set(get_args(Cause)) - SINCE


def test_of_a_part_that_the_body_has_no_more_the_words_are_kept() -> None:
    words = "check frames 31–36: third arm not seen"
    assert _read("check", words) == Verdict.check("not_seen", (31, 36), "third arm")


def test_a_sentence_that_is_not_known_still_leads_to_its_frames() -> None:
    found = _read("check", "check frames 30–40: the moon is full")
    assert (found.cause, found.frames, found.go) == ("other", (30, 40), 35)
    assert found.text == "check frames 30–40: the moon is full"


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("good", "good enough"),
        ("lost", "check frames 3–4: a pass diverged"),
        ("check", "check frames 9–3: a pass diverged"),
        ("check", "check frames 3–999999999: a pass diverged"),
        ("check", "check frames 3–4:  not seen"),
        ("check", "check frames ٣–٤: chest not seen"),
        ("lost", f"lost: add a keyframe near {'9' * 5000}"),
        ("check", ""),
    ],
)
def test_a_sentence_that_cannot_be_read_is_kept_as_it_is(kind: Kind, words: str) -> None:
    assert _read(kind, words) == Verdict(kind=kind, cause="other", text=words)


@given(st.sampled_from(get_args(Kind)), st.text() | st.sampled_from(sorted(SENTENCES)))
def test_whatever_was_said_is_said_still(kind: Kind, words: str) -> None:
    assert verdict_words(_read(kind, words)) == words


# --- files


def _tracked(tmp_path: Path, **segment: Any) -> Path:
    """A tracked session as version 2 wrote it, with something else in its first segment."""
    path = cases.write_session(tmp_path)
    save_session(save_result(load_session(path), path, cases.result()), path)
    data = cases.flat_data(load_session(path), 2)
    for found in data["results"]["segments"]:
        found |= {"verdict": "good", "words": "good"}
    data["results"]["segments"][0] |= segment
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


def _verdicts(path: Path) -> list[Verdict]:
    results = load_session(path).subject.results
    assert results is not None
    return [segment.verdict for segment in results.segments]


def test_the_session_of_version_2_opens_with_its_verdicts_and_is_backed_up_when_saved(
    tmp_path: Path,
) -> None:
    words = "check frames 1–2: left forearm not seen"
    path = _tracked(tmp_path, verdict="check", words=words, colour="red")
    content, expected = path.read_bytes(), [Verdict.check("not_seen", (1, 2), "left forearm"), GOOD]
    assert _verdicts(path) == expected
    save_session(load_session(path), path)
    assert _verdicts(path) == expected
    assert path.with_name("session.json.v2").read_bytes() == content
    segment = cases.written(path)["results"]["segments"][0]
    assert segment["verdict"] == {
        "kind": "check", "cause": "not_seen", "part": "left forearm", "frames": [1, 2], "go": 2,
    }  # fmt: skip
    assert "words" not in segment
    assert segment["colour"] == "red"


def test_a_session_of_version_1_comes_the_whole_way(tmp_path: Path) -> None:
    path = _tracked(tmp_path, verdict="lost", words="lost: add a keyframe near 2")
    data = json.loads(path.read_text("utf-8"))
    path.write_text(json.dumps({**data, "schema_version": 1}), encoding="utf-8")
    assert _verdicts(path) == [Verdict.not_followed(2), GOOD]


@pytest.mark.parametrize(
    "segment",
    [{"verdict": "great"}, {"words": 7}, {"first_frame": "0"}, {"first_frame": None}],
    ids=str,
)
def test_results_that_were_never_valid_are_refused_in_a_sentence(
    tmp_path: Path, segment: dict[str, Any]
) -> None:
    with pytest.raises(SessionError, match=r"results\.segments\.0\.") as refused:
        load_session(_tracked(tmp_path, **segment))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("results", [7, [], {"segments": {}}, {"segments": [7]}], ids=str)
def test_what_are_no_results_is_refused_in_a_sentence(tmp_path: Path, results: Any) -> None:
    path = _tracked(tmp_path)
    data = json.loads(path.read_text("utf-8"))
    path.write_text(json.dumps({**data, "results": results}), encoding="utf-8")
    with pytest.raises(SessionError, match="results"):
        load_session(path)


def test_an_edit_that_only_the_journal_of_version_2_has_comes_back(tmp_path: Path) -> None:
    path = _tracked(tmp_path, verdict="check", words="check frames 1–2: chest uncertain")
    before = Moment(without_results(load_session(path)))
    upright = before.doc.changed({"up_world": (0.0, -1.0, 0.0)})
    records = [base_record(before), edit_record(before, replace(before, doc=upright))]
    records[0]["base"] = cases.flat_data(before.doc, 2)
    journal_path(path).write_bytes(lines(records))
    found = open_session(path)
    assert (found.problem, found.recovered.ahead) == ("", 1)
    assert found.session.world.up_world == (0.0, -1.0, 0.0)
    assert _verdicts(path) == [Verdict.check("uncertain", (1, 2), "chest"), GOOD]
