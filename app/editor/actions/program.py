"""Undo and redo, look elsewhere, open and save sessions."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, FiniteFloat

from keypose.app.editor.actions.body import DismissPins
from keypose.app.editor.actions.message import Edit, Message, Stroke
from keypose.app.editor.actions.posing import CopyPose
from keypose.tracker.body.body import Name
from keypose.tracker.session.history import MOST_STEPS
from keypose.tracker.session.schema import Title
from keypose.tracker.session.settings import FrameIndex

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


class Go(Message):
    do: Literal["go"] = "go"
    frame: FrameIndex


class Select(Message):
    do: Literal["select"] = "select"
    part: Name | None = None


class Show(Message):
    """How the body is drawn over the picture, and by what an observed surface is coloured."""

    do: Literal["display"] = "display"
    mode: Literal["wire", "solid", "both"] | None = None
    opacity: Annotated[FiniteFloat, Field(ge=0, le=1)] | None = None
    ghosts: bool | None = None
    trail: bool | None = None
    floor: bool | None = None
    tint: Literal["clay", "contact", "photo", "distance"] | None = None


class Live(Message):
    do: Literal["live"] = "live"
    on: bool


class Limits(Message):
    do: Literal["limits"] = "limits"
    on: bool


class Axes(Message):
    do: Literal["axes"] = "axes"
    frame: Literal["part", "parent", "view"]


class Link(Message):
    """Whether sizes of left and right change together."""

    do: Literal["link"] = "link"
    on: bool


class BeginGuide(Message):
    """The guide through the first pose once more: none of its steps is done."""

    do: Literal["begin_guide"] = "begin_guide"


Looking: TypeAlias = (
    Go | Select | Show | Live | Limits | Axes | Link | BeginGuide | CopyPose | DismissPins
)


SessionId: TypeAlias = Annotated[str, Field(pattern=r"^[0-9a-f]{16}$")]
"""Of a session among the recent ones, or of one in the trash."""


class SaveAgain(Message):
    do: Literal["save_again"] = "save_again"


class Rename(Edit):
    """What a person calls the open session; empty: as its folder is called."""

    do: Literal["rename"] = "rename"
    title: Title


class RenameSession(Message):
    """The same of any recent session."""

    do: Literal["rename_session"] = "rename_session"
    id: SessionId
    title: Title


class DuplicateSession(Message):
    """A copy beside it; its video is not copied."""

    do: Literal["duplicate_session"] = "duplicate_session"
    id: SessionId


class DeleteSession(Message):
    """To the trash of the workspace; its video stays where it is."""

    do: Literal["delete_session"] = "delete_session"
    id: SessionId


class RestoreSession(Message):
    """Back from the trash; `open` where it was deleted while it was open."""

    do: Literal["restore_session"] = "restore_session"
    id: SessionId
    open: bool = False


class Close(Message):
    do: Literal["close"] = "close"


class Open(Message):
    do: Literal["open"] = "open"
    kind: Literal["recent", "file", "sample", "upload"]
    id: Annotated[str, Field(min_length=1, max_length=4096)]
    video: Annotated[str, Field(min_length=1, max_length=4096)] | None = Field(
        default=None, description="For a recent session whose video was moved: the file it is now."
    )


Shelving: TypeAlias = RenameSession | DuplicateSession | DeleteSession | RestoreSession
