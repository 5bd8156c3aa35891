"""What tracking found and is doing, as JSON."""

from __future__ import annotations

import math

import numpy as np

from keypose.app.editor.advice import next_step
from keypose.app.editor.judged import Judged
from keypose.app.editor.problem_words import sentence_of, size_of, todo_of
from keypose.app.editor.problems import BY_MOTION, Problem, problem_of
from keypose.app.store.sections.json_value import Json
from keypose.app.store.state import AppState
from keypose.tracker.session.evidence import Words
from keypose.tracker.storage.results import Span, State, expected_gain, listed, observability
from keypose.tracker.tracking.result import SegmentResult


def segments(app_state: AppState) -> Json:
    """Every segment between two keyframes and its state."""
    edit = app_state.edit
    if edit is None:
        return []
    states = edit.results.states(edit.settled)
    fitting = edit.results.fitting(edit.settled)
    words, known = edit.doc.evidence.words, Judged.of(edit.settled, edit.results)
    return [
        _segment(app_state, known, words, span, state, fitting.get(span))
        for span, state in states.items()
    ]


def _segment(
    app_state: AppState, known: Judged, words: Words, span: Span, state: State,
    track: SegmentResult | None,
) -> Json:  # fmt: skip
    first, last = span
    running = app_state.running.get(span)
    others = {"outdated": "Outdated", "none": f"Not {words.done}"}
    value: dict[str, Json] = {
        "first": first,
        "last": last,
        "state": state,
        "words": others.get(state, ""),
        "short": "",
        "todo": "",
        "cause": None,
        "part": None,
        "frames": None,
        "go": None,
        "px": None,
        "cm": None,
        "size": "",
        "percent": None,
        "pass": None,
        "of": None,
        "scores": [],
        "best": None,
        "notes": [],
        "unfinished": track is not None and track.missing > 0,
        "unreached": None if track is None or track.unreached is None else list(track.unreached),
    }
    if track is not None and track.verdict is not None:
        value |= {
            **_verdict(track, problem_of(known, track)),
            "scores": [_finite(score) for score in track.scores],
            "best": track.best_pass,
            "notes": list(track.notes),
        }
    if running is not None:
        value |= {
            "state": running.state,
            "words": "Waiting"
            if running.state == "waiting"
            else f"{words.unit} {running.number} of {running.of}",
            "percent": running.percent,
            "pass": running.number,
            "of": running.of,
            "scores": [_finite(score) for score in running.scores],
        }
    return value


def _verdict(track: SegmentResult, found: Problem | None) -> dict[str, Json]:
    """What is said of a segment: its problem, which everything else that is said of it names."""
    is_good = track.kind == "good"
    if found is None or (is_good and found.cause in BY_MOTION):
        good: dict[str, Json] = {"words": "Good", "short": "Good", "cause": "good"}
        return good if is_good else {"state": "good", "words": "Reviewed", "short": "Reviewed"}
    sentence = sentence_of(found)
    lost = "" if sentence.startswith("Lost") else "Lost. "
    check = f"Check: {sentence[:1].lower()}{sentence[1:]}"
    least = f"Good. Least sure: {sentence[:1].lower()}{sentence[1:]}"
    words = {"good": least, "check": check, "lost": f"{lost}{sentence}"}[found.kind]
    return {
        "words": sentence if found.cause == "other" else words,
        "short": words if is_good else sentence,
        "todo": todo_of(found),
        "cause": found.cause,
        "part": found.part,
        "frames": list(found.frames),
        "go": found.frame,
        "px": None if found.px is None else round(found.px, 2),
        "cm": None if found.cm is None else round(found.cm, 2),
        "size": size_of(found.px, found.cm),
    }


def suggest(app_state: AppState) -> Json:
    """The frame to key next, and why."""
    edit = app_state.edit
    if edit is None:
        return None
    fitting = edit.results.fitting(edit.settled)
    known = Judged.of(edit.settled, edit.results)
    found = next_step(edit.keys, edit.settled, fitting, known)
    return {
        "frame": found.frame,
        "title": found.title,
        "detail": found.detail,
        "kind": found.kind,
        "part": None if found.problem is None else found.problem.part,
        "cause": None if found.problem is None else found.problem.cause,
        "ahead": found.ahead,
    }


def need(app_state: AppState) -> Json:
    """Pixels that a keyframe would be expected to mend, by frame."""
    edit = app_state.edit
    if edit is None:
        return []
    return listed(expected_gain(edit.results.fitting(edit.settled), edit.frame_count), 1)


def lanes(app_state: AppState) -> Json:
    """How well each part is determined by the picture, 0 to 1, by frame."""
    edit = app_state.edit
    if edit is None:
        return {}
    names = edit.settled.body.names
    fitting = edit.results.fitting(edit.settled)
    table = observability(fitting, edit.frame_count, len(names))
    known = np.asarray(np.isfinite(table).any(axis=0))
    return {name: listed(table[:, k]) for k, name in enumerate(names) if known[k]}


def job(app_state: AppState) -> Json:
    """What the tracker is doing."""
    given = app_state.job
    return {
        "state": given.state,
        "title": given.title,
        "words": given.words,
        "percent": round(given.percent, 1),
        "seconds_left": given.seconds_left,
        "kind": given.kind,
        "worst": given.worst,
    }


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else round(float(value), 4)
