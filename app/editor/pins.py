"""Edit pins: which points of the body stand still, and from when to when."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from keypose.app.editor.documents import ActionRefused, valid
from keypose.app.editor.floor import foot_height
from keypose.app.editor.message import Edit, Look, Message
from keypose.app.editor.pinned import (
    LEAST_FRAMES,
    corner_near,
    default_landmarks,
    open_proposals,
    range_to_pin,
    shares_points,
)
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label
from keypose.app.posing.gesture import Spot
from keypose.app.words.problems import named_frames
from keypose.tracker.body.body import Name, Point
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.schema import Session
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
    verb = "pin"
    target = "part"
    part: Name
    frame: FrameIndex
    first: FrameIndex | None = None
    last: FrameIndex | None = None
    landmarks: Landmarks | None = None
    point_m: Point | None = None
    corner: Spot | None = None
    floor: bool = False

    def apply(self, state: EditorState) -> Session:
        frame = min(self.frame, state.frame_count - 1)
        here = self._here(state, frame)
        _require_held(state, here)
        taken = next((pin for pin in state.doc.subject.pins if pin.overlaps(here)), None)
        if taken is not None:
            raise ActionRefused(f"{part_label(self.part)} is already pinned in {_frames(taken)}.")
        first, last = range_to_pin(state, here, frame)
        pin = here.model_copy(
            update={
                "first_frame": first if self.first is None else min(self.first, frame),
                "last_frame": last if self.last is None else max(self.last, frame),
            }
        )
        pins = (*state.doc.subject.pins, _beside_neighbours(state, pin, frame))
        return _with_pins(state, pins, _floor_under(state, pin, frame) if self.floor else {})

    def _here(self, state: EditorState, frame: int) -> Pin:
        """The pin at this frame alone."""
        point_m, landmarks = self.point_m, self.landmarks
        if self.corner is not None and self.part in state.doc.subject.body.names:
            point_m = corner_near(state, self.part, frame, self.corner)
        if landmarks is None and point_m is None:
            landmarks = default_landmarks(state.doc.subject.body, self.part)
        at = {"first_frame": frame, "last_frame": frame, "floor": self.floor}
        held = {"part": self.part, "landmarks": landmarks or (), "point_m": point_m}
        return valid(Pin, {**held, **at})


class ChangePin(Edit):
    """Fields that are left out stay. An end that would run into another pin of the same points
    stops there; both ends moved by as much move the pin."""

    do: Literal["change_pin"] = "change_pin"
    verb = "change a pin"
    index: PinIndex
    first: FrameIndex | None = None
    last: FrameIndex | None = None
    landmarks: Landmarks | None = None
    floor: bool | None = None

    @property
    def frames_named(self) -> tuple[int, ...]:
        """None: a pin that is dragged past an end of the video stops there."""
        return ()

    def apply(self, state: EditorState) -> Session:
        pin = self._moved(state, _require(state, self.index))
        if self.landmarks is not None:
            pin = pin.model_copy(update={"landmarks": self.landmarks, "point_m": None})
            _require_held(state, pin)
            others = _without(state.doc.subject.pins, self.index)
            taken = next((pinned for pinned in others if pinned.overlaps(pin)), None)
            if taken is not None:
                raise ActionRefused(
                    f"Another pin holds this point in {_frames(taken)}. Shorten one of them first."
                )
        floor: dict[str, float] = {}
        if self.floor is not None:
            pin = pin.model_copy(update={"floor": self.floor})
            floor = _floor_under(state, pin, pin.first_frame) if self.floor else {}
        pins = list(state.doc.subject.pins)
        pins[self.index] = pin
        return _with_pins(state, pins, floor)

    def _moved(self, state: EditorState, old: Pin) -> Pin:
        """Move to the frames that were asked for, as far as neighbours and the video let it."""
        first = old.first_frame if self.first is None else self.first
        last = old.last_frame if self.last is None else self.last
        least, most = _room(state, old, self.index)
        shift = first - old.first_frame
        if shift != 0 and shift == last - old.last_frame:
            shift = min(max(shift, least - old.first_frame), most - old.last_frame)
            first, last = old.first_frame + shift, old.last_frame + shift
        elif first != old.first_frame:
            first = min(max(first, least), max(old.last_frame - 1, least))
            last = old.last_frame if self.last is None else min(max(last, first), most)
        else:
            last = max(min(last, most), min(first + 1, most))
        return old.model_copy(update={"first_frame": first, "last_frame": last})


class DeletePin(Edit):
    do: Literal["delete_pin"] = "delete_pin"
    verb = "unpin"
    index: PinIndex

    def apply(self, state: EditorState) -> Session:
        _require(state, self.index)
        return _with_pins(state, _without(state.doc.subject.pins, self.index))


class SplitPin(Edit):
    """Two pins instead of one, the second from this frame on, each with a place of its own."""

    do: Literal["split_pin"] = "split_pin"
    verb = "split a pin at"
    target = "frame"
    index: PinIndex
    frame: FrameIndex

    def apply(self, state: EditorState) -> Session:
        pin, at = _require(state, self.index), self.index
        if not pin.first_frame < self.frame <= pin.last_frame:
            raise ActionRefused(f"Frame {self.frame} does not split this pin, {_frames(pin)}.")
        before = pin.model_copy(update={"last_frame": self.frame - 1})
        after = pin.model_copy(update={"first_frame": self.frame})
        return _with_pins(
            state, (*state.doc.subject.pins[:at], before, after, *state.doc.subject.pins[at + 1 :])
        )


class _Proposals(Message):
    """The proposed pins of a part, or of a part from a frame on; all where neither is named."""

    part: Name | None = None
    first: FrameIndex | None = None

    def _named(self, state: EditorState) -> tuple[Pin, ...]:
        return tuple(
            pin
            for pin in open_proposals(state)
            if self.part in (None, pin.part) and self.first in (None, pin.first_frame)
        )


class AcceptPins(Edit, _Proposals):
    do: Literal["accept_pins"] = "accept_pins"
    verb = "accept proposed pins"

    def apply(self, state: EditorState) -> Session:
        accepted = self._named(state)
        if not accepted:
            raise ActionRefused("No pin is proposed here any more.")
        return _with_pins(state, (*state.doc.subject.pins, *accepted))


class DismissPins(Look, _Proposals):
    """These are not shown until others are proposed."""

    do: Literal["dismiss_pins"] = "dismiss_pins"

    def after(self, state: EditorState) -> EditorState:
        return replace(state, dismissed_pins=(*state.dismissed_pins, *self._named(state)))


MESSAGES = (SetPin, ChangePin, DeletePin, SplitPin, AcceptPins, DismissPins)


def _room(state: EditorState, pin: Pin, index: int) -> tuple[int, int]:
    """First and last frame that a pin may reach between its neighbours."""
    others = [p for p in _without(state.doc.subject.pins, index) if shares_points(p, pin)]
    before = [p.last_frame + 1 for p in others if p.last_frame < pin.first_frame]
    after = [p.first_frame - 1 for p in others if p.first_frame > pin.last_frame]
    return max(before, default=0), min(after, default=state.frame_count - 1)


def _beside_neighbours(state: EditorState, pin: Pin, frame: int) -> Pin:
    """Cut where the next pins of the same points are, and widened to the least length."""
    here = pin.model_copy(update={"first_frame": frame, "last_frame": frame})
    least, most = _room(state, here, len(state.doc.subject.pins))
    first, last = max(pin.first_frame, least), min(pin.last_frame, most)
    missing = LEAST_FRAMES - (last - first + 1)
    if missing > 0:
        first = max(least, first - missing // 2)
        last = min(most, first + LEAST_FRAMES - 1)
        first = max(least, last - LEAST_FRAMES + 1)
    return pin.model_copy(update={"first_frame": first, "last_frame": last})


def _require(state: EditorState, index: int) -> Pin:
    if index >= len(state.doc.subject.pins):
        raise ActionRefused("This pin no longer exists.")
    return state.doc.subject.pins[index]


def _require_held(state: EditorState, pin: Pin) -> None:
    """Refused where the body lacks what is to be held."""
    body = state.doc.subject.body
    if pin.part not in body.names:
        raise ActionRefused(f"The body has no part {pin.part!r} to pin.")
    landmarks = body.parts[body.index(pin.part)].landmarks
    missing = [name for name in pin.landmarks if name not in landmarks]
    if missing:
        raise ActionRefused(f"{part_label(pin.part)} has no {missing[0]!r} to pin.")


def _floor_under(state: EditorState, pin: Pin, frame: int) -> dict[str, float]:
    """The floor at this pin's height, where nobody has said yet where it is."""
    if state.doc.world.floor_m is not None:
        return {}
    return {"floor_m": foot_height(state, pin, frame)}


def _with_pins(
    state: EditorState, pins: Iterable[Pin], floor: Mapping[str, float] | None = None
) -> Session:
    return state.doc.changed({"pins": tuple(pins), **(floor or {})})


def _without(pins: Sequence[Pin], index: int) -> tuple[Pin, ...]:
    return (*pins[:index], *pins[index + 1 :])


def _frames(pin: Pin) -> str:
    return named_frames(*pin.span)
