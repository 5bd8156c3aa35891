"""Edits of how a film was taken, where its file does not say so."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from keypose.app.editor import actions as do
from keypose.app.editor.refusal import Refused
from keypose.app.editor.state import EditorState
from keypose.app.editor.timing import with_times
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.schema import Session


def read_film(state: EditorState, action: do.ReadFilm) -> Session:
    """Only the fields that were named change."""
    named = action.model_dump(include=action.model_fields_set & {"recorded_fps", "deinterlace"})
    return as_taken(state.doc, named, state.file_times_s)


def as_taken(doc: Session, named: Mapping[str, Any], file_times_s: Array | None = None) -> Session:
    """The session of a film that was taken so; poses keep to their frames. Refused of surfaces.

    file_times_s: not needed where a rate is named.
    """
    if doc.surface is not None:
        raise Refused("This session has surfaces, not a video: it has no recording rate or fields.")
    doc = doc.model_copy(update={"video": doc.video.model_copy(update=dict(named))})
    if "recorded_fps" not in named:
        return doc
    return with_times(doc, doc.evidence.times_s(file_times_s))
