"""The one place where an action changes the state: `update(state, action)`, a pure function."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from keypose.app.editor import actions as do
from keypose.app.editor import keyframe_edits, pin_edits, posing_edits
from keypose.app.editor.documents import ActionRefused, impossible, require_sound
from keypose.app.editor.edits import EDITS, label_of
from keypose.app.editor.posing_edits import with_corners
from keypose.app.editor.state import EditorState, Stroke
from keypose.app.posing import Readout
from keypose.tracker.errors import one_sentence
from keypose.tracker.session.history import History, Step
from keypose.tracker.session.schema import Session

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
        return replace(state, clipboard=keyframe_edits.copied_from(state, action.frames))
    if isinstance(action, do.BeginGuide):
        return state
    if isinstance(action, do.DismissPins):
        dismissed = pin_edits.named_proposals(state, action)
        return replace(state, dismissed_pins=(*state.dismissed_pins, *dismissed))
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
    if isinstance(action, do.GoToStep):
        return _go_to_step(state, action)
    undo = isinstance(action, do.Undo)
    found = state.history.undo(state.doc) if undo else state.history.redo(state.doc)
    if found is None:
        raise ActionRefused("Nothing to undo." if undo else "Nothing to redo.")
    return _at_step(state, *found, f"{action.do} {found[0].label}")


def _go_to_step(state: EditorState, action: do.GoToStep) -> EditorState:
    if action.of != state.history.total or action.done > action.of:
        raise ActionRefused("The history has changed meanwhile. Choose the step again.")
    way = list(state.history.way_to(state.doc, action.done))
    return _at_step(state, *way[-1], "go to the step") if way else state


def _at_step(state: EditorState, step: Step, history: History, what: str) -> EditorState:
    require_sound(state.doc, step.doc, what)
    changed = replace(state.with_doc(step.doc), history=history, frame=step.frame)
    return _still_there(changed)


def _is_under_way(state: EditorState, stroke: str) -> bool:
    return state.stroke is not None and state.stroke.name == stroke


def end_stroke(state: EditorState) -> EditorState:
    """End the gesture under way, if any, as one step of the history."""
    stroke = state.stroke
    if stroke is None:
        return state
    state = _without_stroke(state, stroke)
    if state.doc is stroke.before:
        return state
    if stroke.readout is not None:
        state = with_corners(state, stroke.readout.corners)
    return replace(state, history=state.history.after(stroke.before, stroke.label, stroke.frame))


def cancel_stroke(state: EditorState) -> EditorState:
    """Undo the gesture under way."""
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
    before = state if state.stroke is None else _before(state, state.stroke)
    if isinstance(action, do.PastePose):
        action = keyframe_edits.with_copied(state, action)
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
    changed = _still_there(replace(state.with_doc(doc), history=history))
    return changed if readout is None else with_corners(changed, readout.corners)


def _before(state: EditorState, stroke: Stroke) -> EditorState:
    return replace(state.with_doc(stroke.before), stroke=None)


def _changed(
    state: EditorState, before: EditorState, action: Any
) -> tuple[Session, Readout | None]:
    if isinstance(action, do.Drag):
        return posing_edits.drag_part(state, before, action)
    return EDITS[type(action)].apply(before, action), None


def _still_there(state: EditorState) -> EditorState:
    """A part that the body does not have any more is not selected any more."""
    gone = state.selected is not None and state.selected not in state.doc.body.names
    return replace(state, selected=None) if gone else state
