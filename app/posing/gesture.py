"""A drag of the pointer as the page sends it, and its result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, Self, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, model_validator

from keypose.tracker.body.body import Body, Name
from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.rotations import Array

Axis: TypeAlias = Literal["x", "y", "z"]
ViewOfPage: TypeAlias = Literal["main", "top", "side", "front", "free"]
AxesFrame: TypeAlias = Literal["part", "parent", "view"]
Tool: TypeAlias = Literal["rotate", "move", "ends"]
Coordinate: TypeAlias = Annotated[FiniteFloat, Field(ge=-1e6, le=1e6)]
Metres: TypeAlias = Annotated[FiniteFloat, Field(ge=-1e4, le=1e4)]
Spot: TypeAlias = tuple[Coordinate, Coordinate]


class _Plain(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Eye(_Plain):
    """From where the free view looks: as `eye_rotation`, from a place in the camera frame."""

    azimuth_deg: Annotated[FiniteFloat, Field(ge=-1e6, le=1e6)]
    elevation_deg: Annotated[FiniteFloat, Field(ge=-90, le=90)]
    at_m: tuple[Metres, Metres, Metres]


class Ring(_Plain):
    """A ring about a part's joint: turns the part about one axis."""

    kind: Literal["ring"]
    part: Name
    axis: Axis


class Root(_Plain):
    """The diamond that carries the whole body."""

    kind: Literal["root"]


class End(_Plain):
    """A hand, a foot or the head: the limb follows."""

    kind: Literal["end"]
    name: Name


class Middle(_Plain):
    """An elbow or a knee: its upper limb turns. A shoulder or a hip: the trunk follows."""

    kind: Literal["joint"]
    name: Name


class Surface(_Plain):
    """A part itself; the tool in hand says what becomes of it."""

    kind: Literal["surface"]
    part: Name
    tool: Tool | None = None


class SizeHandle(_Plain):
    """An end cap (a length), a rim (a radius or a width) or a joint's cross (key "joint")."""

    kind: Literal["size"]
    part: Name
    key: Annotated[str, Field(min_length=1, max_length=40)]
    side: Literal["joint", "end"] | None = None


class BoxCorner(_Plain):
    """A corner of a box, 0 to 7 as `Box.marks` has them: what was placed so stays there."""

    kind: Literal["box_corner"]
    part: Name
    index: Annotated[int, Field(ge=0, le=7)]


Handle: TypeAlias = Annotated[
    Ring | Root | End | Middle | Surface | SizeHandle | BoxCorner, Field(discriminator="kind")
]


class InView(_Plain):
    """What happens in a view. eye: of the free one, which alone has one."""

    view: ViewOfPage
    eye: Eye | None = None

    @model_validator(mode="after")
    def _free_view_has_an_eye(self) -> Self:
        if (self.view == "free") != (self.eye is not None):
            raise ValueError("an eye goes with the free view, and only with it")
        return self


class Gesture(InView):
    """A drag from where the pointer went down to where it is now, in the view's coordinates.

    snap: steps of 5° or 1 cm.  free: joint limits do not count.  axis: only along or about this
    axis.  depth: up and down in the view mean farther and nearer.  carry: what would stay in
    its place goes along, unless it is pinned.
    """

    model_config = ConfigDict(
        frozen=True, extra="forbid", validate_by_name=True, validate_by_alias=True
    )

    handle: Handle
    from_: Spot = Field(alias="from")
    at: Spot
    snap: bool = False
    free: bool = False
    axis: Axis | None = None
    depth: bool = False
    carry: bool = False
    tool: Tool = "rotate"


@dataclass(frozen=True, eq=False)
class Reach:
    """The sphere that an end cannot leave: centre (3,) in the camera frame."""

    centre: Array
    radius_m: float


@dataclass(frozen=True)
class PlacedCorner:
    """A corner of a box, and the pixel (u, v) of the main view where somebody put it."""

    part: str
    index: int
    uv: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Readout:
    """What to show beside the pointer: "Bend" "96.9°" "+14.5".

    axis, angle_rad: the turn since the gesture began, of rings and turned surfaces; give it back
    as `angle_before` with the next move, and turns beyond half a circle are counted on.
    unreached: names of the ends that were to stay and cannot.  corners: of a box, where they were
    put by this gesture and those before.
    """

    label: str
    value: str
    change: str = ""
    part: str | None = None
    axis: Axis | None = None
    angle_rad: float | None = None
    reach: Reach | None = None
    out_of_reach: bool = False
    depth_m: float | None = None
    unreached: tuple[str, ...] = ()
    corners: tuple[PlacedCorner, ...] = ()


@dataclass(frozen=True, eq=False)
class Posed:
    """What a gesture makes of a pose; `body` where it changed the body's sizes."""

    pose: Pose
    body: Body | None
    readout: Readout
