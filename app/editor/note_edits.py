"""Edits of the notes at frames."""

from __future__ import annotations

from keypose.app.editor import actions as do
from keypose.app.editor.refusal import Refused
from keypose.app.editor.state import EditorState
from keypose.tracker.session.annotations import Note
from keypose.tracker.session.schema import Session


def set_note(state: EditorState, action: do.SetNote) -> Session:
    """One more note, or other words for the one at this frame."""
    frame = _in_video(state, action.frame)
    known = _at(state, frame)
    text = action.text.strip()
    note = Note(frame=frame) if known is None else known
    return _with_note(state, frame, note.model_copy(update={"text": text}))


def move_note(state: EditorState, action: do.MoveNote) -> Session:
    """A note at another frame."""
    note, to = _require(state, action.frame), _in_video(state, action.to)
    if to == action.frame:
        return state.doc
    if _at(state, to) is not None:
        raise Refused(f"Frame {to} has a note already.")
    return _with_note(state, action.frame, note.model_copy(update={"frame": to}))


def delete_note(state: EditorState, action: do.DeleteNote) -> Session:
    """One note fewer."""
    _require(state, action.frame)
    return _with_note(state, action.frame, None)


def _with_note(state: EditorState, instead_of: int, note: Note | None) -> Session:
    """With this note instead of the one at a frame, sorted by frame."""
    others = [other for other in state.doc.notes if other.frame != instead_of]
    notes = [*others, *([] if note is None else [note])]
    return state.doc.model_copy(update={"notes": tuple(sorted(notes, key=lambda n: n.frame))})


def _at(state: EditorState, frame: int) -> Note | None:
    return next((note for note in state.doc.notes if note.frame == frame), None)


def _require(state: EditorState, frame: int) -> Note:
    note = _at(state, frame)
    if note is None:
        raise Refused(f"Frame {frame} has no note.")
    return note


def _in_video(state: EditorState, frame: int) -> int:
    if frame >= state.frame_count:
        raise Refused(f"The video has frames 0 to {state.frame_count - 1}.")
    return frame
