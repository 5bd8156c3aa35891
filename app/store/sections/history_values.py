"""Undo and redo as a list, and the notes at frames, as JSON."""

from __future__ import annotations

from keypose.app.store.sections.json_value import Json, doc_of
from keypose.app.store.state import AppState

MOST_LISTED = 200
"""Steps on either side of the present one; further ones are listed once one has gone there."""


def history(app_state: AppState) -> Json:
    """The steps around the present one, oldest first. done: how many are done, of `total`; first:
    how many stand before those that are listed. made: seconds since 1970, null where not kept."""
    edit = app_state.edit
    if edit is None:
        return None
    past, future = edit.history.past, tuple(reversed(edit.history.future))
    first = max(0, len(past) - MOST_LISTED)
    listed = (*past[first:], *future[:MOST_LISTED])
    return {
        "done": len(past),
        "total": edit.history.total,
        "first": first,
        "steps": [
            {"label": step.label, "frame": step.frame, "made": step.made_s} for step in listed
        ],
    }


def notes(app_state: AppState) -> Json:
    """The notes, by frame."""
    doc = doc_of(app_state)
    return [{"frame": note.frame, "text": note.text} for note in (doc.notes if doc else ())]
