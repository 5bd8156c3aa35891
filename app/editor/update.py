"""The one place where an action changes the state: `update(state, action)`, a pure function."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from app.editor import actions as do
from app.editor import (
    body_edits,
    camera_edits,
    keyframe_edits,
    posing_edits,
    surface_edits,
    tracking_edits,
)
from app.editor.documents import impossible, keyframe_of, require_sound
from app.editor.refusal import Refused
from app.editor.shown import shown
from app.editor.state import EditorState, Stroke
from app.posing import Readout, part_label
from app.posing.gesture import Surface
from tracker.errors import one_sentence
from tracker.session.schema import Session

REMEMBERED_STROKES = 50


def update(state: EditorState, action: do.Editing) -> EditorState:
    """The state after an action; KeyposeError, in one sentence, when it cannot be done."""
    if isinstance(action, do.Looking):
        return _look(state, action)
    if isinstance(action, do.Rewinding):
        return _rewind(state, action)
    return _edit(state, action)


def _look(state: EditorState, action: do.Looking) -> EditorState:
    if isinstance(action, do.Go):
        frame = min(action.frame, state.frame_count - 1)
        return replace(end_stroke(state), frame=frame)
    if isinstance(action, do.Select):
        if action.part is not None:
            state.doc.body.index(action.part)
        return replace(state, selected=action.part)
    if isinstance(action, do.CopyPose):
        pose = shown(state).pose
        copied = keyframe_of(state.skeleton, pose, state.frame, state.times_s)
        return replace(state, clipboard=copied)
    if isinstance(action, do.BeginGuide):
        return state
    return replace(state, display=replace(state.display, **_switches(action)))


def _switches(action: do.Show | do.Live | do.Limits | do.Axes | do.Link) -> dict[str, Any]:
    if isinstance(action, do.Show):
        return action.model_dump(exclude={"do"}, exclude_none=True)
    if isinstance(action, do.Axes):
        return {"axes": action.frame}
    return {action.do: action.on}


# --- history


def _rewind(state: EditorState, action: do.Rewinding) -> EditorState:
    if isinstance(action, do.EndStroke):
        return end_stroke(state) if _is_under_way(state, action.stroke) else state
    if isinstance(action, do.CancelStroke):
        return cancel_stroke(state) if _is_under_way(state, action.stroke) else state
    state = end_stroke(state)
    undo = isinstance(action, do.Undo)
    found = state.history.undone(state.doc) if undo else state.history.redone(state.doc)
    if found is None:
        raise Refused("There is nothing to undo." if undo else "There is nothing to redo.")
    step, history = found
    require_sound(state.doc, step.doc, f"{action.do} {step.label}")
    changed = replace(state.with_doc(step.doc), history=history, frame=step.frame)
    return _still_there(changed)


def _is_under_way(state: EditorState, stroke: str) -> bool:
    return state.stroke is not None and state.stroke.name == stroke


def end_stroke(state: EditorState) -> EditorState:
    """With the gesture under way, if any, made one step of the history."""
    stroke = state.stroke
    if stroke is None:
        return state
    state = _without_stroke(state, stroke)
    if state.doc is stroke.before:
        return state
    return replace(state, history=state.history.after(stroke.before, stroke.label, stroke.frame))


def cancel_stroke(state: EditorState) -> EditorState:
    """With the gesture under way taken back."""
    stroke = state.stroke
    if stroke is None:
        return state
    return _still_there(_without_stroke(state.with_doc(stroke.before), stroke))


def _without_stroke(state: EditorState, stroke: Stroke) -> EditorState:
    return replace(state, stroke=None, over=(*state.over, stroke.name)[-REMEMBERED_STROKES:])


# --- edits


def _edit(state: EditorState, action: Any) -> EditorState:
    if action.stroke in state.over:
        return state  # it would be applied a second time, to what it has led to
    if action.stroke is None or not _is_under_way(state, action.stroke):
        state = end_stroke(state)
    before = state if state.stroke is None else state.with_doc(state.stroke.before)
    label = label_of(action)
    try:
        doc, readout = _changed(state, before, action)
    except ValidationError as error:
        raise impossible(label, one_sentence(error)) from None
    require_sound(before.doc, doc, label)
    if action.stroke is not None:
        stroke = Stroke(action.stroke, before.doc, label, state.frame, readout)
        return _still_there(replace(state.with_doc(doc), stroke=stroke))
    if doc is state.doc or doc == state.doc:
        return state
    history = state.history.after(state.doc, label, state.frame)
    return _still_there(replace(state.with_doc(doc), history=history))


def _changed(
    state: EditorState, before: EditorState, action: Any
) -> tuple[Session, Readout | None]:
    if isinstance(action, do.Drag):
        return posing_edits.drag_part(state, before, action)
    return _HOW[type(action)](before, action), None


_HOW: dict[type, Callable[[EditorState, Any], Session]] = {
    do.Angles: posing_edits.set_angles,
    do.Root: posing_edits.set_root,
    do.Face: posing_edits.set_facing,
    do.ResetPart: posing_edits.reset_part,
    do.ResetPose: lambda state, _: posing_edits.reset_pose(state),
    do.Exchange: lambda state, _: posing_edits.swap_sides(state),
    do.PastePose: posing_edits.paste_pose,
    do.CopyKey: posing_edits.copy_key,
    do.TakeTracked: lambda state, _: posing_edits.take_tracked(state),
    do.KeyAngle: posing_edits.turn_key,
    do.AddKey: lambda state, action: keyframe_edits.add_keyframe(
        state, _in_video(state, action.frame)
    ),
    do.DeleteKey: lambda state, action: keyframe_edits.delete_keyframe(state, action.frame),
    do.MoveKey: lambda state, action: keyframe_edits.move_keyframe(
        _reaching(state, action.to), action
    ),
    do.DuplicateKey: lambda state, action: keyframe_edits.duplicate_keyframe(
        _reaching(state, action.to), action
    ),
    do.Size: body_edits.set_size,
    do.Joint: body_edits.set_joint,
    do.Height: body_edits.set_height,
    do.Preset: body_edits.set_preset,
    do.ResetBody: lambda state, _: body_edits.reset_body(state),
    do.Tracked: body_edits.set_tracked,
    do.Intrinsics: camera_edits.set_intrinsics,
    do.FieldOfView: camera_edits.set_fov,
    do.Distortion: camera_edits.set_distortion,
    do.Vertical: camera_edits.set_up,
    do.ResetUp: lambda state, _: camera_edits.reset_up(state),
    do.AddMask: tracking_edits.add_mask,
    do.ChangeMask: tracking_edits.change_mask,
    do.DeleteMask: tracking_edits.delete_mask,
    do.Settings: tracking_edits.set_settings,
    do.Observe: surface_edits.set_surface,
}


def _in_video(state: EditorState, frame: int) -> int:
    if frame >= state.frame_count:
        raise Refused(f"The video has the frames 0 to {state.frame_count - 1}.")
    return frame


def _reaching(state: EditorState, frame: int) -> EditorState:
    _in_video(state, frame)
    return state


def _still_there(state: EditorState) -> EditorState:
    """A part that the body does not have any more is not selected any more."""
    gone = state.selected is not None and state.selected not in state.doc.body.names
    return replace(state, selected=None) if gone else state


# --- what an edit is called


def label_of(action: Any) -> str:
    """What undo offers to take back: "turn right forearm"."""
    if isinstance(action, do.Drag):
        return _drag_label(action)
    verb, field = _LABELS[action.do]
    name = getattr(action, field, None) if field else None
    if name is None:
        return verb
    return f"{verb} {part_label(name).lower() if isinstance(name, str) else name}"


def _drag_label(action: do.Drag) -> str:
    handle = action.handle
    if isinstance(handle, Surface) and (handle.tool or action.tool) == "move":
        return "move the body"
    verbs = {"ring": "turn", "root": "move the body", "size": "resize", "surface": "turn"}
    verb = verbs.get(handle.kind, "move")
    name = getattr(handle, "part", None) or getattr(handle, "name", None)
    return verb if name is None else f"{verb} {part_label(name).lower()}"


_LABELS: dict[str, tuple[str, str | None]] = {
    "angles": ("turn", "part"),
    "root": ("move the body", None),
    "face": ("turn the body", None),
    "reset_part": ("reset", "part"),
    "reset_pose": ("reset the pose", None),
    "exchange": ("exchange left and right", None),
    "paste_pose": ("paste the pose", None),
    "copy_key": ("copy keyframe", "from_frame"),
    "take_tracked": ("take the tracked pose", None),
    "add_key": ("add keyframe", "frame"),
    "delete_key": ("delete keyframe", "frame"),
    "move_key": ("move keyframe", "frame"),
    "duplicate_key": ("copy keyframe", "frame"),
    "key_angle": ("turn", "part"),
    "size": ("resize", "part"),
    "joint": ("move the joint of", "part"),
    "height": ("height", None),
    "preset": ("body", "name"),
    "reset_body": ("back to the preset", None),
    "tracked": ("free to move", "part"),
    "camera": ("camera", None),
    "field_of_view": ("field of view", None),
    "distortion": ("distortion", None),
    "vertical": ("up direction", None),
    "reset_up": ("up direction", None),
    "add_mask": ("draw a mask", None),
    "change_mask": ("change a mask", None),
    "delete_mask": ("delete a mask", None),
    "settings": ("settings", None),
    "observe": ("surfaces", None),
}
