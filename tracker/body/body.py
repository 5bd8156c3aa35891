"""The articulated body: a tree of rigid parts, their shapes, joints and degrees of freedom.

A part's frame has its origin at the joint to its parent; `joint_m` is that joint in the parent's
frame. With all rotations at identity the body is in its rest pose, every part's axes parallel to
the camera's: x to the picture's right, y down, z away from the camera.  (DRIFT §2.1, §4, Table 1)
"""

from __future__ import annotations

import json
import math
import operator
from collections.abc import Iterable
from importlib import resources
from pathlib import Path
from typing import Annotated, Literal, Self, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError, model_validator

from keypose.tracker.body.preset_names import PRESETS
from keypose.tracker.body.shapes import Point as Point
from keypose.tracker.body.shapes import Shape
from keypose.tracker.errors import BodyError, one_sentence
from keypose.tracker.files import read_regular

Dof: TypeAlias = Literal["tx", "ty", "tz", "rx", "ry", "rz"]
Name: TypeAlias = Annotated[str, Field(min_length=1, max_length=60, pattern=r"^[^\x00-\x1f/\\]+$")]

ALL_DOFS: tuple[Dof, ...] = ("tx", "ty", "tz", "rx", "ry", "rz")
ROTATIONS: tuple[Dof, ...] = ("rx", "ry", "rz")

Angle: TypeAlias = Annotated[FiniteFloat, Field(ge=-360, le=360)]
Limits: TypeAlias = dict[Literal["x", "y", "z"], tuple[Angle, Angle]]
LEAST_TOWARD_COS = -0.9
"""Swings are not counted from a direction that lies nearly opposite to the part at rest."""

LARGEST_BODY_BYTES = 16 * 2**20


class Twist(BaseModel):
    """How far a part turns about its own length, its y axis: what a box of Euler angles as wide as
    a shoulder's does not show.

    Every rotation is a turn about the length, then the least turn of the length from `toward` to
    where it points. The twist of the rest pose is 0. Opposite to `toward` twist is not determined:
    `toward` is chosen so that the part cannot point there.
    """

    model_config = ConfigDict(frozen=True, extra="allow")

    range_deg: tuple[Angle, Angle] = Field(description="Lowest and highest twist, degrees.")
    toward: Point = Field(
        default=(0.0, 1.0, 0.0),
        description="Direction in the parent's frame that swings are counted from, of any length.",
    )

    @model_validator(mode="after")
    def _is_a_range_from_a_direction(self) -> Self:
        if self.range_deg[0] > self.range_deg[1]:
            raise ValueError("twist.range_deg must not fall, low first")
        length = math.hypot(*self.toward)
        if self.toward[1] <= LEAST_TOWARD_COS * length:
            raise ValueError("twist.toward must be a direction that does not point against y")
        return self


class Part(BaseModel):
    """One rigid part. `tracked` are the motions the tracker estimates for it (Table 1).

    The forearm and the shin keep rx, the hinge of elbow and knee. The upper arm and the thigh keep
    rx and rz, the two that swing the limb; ry would turn a round limb about its own length, which
    the picture hardly shows. The head keeps rx and ry, nodding and turning. The chest keeps all.
    Posing a keyframe is free in all three rotations of every part, whatever is tracked.
    """

    model_config = ConfigDict(frozen=True, extra="allow")

    name: Name
    parent: Name | None = None
    joint_m: Point = (0.0, 0.0, 0.0)
    shape: Shape
    tracked: tuple[Dof, ...] = ()
    landmarks: dict[Name, Point] = Field(
        default_factory=dict, description="Named points in the part's frame, such as a fingertip."
    )
    limits_deg: Limits = Field(
        default_factory=dict,
        description="Lowest and highest Euler angle about x, y, z (R = Qz·Qy·Qx), degrees, that "
        "posing keeps to, and the motion in space nearly; axes left out are free.",
    )
    twist: Twist | None = Field(
        default=None,
        description="How far it turns about its own length, kept as `limits_deg` are. A body saved "
        "without stays without, so that what was solved with it is the same motion.",
        exclude_if=operator.not_,
    )

    @model_validator(mode="after")
    def _moves_as_its_place_allows(self) -> Self:
        if len(set(self.tracked)) != len(self.tracked):
            raise ValueError(f"part {self.name!r} lists a tracked motion twice")
        if self.parent is not None and not set(self.tracked) <= set(ROTATIONS):
            raise ValueError(f"part {self.name!r} has a parent and may only track rx, ry, rz")
        for axis, (low, high) in self.limits_deg.items():
            if low > high:
                raise ValueError(f"part {self.name!r}: limits_deg.{axis} must not fall, low first")
        return self


