"""The camera and the up direction."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, FiniteFloat

from keypose.app.editor.actions.message import Edit, Spot


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
