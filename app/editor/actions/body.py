"""Change the body, the camera, what is up, the floor and pins."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, FiniteFloat

from keypose.app.editor.actions.message import Edit, Message, Metres, Spot
from keypose.tracker.body.body import Body, Dof, Name, Point
from keypose.tracker.session.settings import FrameIndex

Centimetres: TypeAlias = Annotated[FiniteFloat, Field(ge=-1e6, le=1e6)]


class Shape(Edit):
    """A part of another shape, about as large."""

    do: Literal["shape"] = "shape"
    part: Name
    kind: Annotated[str, Field(max_length=40)]


class Size(Edit):
    do: Literal["size"] = "size"
    part: Name
    key: Annotated[str, Field(max_length=40)]
    cm: Centimetres


class Joint(Edit):
    do: Literal["joint"] = "joint"
    part: Name
    x: Centimetres | None = None
    y: Centimetres | None = None
    z: Centimetres | None = None


class Height(Edit):
    do: Literal["height"] = "height"
    cm: Centimetres


class Preset(Edit):
    do: Literal["preset"] = "preset"
    name: Name


class SetBody(Edit):
    """A body of one's own, as in its file."""

    do: Literal["body"] = "body"
    body: Body


class AddPart(Edit):
    """One more part, at the far end of another."""

    do: Literal["add_part"] = "add_part"
    parent: Name
    name: Name


class DeletePart(Edit):
    """A part and all that hangs on it."""

    do: Literal["delete_part"] = "delete_part"
    part: Name


class RenamePart(Edit):
    do: Literal["rename_part"] = "rename_part"
    part: Name
    name: Name


class ResetBody(Edit):
    do: Literal["reset_body"] = "reset_body"


class Clavicles(Edit):
    """Whether shoulders move on the chest."""

    do: Literal["clavicles"] = "clavicles"
    on: bool


class Tracked(Edit):
    """Which motions of a part the tracker estimates."""

    do: Literal["tracked"] = "tracked"
    part: Name
    dofs: Annotated[tuple[Dof, ...], Field(max_length=6)]


Shaping: TypeAlias = (
    Shape
    | Size
    | Joint
    | Height
    | Preset
    | SetBody
    | AddPart
    | DeletePart
    | RenamePart
    | ResetBody
    | Clavicles
    | Tracked
)


class Intrinsics(Edit):
    do: Literal["camera"] = "camera"
    fx: FiniteFloat | None = None
    fy: FiniteFloat | None = None
    cx: FiniteFloat | None = None
    cy: FiniteFloat | None = None


class FieldOfView(Edit):
    do: Literal["field_of_view"] = "field_of_view"
    deg: Annotated[FiniteFloat, Field(ge=1, le=170)]


class Lens(Edit):
    """The lens that shows as much on 35 mm film, and who says so; without `mm` a guess.

    bent: whether it bends straight edges, as an action camera's does; left out, as before.
    """

    do: Literal["lens"] = "lens"
    mm: Annotated[FiniteFloat, Field(ge=4, le=2000)] | None = None
    known: Literal["person", "file", "guess"] = "person"
    bent: bool | None = None


class Distortion(Edit):
    do: Literal["distortion"] = "distortion"
    k1: FiniteFloat | None = None
    k2: FiniteFloat | None = None
    p1: FiniteFloat | None = None
    p2: FiniteFloat | None = None
    k3: FiniteFloat | None = None


class Vertical(Edit):
    """A line drawn on the picture along something upright, in pixels."""

    do: Literal["vertical"] = "vertical"
    a: Spot
    b: Spot


class Horizon(Edit):
    """A line drawn on the picture where level ground ends far away, in pixels; its ends may lie
    beside the picture. The floor comes under the pinned feet, or the lower one at this frame."""

    do: Literal["horizon"] = "horizon"
    a: Spot
    b: Spot


class UpFromFeet(Edit):
    """Up so that the pinned feet stand level."""

    do: Literal["up_from_feet"] = "up_from_feet"


class ResetUp(Edit):
    do: Literal["reset_up"] = "reset_up"


Filming: TypeAlias = (
    Intrinsics | FieldOfView | Lens | Distortion | Vertical | Horizon | UpFromFeet | ResetUp
)


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
