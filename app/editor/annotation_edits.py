"""Edit annotations: keypoints set right, notes at frames, reviewed places."""

from __future__ import annotations

import numpy as np

from keypose.app.editor import actions as do
from keypose.app.editor import keyframe_edits
from keypose.app.editor.documents import ActionRefused, require_in_video
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.review.places import Place, review_of
from keypose.tracker.session.annotations import (
    Answer,
    DraftPlace,
    KeypointCorrection,
    Note,
    Reviewed,
)
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import Pixel

DECIMALS = 2


def correct_keypoint(state: EditorState, action: do.CorrectKeypoint) -> Session:
    """The keypoint is there, for sure."""
    uv = _in_video(state.doc.camera, action.at)
    return _with(state, action, KeypointCorrection(frame=action.frame, joint=action.joint, uv=uv))


def ignore_keypoint(state: EditorState, action: do.IgnoreKeypoint) -> Session:
    """Return what was found there does not count."""
    return _with(state, action, KeypointCorrection(frame=action.frame, joint=action.joint))


def restore_keypoint(state: EditorState, action: do.RestoreKeypoint) -> Session:
    """Restore the keypoint as it was found."""
    return _with(state, action, None)


def _with(
    state: EditorState,
    action: do.CorrectKeypoint | do.IgnoreKeypoint | do.RestoreKeypoint,
    correction: KeypointCorrection | None,
) -> Session:
    _require_counting(state.doc, action.joint)
    place = (action.frame, action.joint)
    others = [each for each in state.doc.keypoint_corrections if _frame_and_joint(each) != place]
    every = others if correction is None else [*others, correction]
    return state.doc.model_copy(
        update={"keypoint_corrections": tuple(sorted(every, key=_frame_and_joint))}
    )


def _frame_and_joint(each: KeypointCorrection) -> tuple[int, str]:
    return each.frame, each.joint


def _require_counting(doc: Session, joint: str) -> None:
    """Refused where tracking has no use for such a keypoint."""
    if doc.surface is not None:
        raise ActionRefused("Keypoints are found in a video, not in surfaces.")
    if not len(points_on_body(doc.body, [joint]).indices):
        raise ActionRefused(f"This body has no keypoint {part_label(joint).lower()}.")


def _in_video(camera: Camera, at: Pixel) -> Pixel:
    """Convert from pixels of the main view, whose lens is ideal, to those of the video."""
    spot = np.array(at)
    if camera.is_distorted:
        spot = camera.project(camera.without_distortion().back_project(spot, 1.0))
    if not np.isfinite(spot).all():
        raise ActionRefused("The lens shows nothing there.")
    u, v = spot.round(DECIMALS).tolist()
    return u, v


def set_note(state: EditorState, action: do.SetNote) -> Session:
    """One more note, or other words for the one at this frame."""
    frame = require_in_video(state, action.frame)
    known = _at(state, frame)
    text = action.text.strip()
    note = Note(frame=frame) if known is None else known
    return _with_note(state, frame, note.model_copy(update={"text": text}))


def move_note(state: EditorState, action: do.MoveNote) -> Session:
    """A note at another frame."""
    note, to = _require(state, action.frame), require_in_video(state, action.to)
    if to == action.frame:
        return state.doc
    if _at(state, to) is not None:
        raise ActionRefused(f"Frame {to} has a note already.")
    return _with_note(state, action.frame, note.model_copy(update={"frame": to}))


def delete_note(state: EditorState, action: do.DeleteNote) -> Session:
    """One note fewer."""
    _require(state, action.frame)
    return _with_note(state, action.frame, None)


def _with_note(state: EditorState, instead_of: int, note: Note | None) -> Session:
    """Put this note instead of the one at a frame, sorted by frame."""
    others = [other for other in state.doc.notes if other.frame != instead_of]
    notes = [*others, *([] if note is None else [note])]
    return state.doc.model_copy(update={"notes": tuple(sorted(notes, key=lambda n: n.frame))})


def _at(state: EditorState, frame: int) -> Note | None:
    return next((note for note in state.doc.notes if note.frame == frame), None)


def _require(state: EditorState, frame: int) -> Note:
    note = _at(state, frame)
    if note is None:
        raise ActionRefused(f"Frame {frame} has no note.")
    return note


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
    raise ActionRefused(f"There is nothing left to review at frame {frame}.")


def _answered(doc: Session, place: Place, answer: Answer) -> Session:
    """Put an answer in place of older ones about the same part and frames."""
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
