"""Where one looks and what is shown."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, FiniteFloat

from keypose.app.editor.actions.message import Message
from keypose.app.editor.actions.pins import DismissPins
from keypose.app.editor.actions.poses import CopyPose
from keypose.tracker.body.body import Name
from keypose.tracker.session.settings import FrameIndex


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
