"""All that is said of one problem names the same frame, part and reason."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, get_args

import numpy as np
import pytest

from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label
from keypose.app.state.app_state import AppState
from keypose.app.store.sections import motion_values
from keypose.tracker.body.trajectory import Pass, interpolate
from keypose.tracker.review.segments import JudgedSegments
from keypose.tracker.session.annotations import Reviewed
from keypose.tracker.session.verdict import GOOD, Cause, Verdict
from keypose.tracker.storage.results import Results, segment_keys
from keypose.tracker.tracking.result import SegmentResult
from tests.app.editor.desk import desk

STATES = 120
LEAST_PX = 3.0
OF_A_PART = ("uncertain", "not_seen", "beyond_limits", "keyframe_off_keypoints", "depth")
SURFACES_ONLY = (
    "no_surface", "not_fitted", "one_keyframe", "keyframe_off_surface", "body_off_surface",
)  # fmt: skip
CHECKED: tuple[Cause, ...] = tuple(
    cause
    for cause in get_args(Cause)
    if cause not in (*SURFACES_ONLY, "good", "not_followed", "nothing_seen", "contradiction")
)


def some_verdict(
    rng: np.random.Generator, first: int, last: int, parts: tuple[str, ...]
) -> Verdict:
    kind = rng.choice(["good", "check", "lost"], p=[0.3, 0.5, 0.2])
    if kind == "good":
        return GOOD
    if kind == "lost":
        somewhere = int(rng.integers(first + 1, last))
        return [
            Verdict.not_followed(somewhere),
            Verdict.nothing_seen(first, last),
            Verdict.contradiction(first, last),
        ][rng.integers(3)]
    cause = CHECKED[rng.integers(len(CHECKED))]
    if cause == "other":
        return Verdict(kind="check", cause="other", text="The moon is full")
    ends = sorted(int(frame) for frame in rng.integers(first + 1, last, 2))
    if cause == "keyframe_off_keypoints":
        ends = [first, first]
    part = str(rng.choice(parts)) if cause in OF_A_PART else None
    return Verdict.check(cause, (ends[0], ends[1]), part)


def some_result(
    rng: np.random.Generator, edit: EditorState, first: int, last: int
) -> SegmentResult:
    """A segment as tracking may leave it: any verdict, with gains and errors or without."""
    start, end = (
        key.pose(edit.skeleton) for key in edit.doc.subject.keyframes if key.frame in (first, last)
    )
    path = interpolate(start, end, first, last)
    found = SegmentResult.on_the_way(Pass("pass", path, 1.0), segment_keys(edit.doc)[first, last])
    frames, parts = last - first + 1, edit.skeleton.part_count
    rise = np.sin(np.linspace(0, np.pi, frames)) ** rng.uniform(0.2, 3)
    seen = np.clip(rng.normal(rng.uniform(0.2, 1), 0.3, (frames - 1, parts)), 0, 1)
    gain = rise * rng.uniform(0, 200) if rng.random() < 0.8 else None
    error = None
    if rng.random() < 0.7:
        error = rng.uniform(3, 6) * (1 + rise[:, None] * rng.exponential(0.5, parts))
        error += rng.uniform(0, 1, error.shape)
        error[:, rng.random(parts) < 0.3] = np.nan
        error[[0, -1]] = np.where(np.isfinite(error[[0, -1]]), 0.0, np.nan)
    known = replace(found.diagnostics, observability=seen, expected_gain=gain, expected_error=error)
    verdict = some_verdict(rng, first, last, edit.doc.subject.body.names)
    return replace(found, verdict=verdict, diagnostics=known)


def some_state(seed: int) -> AppState:
    """The sample with its segments tracked, now and then not all, some of it reviewed already."""
    rng = np.random.default_rng(seed)
    edit = desk()
    spans = [span for span in edit.doc.spans if rng.random() < 0.95]
    tracks = [some_result(rng, edit, *span) for span in spans]
    edit = edit.with_results(Results({track.key: track for track in tracks}))
    for _ in range(rng.integers(3)):
        places: Any = motion_values.review(AppState(edit=edit))
        if not places["places"]:
            break
        edit = edit.with_doc(answered(edit, places["places"][0], rng))
    return AppState(edit=edit)


def answered(edit: EditorState, place: Any, rng: np.random.Generator) -> Any:
    message = Reviewed(
        part=place["part"] or edit.doc.subject.body.names[0], frame=place["frame"],
        first_frame=min(place["first"], place["frame"]),
        last_frame=max(place["last"], place["frame"]),
        answer="accepted" if rng.random() < 0.7 else "unclear", seen_m=place["end"],
    )  # fmt: skip
    return edit.doc.changed({"reviewed": (*edit.doc.subject.reviewed, message)})


def named(reported: Any) -> tuple[Any, ...]:
    return reported["frame"], reported["part"], reported["cause"]


def test_head_card_strip_and_review_name_the_same_frame_part_and_reason(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What hides a part is told by its name: looking along the line of sight takes its time."""
    monkeypatch.setattr(
        JudgedSegments,
        "occluder",
        lambda _, __, frame, part: "chest" if (frame + len(part)) % 3 == 0 else None,
    )
    problems = suggested = 0
    for seed in range(STATES):
        state = some_state(seed)
        reported = ReportedScene(state, seed)
        for segment in reported.segments:
            if segment["go"] is not None:
                problems += 1
                reported.require_card(segment)
                reported.require_review(segment)
        suggested += reported.suggest["cause"] is not None
        reported.require_suggestion()
    assert problems > STATES
    assert suggested > STATES / 2


