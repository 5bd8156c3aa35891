"""What tracking found and is doing, as JSON."""

from __future__ import annotations

import math

import numpy as np

from app.editor.suggest import suggestion
from app.editor.suggest_surfaces import surface_suggestion
from app.store.sections.json_value import Json
from app.store.state import Outlook
from tracker.storage.results import SegmentTrack, Span, State, listed, observability

_STATE_WORDS = {"outdated": "Outdated", "none": "Not tracked"}
_OF_SURFACES = {"outdated": "Outdated", "none": "Not fitted"}


def segments(outlook: Outlook) -> Json:
    """Every stretch between two keyframes, and how it fares."""
    edit = outlook.edit
    if edit is None:
        return []
    states = edit.results.states(edit.settled)
    fitting = edit.results.fitting(edit.settled)
    return [_segment(outlook, span, state, fitting.get(span)) for span, state in states.items()]


def _segment(outlook: Outlook, span: Span, state: State, track: SegmentTrack | None) -> Json:
    first, last = span
    running = outlook.running.get(span)
    surfaces = outlook.edit is not None and outlook.edit.doc.surface is not None
    value: dict[str, Json] = {
        "first": first,
        "last": last,
        "state": state,
        "words": (_OF_SURFACES if surfaces else _STATE_WORDS).get(state, ""),
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
    if track is not None and track.finished:
        value |= {
            "words": track.words,
            "go": track.go,
            "scores": [_finite(score) for score in track.scores],
            "best": track.best_pass,
            "notes": list(track.notes),
        }
    if running is not None:
        value |= {
            "state": running.state,
            "words": "Waiting"
            if running.state == "waiting"
            else f"{'step' if surfaces else 'pass'} {running.number} of {running.of}",
            "percent": running.percent,
            "pass": running.number,
            "of": running.of,
            "scores": [_finite(score) for score in running.scores],
        }
    return value


def suggest(outlook: Outlook) -> Json:
    """The frame to key next, and why."""
    edit = outlook.edit
    if edit is None:
        return None
    fitting = edit.results.fitting(edit.settled)
    if edit.settled.surface is not None:
        found = surface_suggestion(edit.keys, edit.settled.spans, fitting)
    else:
        found = suggestion(edit.keys, edit.frame_count, fitting, edit.settled.body.names)
    return {
        "frame": found.frame,
        "words": found.words,
        "reason": found.reason,
        "kind": found.kind,
    }


def need(outlook: Outlook) -> Json:
    """Pixels that a keyframe would be expected to mend, by frame."""
    edit = outlook.edit
    if edit is None:
        return []
    table = np.full(edit.frame_count, np.nan)
    for (first, last), track in edit.results.fitting(edit.settled).items():
        if track.need is not None:
            table[first : last + 1] = np.fmax(table[first : last + 1], track.need)
    return listed(table, 1)


def lanes(outlook: Outlook) -> Json:
    """How much the picture tells about each part, 0 to 1, by frame."""
    edit = outlook.edit
    if edit is None:
        return {}
    names = edit.settled.body.names
    fitting = edit.results.fitting(edit.settled)
    table = observability(fitting, edit.frame_count, len(names))
    known = np.asarray(np.isfinite(table).any(axis=0))
    return {name: listed(table[:, k]) for k, name in enumerate(names) if known[k]}


def job(outlook: Outlook) -> Json:
    """What the tracker is doing."""
    given = outlook.job
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
