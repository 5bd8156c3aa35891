"""Edits of the review: a place is right, or nobody can tell."""

from __future__ import annotations

from keypose.app.editor import actions as do
from keypose.app.editor import keyframe_edits
from keypose.app.editor.refusal import Refused
from keypose.app.editor.review import Place, review_of
from keypose.app.editor.state import EditorState
from keypose.tracker.session.annotations import Answer, DraftPlace, Reviewed
from keypose.tracker.session.schema import Session


def accept_place(state: EditorState, action: do.AcceptPlace) -> Session:
    """The motion is right there: kept with what was seen. A draft becomes a keyframe."""
    place = _find(state, action.frame, action.part)
    if isinstance(place.why, DraftPlace):
        return keyframe_edits.add_keyframe(state, place.frame)
    return _answered(state.doc, place, "accepted")


def cannot_tell(state: EditorState, action: do.CannotTell) -> Session:
    """Nobody can tell from the picture: kept, so that it is not asked again."""
    return _answered(state.doc, _find(state, action.frame, action.part), "unclear")


def _find(state: EditorState, frame: int, part: str | None) -> Place:
    for place in review_of(state.doc, state.results).places:
        if (place.frame, place.part) == (frame, part):
            return place
    raise Refused(f"There is nothing left to review at frame {frame}.")


def _answered(doc: Session, place: Place, answer: Answer) -> Session:
    """With an answer in place of older ones about the same part and frames."""
    x, y, z = (float(value) for value in place.end_m)
    part = place.part or doc.body.names[0]
    first, last = min(place.frames[0], place.frame), max(place.frames[1], place.frame)
    given = Reviewed(
        part=part, frame=place.frame, first_frame=first, last_frame=last, answer=answer,
        seen_m=(x, y, z),
    )  # fmt: skip
    others = [
        old
        for old in doc.reviewed
        if old.part != part or old.last_frame < first or old.first_frame > last
    ]
    return doc.model_copy(update={"reviewed": (*others, given)})
