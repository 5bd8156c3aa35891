"""Edits of the keyframes: added, removed, moved, copied along the time; part keyframes too."""

from __future__ import annotations

from keypose.app.editor import actions as do
from keypose.app.editor.documents import (
    as_soft_as,
    keyframe_of,
    require_before_camera,
    with_drafts,
    with_keyframes,
    with_part_keyframes,
    without,
)
from keypose.app.editor.key_range_edits import at_frame
from keypose.app.editor.part_edits import require_correctable
from keypose.app.editor.refusal import Refused
from keypose.app.editor.shown import find, shown_pose
from keypose.app.editor.state import EditorState
from keypose.tracker.session.keyframe import Keyframe, PartKeyframe
from keypose.tracker.session.schema import Session


def add_keyframe(state: EditorState, frame: int) -> Session:
    """Make the pose shown at a frame its keyframe, unless it is that already."""
    stands = shown_pose(state, frame)
    if stands.source == "keyframe":
        return state.doc
    pose = stands.pose
    require_before_camera(state.skeleton, pose)
    keyframe = keyframe_of(state.skeleton, pose, frame, state.times_s)
    keyframe = as_soft_as(find(state.doc.keyframes, frame), keyframe)
    doc = with_keyframes(state.doc, (*without(state.doc.keyframes, frame), keyframe))
    return with_drafts(doc, without(doc.drafts, frame))


def delete_keyframe(state: EditorState, frame: int) -> Session:
    """Without the keyframe at a frame, or its part keyframe."""
    return _without(state.doc, _require(state, frame))


def delete_draft(state: EditorState, frame: int) -> Session:
    """Without the draft at a frame."""
    if find(state.doc.drafts, frame) is None:
        raise Refused(f"Frame {frame} has no draft.")
    return with_drafts(state.doc, without(state.doc.drafts, frame))


def move_keyframe(state: EditorState, action: do.MoveKey) -> Session:
    """The keyframe at another frame."""
    if action.to == action.frame:
        return state.doc
    keyframe = _require(state, action.frame)
    _require_free(state, keyframe, action.to)
    doc = _keyed(_without(state.doc, keyframe), at_frame(state, keyframe, action.to))
    if isinstance(keyframe, PartKeyframe):
        return doc
    return doc.model_copy(update=doc.evidence.with_key_moved(action.frame, action.to))


def duplicate_keyframe(state: EditorState, action: do.DuplicateKey) -> Session:
    """The same pose as a keyframe of another frame, too."""
    keyframe = _require(state, action.frame)
    _require_free(state, keyframe, action.to)
    return _keyed(state.doc, at_frame(state, keyframe, action.to))


def _keyed(doc: Session, keyframe: Keyframe) -> Session:
    """With one more keyframe, in the place of what may be drafted there: that would hide it."""
    if isinstance(keyframe, PartKeyframe):
        doc = with_part_keyframes(doc, (*doc.part_keyframes, keyframe))
    else:
        doc = with_keyframes(doc, (*doc.keyframes, keyframe))
    return with_drafts(doc, without(doc.drafts, keyframe.frame))


def _without(doc: Session, keyframe: Keyframe) -> Session:
    if isinstance(keyframe, PartKeyframe):
        return with_part_keyframes(doc, without(doc.part_keyframes, keyframe.frame))
    return with_keyframes(doc, without(doc.keyframes, keyframe.frame))


def _require(state: EditorState, frame: int) -> Keyframe:
    found = find(state.doc.keyframes, frame) or find(state.doc.part_keyframes, frame)
    if found is None:
        raise Refused(f"Frame {frame} is not a keyframe.")
    return found


def _require_free(state: EditorState, keyframe: Keyframe, frame: int) -> None:
    """Refused where a keyframe cannot come to a frame."""
    if find(state.doc.keyframes, frame) or find(state.doc.part_keyframes, frame):
        raise Refused(f"Frame {frame} is already a keyframe. Delete it first.")
    if isinstance(keyframe, PartKeyframe):
        require_correctable(state, frame)
