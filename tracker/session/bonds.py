"""Bonds: a point of one part that meets a point of another over a range of frames, such as a hand
on a shoulder, a racket in a hand, or two hands on one club."""

from __future__ import annotations

import operator
from collections.abc import Mapping, Sequence
from typing import Annotated, Literal, Self, TypeAlias

from pydantic import Field, model_validator

from keypose.tracker.body.body import Body, Name, Point
from keypose.tracker.session.settings import FrameIndex, Plain, SceneId

Moves: TypeAlias = Literal["both", "holder", "held"]


class BondEnd(Plain):
    """A point of one part of a body of the session."""

    body: SceneId
    part: Name
    point_m: Point = Field(description="In the part's frame, metres.")


class Bond(Plain):
    """Two points that meet from one frame to another, both included."""

    holder: BondEnd
    held: BondEnd
    first_frame: FrameIndex
    last_frame: FrameIndex
    moves: Moves = Field(
        default="both",
        exclude_if="both".__eq__,
        description="Which of the two is moved to the other where they were tracked apart; left "
        "out where both are: each the less, the nearer a keyframe of its own is.",
    )

    @model_validator(mode="after")
    def _is_between_two(self) -> Self:
        if self.last_frame < self.first_frame:
            raise ValueError("bonds: last_frame must not be before first_frame")
        if (self.holder.body, self.holder.part) == (self.held.body, self.held.part):
            raise ValueError(f"bonds: {self.holder.part!r} cannot hold itself")
        return self

    @property
    def span(self) -> tuple[int, int]:
        return self.first_frame, self.last_frame

    @property
    def bodies(self) -> tuple[str, str]:
        """The ids of the bodies whose points they are, which may be one."""
        return self.holder.body, self.held.body

    @property
    def ends(self) -> tuple[BondEnd, BondEnd]:
        return self.holder, self.held

    def overlaps(self, span: tuple[int, int]) -> bool:
        """Whether it holds over more than an end of a span."""
        return self.first_frame < span[1] and span[0] < self.last_frame


BondList = Annotated[
    tuple[Bond, ...],
    Field(
        default=(),
        exclude_if=operator.not_,
        description="Points of bodies that meet, such as a hand on a handle.",
    ),
]


def require_bonds(bonds: Sequence[Bond], bodies: Mapping[str, Body], frame_count: int) -> None:
    """ValueError in one sentence unless bonds join parts of the bodies that there are, within the
    video.

    bodies: by their ids.
    """
    for bond in bonds:
        for end in bond.ends:
            if end.body not in bodies:
                raise ValueError(f"bonds: there is no body of the id {end.body!r}")
            part_names = bodies[end.body].names
            if end.part not in part_names:
                raise ValueError(
                    f"bonds: {end.part!r} is no part of the body {end.body!r}; its parts are "
                    f"{', '.join(part_names)}"
                )
        if bond.last_frame >= frame_count:
            raise ValueError(
                f"bonds: frame {bond.last_frame} is beyond the video, whose frames are 0 to "
                f"{frame_count - 1}"
            )
