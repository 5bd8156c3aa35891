"""The tables of the rigs, `tables/*.json`, read.

A row is a bone. In its words `{}` stands for the side as the rig writes it, and `{side}`, `{other}`
for `left`, `right`: such a row is two bones. Of several parts or places the first one counts that
the body has.

    title                       of the rig
    prefix                      of every bone's name
    sides                       how the rig writes left and right
    arms_below_horizontal_deg   of the rest pose: 0 is T, 45 is A
    axes                        which axis of a bone points along it, and which one at rest, as
                                nearly as that allows, forward, backward, up or down:
                                ["y", "z", "forward"]. Left out: at rest all bones are parallel to
                                the world
    mirrored                    the axes of the right side are those of the left one mirrored, each
                                reversed, as programs mirror behaviour
    bones: name, parent
           part                 of the body with which it turns; left out where it stands still
           at                   where it begins in the rest pose: joints and landmarks by weights
                                that add up to 1; left out: at its part's joint
           axes                 where they are others than the rig's
"""

from __future__ import annotations

import json
from functools import cache
from importlib import resources
from typing import Annotated, Final, Literal, Self, TypeAlias

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

Axis: TypeAlias = Literal["x", "y", "z", "-x", "-y", "-z"]
Direction: TypeAlias = Literal["forward", "backward", "up", "down"]
Axes: TypeAlias = tuple[Axis, Axis, Direction]
Place: TypeAlias = dict[str, float]

SIDES: Final = ("left", "right")
_FILES: Final = {"metahuman": "ue5"}
"""Rigs whose bones are called as another one's."""


def _several(value: object) -> object:
    return (value,) if isinstance(value, str) else value


class Row(BaseModel):
    """One bone; `side` is left, right, or empty in the middle."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    parent: str | None = None
    part: Annotated[tuple[str, ...], BeforeValidator(_several)] = ()
    at: tuple[Place, ...] = ()
    axes: Axes | None = None
    side: Literal["", "left", "right"] = ""

    @model_validator(mode="after")
    def _weights_add_up(self) -> Self:
        for place in self.at:
            if abs(sum(place.values()) - 1.0) > 1e-9:
                raise ValueError(f"{self.name}: the weights of a place add up to 1")
        return self


class Table(BaseModel):
    """One rig's rows as in its file."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    title: str
    prefix: str = ""
    sides: tuple[str, str] = SIDES
    arms_below_horizontal_deg: float
    axes: Axes | None = None
    mirrored: bool = False
    bones: Annotated[tuple[Row, ...], Field(min_length=1)]

    def rows(self) -> tuple[Row, ...]:
        """A row for every bone, parents before children, with its whole name and its axes."""
        return tuple(side_row for row in self.bones for side_row in self._both(row))

    def _both(self, row: Row) -> list[Row]:
        if "{}" not in row.name:
            return [self._row(row, 0, "")]
        return [self._row(row, i, SIDES[i]) for i in range(2)]

    def _row(self, row: Row, i: int, side: str) -> Row:
        ours = {"{}": self.sides[i], "{side}": SIDES[i], "{other}": SIDES[1 - i]}

        def spelt(text: str) -> str:
            for mark, word in ours.items():
                text = text.replace(mark, word)
            return text

        return Row(
            name=self.prefix + spelt(row.name),
            parent=None if row.parent is None else self.prefix + spelt(row.parent),
            part=tuple(map(spelt, row.part)),
            at=tuple({spelt(name): share for name, share in place.items()} for place in row.at),
            axes=row.axes or self.axes,
            side=side,  # type: ignore[arg-type]
        )


@cache
def table_of(rig: str) -> Table:
    """The table of a rig other than the body's own."""
    folder = resources.files("keypose.tracker.formats.rigs") / "tables"
    text = (folder / f"{_FILES.get(rig, rig)}.json").read_text("utf-8")
    return Table.model_validate(json.loads(text))
