"""What tracking found and is doing, as JSON."""

from __future__ import annotations

import math

import numpy as np

from app.editor.advice import next_step
from app.editor.verdict_text import add_keyframe, sentence, short_sentence
from app.store.sections.json_value import Json
from app.store.state import AppState
from tracker.session.evidence import Words
from tracker.session.verdict import Verdict
from tracker.storage.results import Span, State, expected_gain, listed, observability
from tracker.tracking.result import SegmentResult


def segments(app_state: AppState) -> Json:
    """Every segment between two keyframes and its state."""
    edit = app_state.edit
    if edit is None:
        return []
    states = edit.results.states(edit.settled)
    fitting = edit.results.fitting(edit.settled)
    words = edit.doc.evidence.words
    return [
        _segment(app_state, words, span, state, fitting.get(span)) for span, state in states.items()
    ]


def _segment(
    app_state: AppState, words: Words, span: Span, state: State, track: SegmentResult | None
) -> Json:
    first, last = span
    running = app_state.running.get(span)
    unsaid = {"outdated": "Outdated", "none": f"Not {words.done}"}
    value: dict[str, Json] = {
        "first": first,
        "last": last,
        "state": state,
        "words": unsaid.get(state, ""),
        "short": "",
        "todo": "",
        "cause": None,
        "part": None,
        "frames": None,
        "go": None,
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
            **_verdict(app_state, span, track.verdict),
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


def _verdict(app_state: AppState, span: Span, verdict: Verdict) -> dict[str, Json]:
    return {
        "words": sentence(verdict, *span),
        "short": short_sentence(verdict, *span),
        "todo": _todo(app_state, verdict),
        "cause": verdict.cause,
        "part": verdict.part,
        "frames": None if verdict.frames is None else list(verdict.frames),
        "go": verdict.go,
    }


def _todo(app_state: AppState, verdict: Verdict) -> str:
    """What to do about it; where the trouble is a keyframe itself, one only looks at it."""
    if verdict.go is None or app_state.edit is None:
        return ""
    if verdict.kind == "lost" and verdict.go not in app_state.edit.keys:
        return add_keyframe(verdict.go)
    return f"Go to {verdict.go}"


def suggest(app_state: AppState) -> Json:
    """The frame to key next, and why."""
    edit = app_state.edit
    if edit is None:
        return None
    fitting = edit.results.fitting(edit.settled)
    found = next_step(edit.keys, edit.settled, fitting)
    return {
        "frame": found.frame,
        "title": found.title,
        "detail": found.detail,
        "kind": found.kind,
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
    }


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else round(float(value), 4)
