"""Pins: points of the body that stand at one place in space over a range of frames."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Annotated, Self

from pydantic import Field, model_validator

from keypose.tracker.body.body import Body, Name, Part, Point
from keypose.tracker.session.settings import FrameIndex, Plain


class Pin(Plain):
    """A part of the body held at one place, which is not known, from one frame to another.

    It is held by its joint, unless landmarks of it are named or a point is given: a whole foot by
    heel and toe, a box by a corner.
    """

    part: Name
    landmarks: tuple[Name, ...] = Field(
        default=(), exclude_if=operator.not_, description="Landmarks of the part that stand still."
    )
    point_m: Point | None = Field(
        default=None,
        exclude_if=operator.not_,
        description="A point in the part's frame that stands still, metres, instead of its joint.",
    )
    first_frame: FrameIndex
    last_frame: FrameIndex
    floor: bool = Field(default=False, description="Whether it stands on the floor.")

    @model_validator(mode="after")
    def _runs_forward(self) -> Self:
        if self.last_frame < self.first_frame:
            raise ValueError("pins: last_frame must not be before first_frame")
        if self.landmarks and self.point_m is not None:
            raise ValueError("pins: name landmarks or give point_m, not both")
        return self

    @property
    def span(self) -> tuple[int, int]:
        return self.first_frame, self.last_frame

    def points(self, body: Body) -> tuple[Point, ...]:
        """What stands still, metres in the part's frame: with two landmarks also the joint,
        or the part could turn about the line between them.
        """
        part = body.parts[body.index(self.part)]
        if self.point_m is not None:
            return (self.point_m,)
        named = tuple(part.landmarks[name] for name in self.landmarks)
        return named if len(named) == 1 else (*named, (0.0, 0.0, 0.0))

    def above_floor_m(self, body: Body, point: Point) -> float:
        """How high one of its points is above the floor that it stands on: of a whole foot,
        which stands flat, the joint is as far above its sole as at rest.
        """
        if len(self.landmarks) < 2:
            return 0.0
        sole = max(y for _, y, _ in self.points(body))
        return sole - point[1]

    def holds_sole(self, body: Body) -> bool:
        """Whether it holds heel or toe of a foot."""
        return bool(self.landmarks and sole_of(body.parts[body.index(self.part)]))

    def overlaps(self, pin: Pin) -> bool:
        """Whether both hold the same part at one frame."""
        within = self.first_frame <= pin.last_frame and pin.first_frame <= self.last_frame
        return within and self.part == pin.part and self._shares(pin)

    def _shares(self, pin: Pin) -> bool:
        """Heel and toe of one foot may be held over different ranges."""
        named = bool(self.landmarks and pin.landmarks)
        return not named or bool(set(self.landmarks) & set(pin.landmarks))


PinList = Annotated[
    tuple[Pin, ...],
    Field(
        default=(),
        exclude_if=operator.not_,
        description="Points of the body that stand still, such as a planted foot.",
    ),
]


def sole_of(part: Part) -> tuple[Name, ...]:
    """The landmarks heel and toe, by which a whole foot is held; of other parts none."""
    names = [name for end in ("heel", "toe") for name in part.landmarks if name.endswith(end)]
    return tuple(names) if len(names) == 2 else ()


def pins_within(pins: Sequence[Pin], span: tuple[int, int]) -> tuple[Pin, ...]:
    """The pins within a span, clipped to it; one that only touches it holds nothing there."""
    spans = [(max(pin.first_frame, span[0]), min(pin.last_frame, span[1])) for pin in pins]
    return tuple(
        pin.model_copy(update={"first_frame": first, "last_frame": last})
        for pin, (first, last) in zip(pins, spans, strict=True)
        if first < last
    )


def pins_apart(pins: Sequence[Pin]) -> tuple[Pin, ...]:
    """The pins, each after those before it that it overlaps: of motions that follow one another,
    the keyframe between them belongs to both.
    """
    separate: list[Pin] = []
    for pin in pins:
        ends = [earlier.last_frame for earlier in separate if earlier.overlaps(pin)]
        first = max(ends) + 1 if ends else pin.first_frame
        if first <= pin.last_frame:
            separate.append(pin.model_copy(update={"first_frame": first}))
    return tuple(separate)


def require_pins(pins: Sequence[Pin], body: Body, frame_count: int) -> None:
    """ValueError in one sentence unless pins hold what the body has, within the video, once."""
    for pin in pins:
        if pin.part not in body.names:
            raise ValueError(
                f"pins: {pin.part!r} is no part of the body; its parts are {', '.join(body.names)}"
            )
        landmarks = body.parts[body.index(pin.part)].landmarks
        missing = [name for name in pin.landmarks if name not in landmarks]
        if missing:
            has = f"it has {', '.join(landmarks)}" if landmarks else "it has none"
            raise ValueError(f"pins: {pin.part!r} has no landmark {missing[0]!r}; {has}")
        if pin.last_frame >= frame_count:
            raise ValueError(
                f"pins: frame {pin.last_frame} is beyond the video, whose frames are 0 to "
                f"{frame_count - 1}"
            )
    _require_apart(pins)


def _require_apart(pins: Sequence[Pin]) -> None:
    """Refuse pins that overlap: each is compared, in the order of their beginnings, with those that
    have not ended.
    """
    under_way: list[Pin] = []
    for pin in sorted(pins, key=lambda pin: pin.first_frame):
        under_way = [earlier for earlier in under_way if earlier.last_frame >= pin.first_frame]
        if any(pin.overlaps(earlier) for earlier in under_way):
            raise ValueError(
                f"pins: {pin.part!r} has two pins at frame {pin.first_frame}; one is allowed"
            )
        under_way.append(pin)