class ReportedScene:
    """What the page is told of a state."""

    def __init__(self, state: AppState, seed: int) -> None:
        self.segments: Any = motion_values.segments(state)
        self.suggest: Any = motion_values.suggest(state)
        self.errors: Any = motion_values.errors(state)
        self.review: Any = motion_values.review(state)
        self.places = [named(place) for place in self.review["places"]]
        self.seed = seed

    def require_card(self, segment: Any) -> None:
        """Words, rows of errors and the frame to go to are about the problem."""
        assert str(segment["go"]) in segment["todo"], self.seed
        if segment["part"] and segment["cause"] in OF_A_PART:
            label = part_label(segment["part"]).lower()
            assert label in segment["words"].lower(), self.seed
            assert label in segment["short"].lower(), self.seed
        for row in self.errors:
            about = (row["first"], row["part"]) == (segment["first"], segment["part"])
            if about and segment["px"] is not None:
                shown = row["frame"], row["px"], row["cm"]
                assert shown == (segment["go"], segment["px"], segment["cm"]), self.seed

    def require_review(self, segment: Any) -> None:
        """A place to review, unless a person could not tell, or it is hardly off."""
        if segment["px"] is not None and segment["px"] <= LEAST_PX:
            return
        left = [s["frame"] for s in self.review["answered"] if s["answer"] == "unclear"]
        is_left = any(segment["first"] <= frame <= segment["last"] for frame in left)
        assert (segment["go"], segment["part"], segment["cause"]) in self.places or is_left, (
            self.seed
        )

    def require_suggestion(self) -> None:
        """Where the frame to key next lies in a segment that has a problem, it is that problem."""
        if self.suggest["cause"] is None:
            return
        frame = self.suggest["frame"]
        assert str(frame) in self.suggest["title"], self.seed
        around = [s for s in self.segments if s["first"] <= frame <= s["last"]]
        bad = [s for s in around if s["go"] is not None]
        assert len(bad) < len(around) or named(self.suggest) in [
            (s["go"], s["part"], s["cause"]) for s in bad
        ], self.seed
        sizes = [place["px"] for place in self.review["places"]]
        if sizes and self.suggest["part"] is not None and self.suggest["cause"] in OF_A_PART:
            label = part_label(self.suggest["part"]).lower()
            assert label in self.suggest["detail"].lower(), self.seed
