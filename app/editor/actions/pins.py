"""Pins and the floor."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from keypose.app.editor.actions.message import Edit, Message, Metres, Spot
from keypose.tracker.body.body import Name, Point
from keypose.tracker.session.settings import FrameIndex

PinIndex: TypeAlias = Annotated[int, Field(ge=0, le=1000)]
Landmarks: TypeAlias = Annotated[tuple[Name, ...], Field(max_length=20)]


class SetPin(Edit):
    """A part pinned at a frame, and over the frames around it at which it stands still.

    first, last: these frames instead.  landmarks: of the part, its heel and toe where left out and
    it has them, else its joint.  point_m: a point in the part's frame instead, metres; corner: the
    corner of the part that is seen nearest to these pixels of the camera's view.
    floor: it stands on the floor, which is laid under it where nobody knows its height.
    """

    do: Literal["set_pin"] = "set_pin"
    part: Name
    frame: FrameIndex
    first: FrameIndex | None = None
    last: FrameIndex | None = None
    landmarks: Landmarks | None = None
    point_m: Point | None = None
    corner: Spot | None = None
    floor: bool = False


class ChangePin(Edit):
    """Fields that are left out stay. An end that would run into another pin of the same points
    stops there; both ends moved by as much move the pin."""

    do: Literal["change_pin"] = "change_pin"
    index: PinIndex
    first: FrameIndex | None = None
    last: FrameIndex | None = None
    landmarks: Landmarks | None = None
    floor: bool | None = None


class DeletePin(Edit):
    do: Literal["delete_pin"] = "delete_pin"
    index: PinIndex


class SplitPin(Edit):
    """Two pins instead of one, the second from this frame on."""

    do: Literal["split_pin"] = "split_pin"
    index: PinIndex
    frame: FrameIndex


class AcceptPins(Edit):
    """The proposed pins of a part, or of a part from a frame on; all where neither is named."""

    do: Literal["accept_pins"] = "accept_pins"
    part: Name | None = None
    first: FrameIndex | None = None


class DismissPins(Message):
    """The proposed pins, as for AcceptPins, are not shown until others are proposed."""

    do: Literal["dismiss_pins"] = "dismiss_pins"
    part: Name | None = None
    first: FrameIndex | None = None


class Floor(Edit):
    """The floor's height along up from the camera, or that of the pinned feet, or of a part as it
    stands at the present frame; none of them: it is not known."""

    do: Literal["floor"] = "floor"
    height_m: Metres | None = None
    pinned_feet: bool = False
    under: Name | None = None


Pinning: TypeAlias = SetPin | ChangePin | DeletePin | SplitPin | AcceptPins | Floor
