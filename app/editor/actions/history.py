"""Undo, redo and the ends of gestures."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from keypose.app.editor.actions.message import Message, Stroke
from keypose.tracker.session.history import MOST_STEPS

StepCount: TypeAlias = Annotated[int, Field(ge=0, le=MOST_STEPS)]


class Undo(Message):
    do: Literal["undo"] = "undo"


class Redo(Message):
    do: Literal["redo"] = "redo"


class GoToStep(Message):
    """Undo or redo, until so many steps are done. of: how many there are in all, as the page knows
    it; other ones may have been made meanwhile."""

    do: Literal["go_to_step"] = "go_to_step"
    done: StepCount
    of: StepCount


class EndStroke(Message):
    do: Literal["end_stroke"] = "end_stroke"
    stroke: Stroke


class CancelStroke(Message):
    do: Literal["cancel_stroke"] = "cancel_stroke"
    stroke: Stroke


Rewinding: TypeAlias = Undo | Redo | GoToStep | EndStroke | CancelStroke
