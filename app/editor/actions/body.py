"""The body: its parts, their shapes, sizes and joints."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, FiniteFloat

from keypose.app.editor.actions.message import Edit
from keypose.tracker.body.body import Body, Dof, Name

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