class Body(BaseModel):
    """A tree of parts, parents before children, the root first.

    Its validation errors name the part and say what is allowed.
    """

    model_config = ConfigDict(frozen=True, extra="allow")

    name: Name
    parts: Annotated[tuple[Part, ...], Field(min_length=1, max_length=120)]
    mirror_pairs: tuple[tuple[Name, Name], ...] = ()
    source: str = Field(default="", description="Where the sizes come from.")

    @model_validator(mode="after")
    def _is_one_tree(self) -> Self:
        names = [part.name for part in self.parts]
        _require_unique(names)
        _require_parents(self.parts)
        _require_no_cycle({part.name: part.parent for part in self.parts})
        _require_order(self.parts)
        _require_pairs(self.mirror_pairs, set(names))
        return self

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(part.name for part in self.parts)

    def index(self, name: str) -> int:
        """Index of the part of this name; BodyError lists the names there are."""
        for place, part in enumerate(self.parts):
            if part.name == name:
                return place
        part_names = ", ".join(self.names)
        raise BodyError(f"The body has no part {name!r}; its parts are {part_names}.")

    def with_part(self, part: Part) -> Body:
        """This body with the part of the same name exchanged."""
        place = self.index(part.name)
        return self.replaced((*self.parts[:place], part, *self.parts[place + 1 :]))

    def replaced(self, parts: Iterable[Part]) -> Body:
        """This body with other parts, validated."""
        return Body(**{**dict(self), "parts": tuple(parts)})

    def mirror_of(self, name: str) -> str:
        """The part on the other side, or the part itself where it has no pair."""
        self.index(name)
        for left, right in self.mirror_pairs:
            if name in (left, right):
                return right if name == left else left
        return name


def load_body(path: Path) -> Body:
    """Read a body from a JSON file; BodyError in one sentence when it is not one."""
    try:
        return Body.model_validate_json(read_regular(path, LARGEST_BODY_BYTES))
    except ValidationError as error:
        raise BodyError(f"{path.name}: {one_sentence(error)}") from None
    except OSError as error:
        raise BodyError(f"The body file {str(path)!r} cannot be read: {error.strerror}.") from None


def preset(name: str) -> Body:
    """One of the bodies that come with the product: see PRESETS."""
    if name not in PRESETS:
        raise BodyError(f"There is no body {name!r}; the presets are {', '.join(PRESETS)}.")
    text = (
        resources.files("keypose.tracker.body.presets").joinpath(f"{name}.json").read_text("utf-8")
    )
    return Body.model_validate(json.loads(text))


def _require_unique(names: list[str]) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"part {twice[0]!r} appears twice; every part needs a name of its own")


def _require_parents(parts: tuple[Part, ...]) -> None:
    names = {part.name for part in parts}
    for part in parts:
        if part.parent is not None and part.parent not in names:
            raise ValueError(f"part {part.name!r} has the parent {part.parent!r}, which is missing")
    roots = [part.name for part in parts if part.parent is None]
    if len(roots) > 1:
        raise ValueError(f"parts {', '.join(roots)} have no parent; exactly one root is allowed")


def _require_no_cycle(parent_of: dict[str, str | None]) -> None:
    for start in parent_of:
        name: str | None = start
        for _ in range(len(parent_of)):
            name = parent_of[name] if name is not None else None
        if name is not None:
            raise ValueError(f"part {start!r} is its own ancestor; parents must lead to a root")


def _require_order(parts: tuple[Part, ...]) -> None:
    names_before: set[str | None] = {None}
    for part in parts:
        if part.parent not in names_before:
            raise ValueError(f"part {part.name!r} stands before its parent {part.parent!r}")
        names_before.add(part.name)


def _require_pairs(pairs: tuple[tuple[str, str], ...], names: set[str]) -> None:
    paired: set[str] = set()
    for pair in pairs:
        for name in pair:
            if name not in names:
                raise ValueError(f"the mirror pair {pair} names {name!r}, which is not a part")
            if name in paired or pair[0] == pair[1]:
                raise ValueError(f"part {name!r} may stand in one mirror pair, beside another part")
            paired.add(name)
