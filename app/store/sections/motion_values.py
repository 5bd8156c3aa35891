"""Give what tracking found and is doing as JSON, with errors to expect and places to review."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from keypose.app.editor.advice import next_step
from keypose.app.state.app_state import AppState
from keypose.app.store.sections.body_values import side_of
from keypose.app.store.sections.json_value import Json
from keypose.app.words.problems import sentence_of, size_of, todo_of
from keypose.app.words.review import label_of_place, reason_of_place
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.review.places import GOALS_PX, Place, Review, review_of
from keypose.tracker.review.problems import BY_MOTION, Problem, problem_of
from keypose.tracker.review.segment_errors import best_row, part_errors_px
from keypose.tracker.review.segments import JudgedSegments
from keypose.tracker.session.annotations import DraftPlace
from keypose.tracker.session.evidence import Words
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.results import Span, State, expected_gain, listed, observability
from keypose.tracker.tracking.result import SegmentResult

MOST: Final = 5
"""Parts of a segment that are listed."""


def errors(app_state: AppState) -> Json:
    """The parts of every segment with the largest expected errors, each where it is large, the
    worst first: in pixels of the video, and in centimetres unless the lens is a guess."""
    edit = app_state.edit
    if edit is None:
        return []
    judged_segments = JudgedSegments.of(edit.settled, edit.results)
    return [
        {"first": track.first, **worst}
        for track in judged_segments.tracks.values()
        for worst in _worst_parts(judged_segments, track)
    ]


def _worst_parts(judged_segments: JudgedSegments, track: SegmentResult) -> list[dict[str, Json]]:
    """Up to MOST parts of one segment, of those of which anything is known. The part that the
    segment's problem is about stands with the problem's frame."""
    errors = part_errors_px(track)
    if errors is None:
        return []
    last = len(errors) - 1
    problem = problem_of(judged_segments, track)
    listed = []
    for part, largest in enumerate(errors.max(axis=0)):
        if largest < 0:
            continue
        row = best_row(track, part, 0, last)
        if (
            problem is not None
            and judged_segments.name(part) == problem.part
            and problem.px is not None
        ):
            row = problem.frame - track.first
        listed.append((float(errors[row, part]), part, row))
    listed.sort(key=lambda entry: -entry[0])
    return [_row(judged_segments, track, *entry) for entry in listed[:MOST]]


def _row(
    judged_segments: JudgedSegments, track: SegmentResult, px: float, part: int, row: int
) -> dict[str, Json]:
    name, frame = judged_segments.parts[part], track.first + row
    cm = judged_segments.error_cm(track, frame, name, px)
    return {"part": name, "frame": frame, "px": round(px, 2), "cm": _rounded(cm)}


def segments(app_state: AppState) -> Json:
    """Every segment between two keyframes and its state."""
    edit = app_state.edit
    if edit is None:
        return []
    states = edit.results.states(edit.settled)
    fitting = edit.results.fitting(edit.settled)
    words, judged_segments = edit.doc.evidence.words, JudgedSegments.of(edit.settled, edit.results)
    return [
        _segment(app_state, judged_segments, words, span, state, fitting.get(span))
        for span, state in states.items()
    ]


def _segment(
    app_state: AppState,
    judged_segments: JudgedSegments,
    words: Words,
    span: Span,
    state: State,
    track: SegmentResult | None,
) -> Json:
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
            **_verdict(track, problem_of(judged_segments, track)),
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


def _verdict(track: SegmentResult, problem: Problem | None) -> dict[str, Json]:
    """What is said of a segment: its problem, which everything else that is said of it
    names.
    """
    is_good = track.kind == "good"
    if problem is None or (is_good and problem.cause in BY_MOTION):
        good: dict[str, Json] = {"words": "Good", "short": "Good", "cause": "good"}
        return good if is_good else {"state": "good", "words": "Reviewed", "short": "Reviewed"}
    sentence = sentence_of(problem)
    lost = "" if sentence.startswith("Lost") else "Lost. "
    check = f"Check: {sentence[:1].lower()}{sentence[1:]}"
    least = f"Good. Least sure: {sentence[:1].lower()}{sentence[1:]}"
    words = {"good": least, "check": check, "lost": f"{lost}{sentence}"}[problem.kind]
    return {
        "words": sentence if problem.cause == "other" else words,
        "short": words if is_good else sentence,
        "todo": todo_of(problem),
        "cause": problem.cause,
        "part": problem.part,
        "frames": list(problem.frames),
        "go": problem.frame,
        "px": None if problem.px is None else round(problem.px, 2),
        "cm": None if problem.cm is None else round(problem.cm, 2),
        "size": size_of(problem.px, problem.cm),
    }


def suggest(app_state: AppState) -> Json:
    """The frame to key next, and why."""
    edit = app_state.edit
    if edit is None:
        return None
    fitting = edit.results.fitting(edit.settled)
    judged_segments = JudgedSegments.of(edit.settled, edit.results)
    suggestion = next_step(edit.keys, edit.settled, fitting, judged_segments)
    return {
        "frame": suggestion.frame,
        "title": suggestion.title,
        "detail": suggestion.detail,
        "kind": suggestion.kind,
        "part": None if suggestion.problem is None else suggestion.problem.part,
        "cause": None if suggestion.problem is None else suggestion.problem.cause,
        "ahead": suggestion.ahead,
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
    names = edit.settled.subject.body.names
    fitting = edit.results.fitting(edit.settled)
    table = observability(fitting, edit.frame_count, len(names))
    has_values = np.asarray(np.isfinite(table).any(axis=0))
    return {name: listed(table[:, k]) for k, name in enumerate(names) if has_values[k]}


def job(app_state: AppState) -> Json:
    """What the tracker is doing."""
    job_state = app_state.job
    return {
        "state": job_state.state,
        "title": job_state.title,
        "words": job_state.words,
        "percent": round(job_state.percent, 1),
        "seconds_left": job_state.seconds_left,
        "kind": job_state.kind,
        "worst": job_state.worst,
    }


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else round(float(value), 4)


CROP_SHARE = 0.25
LEAST_CROP_PX = 40
"""Side of the picture beside a place: of the body's height, and at least."""


