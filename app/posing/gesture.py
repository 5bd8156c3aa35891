"""A drag of the pointer as the page sends it, the pose prepared for it, and its result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, Self, TypeAlias

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, model_validator

from keypose.app.posing.limits import (
    JointRange,
    box_of,
    fitting,
    nearest_within,
    range_of,
    resting_rotation,
)
from keypose.app.posing.vectors import unit
from keypose.tracker.body.body import Body, Name
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, nearest_rotation
from keypose.tracker.session.settings import SceneId

Axis: TypeAlias = Literal["x", "y", "z"]
ViewOfPage: TypeAlias = Literal["main", "top", "side", "front", "free", "film"]
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
    """What happens in a view. eye: of the free one, which alone has one. film: whose picture the
    view of another film shows, by the id of its view in the session."""

    view: ViewOfPage
    eye: Eye | None = None
    film: SceneId | None = None

    @model_validator(mode="after")
    def _says_from_where_it_is_seen(self) -> Self:
        if (self.view == "free") != (self.eye is not None):
            raise ValueError("an eye goes with the free view, and only with it")
        if (self.view == "film") != (self.film is not None):
            raise ValueError("a film goes with the view of another film, and only with it")
        return self


class Gesture(InView):
    """A drag from where the pointer went down to where it is now, in the view's coordinates.

    snap: steps of 5° or 1 cm.  free: joint limits do not count.  axis: only along or about this
    axis.  depth: up and down in the view mean farther and nearer; that of another film goes along
    the first one's line of sight.  carry: what would stay in its place goes along, unless it is
    pinned.
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


@dataclass(frozen=True, eq=False)
class GestureContext:
    """The pose before a gesture.

    Ts_camera_part: (P, 4, 4).
    limits_on:      whether joint limits count.
    posed:          the pose whose angles that are beyond a limit may stay there: the one before the
                    gesture.
    """

    skeleton: Skeleton
    pose: Pose
    Ts_camera_part: Array
    limits_on: bool
    posed: Pose

    @classmethod
    def of(
        cls, skeleton: Skeleton, pose: Pose, limits_on: bool, posed: Pose | None = None
    ) -> GestureContext:
        """posed: where the pose is one in the midst of a gesture, that before it."""
        Ts = pose_transforms(skeleton, pose)
        return cls(skeleton, pose, Ts, limits_on, pose if posed is None else posed)

    def joint(self, part: int) -> Array:
        """(3,) a part's joint in the camera frame."""
        return self.Ts_camera_part[part, :3, 3]

    def R_camera_part(self, part: int) -> Array:
        """(3, 3)."""
        return self.Ts_camera_part[part, :3, :3]

    def R_camera_parent(self, part: int) -> Array:
        """(3, 3); the camera itself for the root."""
        parent = int(self.skeleton.parents[part])
        return np.eye(3) if parent < 0 else self.Ts_camera_part[parent, :3, :3]

    def point(self, name: str) -> tuple[int, Array]:
        """A joint or landmark by name: the part it is fixed to, and where (3,) in its frame."""
        body = self.skeleton.body
        if name in body.names:
            return body.index(name), np.zeros(3)
        for i, part in enumerate(body.parts):
            if name in part.landmarks:
                return i, np.array(part.landmarks[name])
        raise KeyError(name)

    def placed(self, part: int, p_part: Array) -> Array:
        """(3,) a point of a part in the camera frame."""
        T = self.Ts_camera_part[part]
        return np.asarray(T[:3, :3] @ p_part + T[:3, 3])

    def joint_range(self, part: int) -> JointRange | None:
        """The limits that count for a part in this gesture."""
        allowed = range_of(self.skeleton.body.parts[part]) if self.limits_on else None
        return None if allowed is None else allowed.widened(self.posed.Rs_parent_part[part])

    def allowed(self, part: int, R_parent_part: Array) -> Array:
        """The nearest rotation that the limits of the part allow."""
        return nearest_within(R_parent_part, self.joint_range(part))

    def resting_direction(self, part: int, p_part_tip: Array) -> Array:
        """(3,) where a limb that begins at this part points in the middle of its joint's range.

        Unit vector in the camera frame. p_part_tip: the limb's end in the rest pose, from the
        part's joint. Without limits it is where the limb points at rest.
        """
        R = resting_rotation(self.skeleton.body.parts[part])
        return unit(self.R_camera_parent(part) @ (R @ p_part_tip))

    def turned(self, rotations: dict[int, Array]) -> Pose:
        """The pose with other rotations of some parts in their parents' frames."""
        Rs = self.pose.Rs_parent_part.copy()
        for part, R in rotations.items():
            Rs[part] = nearest_rotation(R)
        return Pose(Rs, self.pose.p_camera_root)

    def angles(self, part: int) -> Array:
        """The part's angles [x, y, z] (3,), radians, inside its limits where they can be."""
        box = box_of(self.skeleton.body.parts[part])
        return fitting(self.pose.Rs_parent_part[part], box)
