"""The one place where an action changes the state: `update(state, action)`, a pure function.

Here too: undo and redo, and what is looked at.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, FiniteFloat, ValidationError

from keypose.app.editor.carrying import with_carried
from keypose.app.editor.documents import ActionRefused, impossible, require_in_video, require_sound
from keypose.app.editor.message import Edit, Editing, Look, Rewind, StrokeName
from keypose.app.editor.posing import with_corners
from keypose.app.editor.state import EditorState, Stroke
from keypose.tracker.body.body import Name
from keypose.tracker.errors import one_sentence
from keypose.tracker.session.history import MOST_STEPS, History, Step
from keypose.tracker.session.settings import FrameIndex

REMEMBERED_STROKES = 50
"""Gestures of before, whose late messages do nothing."""
StepCount: TypeAlias = Annotated[int, Field(ge=0, le=MOST_STEPS)]


def update(state: EditorState, action: Editing) -> EditorState:
    """The state after an action; KeyposeError, in one sentence, when it cannot be done."""
    return _edit(state, action) if isinstance(action, Edit) else action.after(state)


# --- looking


class Go(Look):
    do: Literal["go"] = "go"
    frame: FrameIndex

    def after(self, state: EditorState) -> EditorState:
        return replace(end_stroke(state), frame=min(self.frame, state.frame_count - 1))


class Select(Look):
    do: Literal["select"] = "select"
    part: Name | None = None

    def after(self, state: EditorState) -> EditorState:
        if self.part is not None:
            state.doc.subject.body.index(self.part)
        return replace(state, selected=self.part)


class Show(Look):
    """How the body is drawn over the picture, and by what an observed surface is coloured."""

    do: Literal["display"] = "display"
    mode: Literal["wire", "solid", "both"] | None = None
    opacity: Annotated[FiniteFloat, Field(ge=0, le=1)] | None = None
    ghosts: bool | None = None
    trail: bool | None = None
    floor: bool | None = None
    background: bool | None = None
    tint: Literal["clay", "contact", "photo", "distance"] | None = None

    def after(self, state: EditorState) -> EditorState:
        return _displayed(state, **self.model_dump(exclude={"do"}, exclude_none=True))


class Switch(Look):
    """Whether it is tracked at once, joint limits count, or both sides' sizes change together."""

    do: Literal["live", "limits", "link"]
    on: bool

    def after(self, state: EditorState) -> EditorState:
        return _displayed(state, **{self.do: self.on})


class Axes(Look):
    do: Literal["axes"] = "axes"
    frame: Literal["part", "parent", "view"]

    def after(self, state: EditorState) -> EditorState:
        return _displayed(state, axes=self.frame)


class ShowAngle(Look):
    """Which joint's angle is charted, and which of its angles; none where left out."""

    do: Literal["joint_angle"] = "joint_angle"
    joint: Name | None = None
    angle: Name | Literal[""] = ""

    def after(self, state: EditorState) -> EditorState:
        return _displayed(state, joint=self.joint, angle=self.angle)


class BeginGuide(Look):
    """The guide through the first pose once more: none of its steps is done."""

    do: Literal["begin_guide"] = "begin_guide"

    def after(self, state: EditorState) -> EditorState:
        return state


def _displayed(state: EditorState, **changes: Any) -> EditorState:
    return replace(state, display=replace(state.display, **changes))


# --- history


class Undo(Rewind):
    do: Literal["undo"] = "undo"

    def after(self, state: EditorState) -> EditorState:
        state = end_stroke(state)
        return _at_neighbour(state, state.history.undo(state.doc), self.do)


class Redo(Rewind):
    do: Literal["redo"] = "redo"

    def after(self, state: EditorState) -> EditorState:
        state = end_stroke(state)
        return _at_neighbour(state, state.history.redo(state.doc), self.do)


class GoToStep(Rewind):
    """Undo or redo, until so many steps are done. of: how many there are in all, as the page knows
    it; other ones may have been made meanwhile."""

    do: Literal["go_to_step"] = "go_to_step"
    done: StepCount
    of: StepCount

    def after(self, state: EditorState) -> EditorState:
        state = end_stroke(state)
        if self.of != state.history.total or self.done > self.of:
            raise ActionRefused("The history has changed meanwhile. Choose the step again.")
        steps = list(state.history.way_to(state.doc, self.done))
        return _at_step(state, *steps[-1], "go to the step") if steps else state


class EndStroke(Rewind):
    do: Literal["end_stroke"] = "end_stroke"
    stroke: StrokeName

    def after(self, state: EditorState) -> EditorState:
        return end_stroke(state) if _is_under_way(state, self.stroke) else state


class CancelStroke(Rewind):
    do: Literal["cancel_stroke"] = "cancel_stroke"
    stroke: StrokeName

    def after(self, state: EditorState) -> EditorState:
        return cancel_stroke(state) if _is_under_way(state, self.stroke) else state


MESSAGES = (
    Go,
    Select,
    Show,
    Switch,
    Axes,
    ShowAngle,
    BeginGuide,
    Undo,
    Redo,
    GoToStep,
    EndStroke,
    CancelStroke,
)


def _at_neighbour(
    state: EditorState, neighbour: tuple[Step, History] | None, do: str
) -> EditorState:
    if neighbour is None:
        raise ActionRefused(f"Nothing to {do}.")
    return _at_step(state, *neighbour, f"{do} {neighbour[0].label}")


def _at_step(state: EditorState, step: Step, history: History, action: str) -> EditorState:
    require_sound(state.doc, step.doc, action)
    changed = replace(state.with_doc(step.doc), history=history, frame=step.frame)
    return still_there(changed)


def _is_under_way(state: EditorState, stroke: str | None) -> bool:
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
    return still_there(_without_stroke(state.with_doc(stroke.before), stroke))


def _without_stroke(state: EditorState, stroke: Stroke) -> EditorState:
    return replace(state, stroke=None, over=(*state.over, stroke.name)[-REMEMBERED_STROKES:])


# --- edits


def _edit(state: EditorState, action: Edit) -> EditorState:
    if action.stroke in state.over:
        return state  # it would be applied a second time, to what it has led to
    for frame in action.frames_named:
        require_in_video(state.doc, frame)
    if not _is_under_way(state, action.stroke):
        state = end_stroke(state)
    before = state
    if state.stroke is not None:
        before = replace(state.with_doc(state.stroke.before), stroke=None)
    label = action.label(before)
    try:
        doc, readout = action.change(state, before)
    except ValidationError as error:
        raise impossible(label, one_sentence(error)) from None
    doc = with_carried(before, doc)
    if action.stroke is not None:
        require_sound(before.doc, doc, label)
        stroke = Stroke(action.stroke, before.doc, label, state.frame, readout)
        return still_there(replace(state.with_doc(doc), stroke=stroke))
    if doc is state.doc or doc == state.doc:
        return state
    changed = still_there(state.with_step(doc, label))
    return changed if readout is None else with_corners(changed, readout.corners)


def still_there(state: EditorState) -> EditorState:
    """A part that the body does not have any more is not selected any more."""
    gone = state.selected is not None and state.selected not in state.doc.subject.body.names
    return replace(state, selected=None) if gone else state