def review(app_state: AppState) -> Json:
    """The places to look at, the worst first, the answers that count, and the goals."""
    edit = app_state.edit
    if edit is None:
        return None
    doc = edit.settled
    reviewed_motion = review_of(doc, edit.results)
    return {
        "places": [_place(doc, reviewed_motion, place) for place in reviewed_motion.places],
        "answered": [
            {"frame": reviewed.frame, "part": reviewed.part, "answer": reviewed.answer}
            for reviewed in reviewed_motion.answered
        ],
        "goal": reviewed_motion.goal_px,
        "goals": list(GOALS_PX),
        "right_px": _rounded(reviewed_motion.right_px),
        "px": _rounded(reviewed_motion.px),
        "cm": _rounded(reviewed_motion.cm),
        "untracked": len(reviewed_motion.untracked),
    }


def _place(doc: Session, reviewed_motion: Review, place: Place) -> Json:
    """`end` is in the camera frame, metres; `at` and `box` pixels of the picture as it is shown."""
    camera = doc.film_camera.at(place.frame).without_distortion()
    body = camera.project(place.body_m)
    crop = max(CROP_SHARE * reviewed_motion.body_m * place.px_per_m, LEAST_CROP_PX)
    return {
        "id": place.id,
        "kind": "draft" if isinstance(place.why, DraftPlace) else "tracked",
        "frame": place.frame,
        "part": place.part,
        "label": label_of_place(place),
        "side": "C" if place.part is None else side_of(doc.subject.body, place.part),
        "cause": place.cause,
        "first": place.frames[0],
        "last": place.frames[1],
        "px": _rounded(place.px),
        "cm": _rounded(place.cm),
        "size": size_of(place.px, place.cm),
        "reason": reason_of_place(place),
        "end": _listed(place.end_m, 4),
        "radius_m": round((place.px or 0.0) / place.px_per_m, 4),
        "at": _listed(camera.project(place.end_m), 1),
        "crop": round(crop, 1),
        "box": [*_listed(body.min(axis=0), 1), *_listed(body.max(axis=0), 1)],
    }


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 2)


def _listed(values: Array, digits: int) -> list[float]:
    return [round(float(value), digits) for value in values]
