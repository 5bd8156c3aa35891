"""Edits of the pins: which points of the body stand still, and from when to when."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pydantic import ValidationError

from keypose.app.editor import actions as do
from keypose.app.editor.documents import ActionRefused, with_keyframes, without
from keypose.app.editor.floor_edits import foot_height
from keypose.app.editor.pinned import (
    LEAST_FRAMES,
    corner_near,
    default_landmarks,
    open_proposals,
    range_to_pin,
    shares_points,
)
from keypose.app.editor.shown import find
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label
from keypose.app.words.problems import named_frames
from keypose.tracker.errors import one_sentence
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.schema import Session


def set_pin(state: EditorState, action: do.SetPin) -> Session:
    """One more pin; where no frames are named, over those around one that stand still."""
    frame = min(action.frame, state.frame_count - 1)
    point_m = action.point_m
    if action.corner is not None and action.part in state.doc.body.names:
        point_m = corner_near(state, action.part, frame, action.corner)
    landmarks = action.landmarks
    if landmarks is None and point_m is None:
        landmarks = default_landmarks(state.doc.body, action.part)
    here = _pin(
        part=action.part, landmarks=landmarks or (), point_m=point_m,
        first_frame=frame, last_frame=frame, floor=action.floor,
    )  # fmt: skip
    _require_held(state, here)
    taken = next((pin for pin in state.doc.pins if pin.overlaps(here)), None)
    if taken is not None:
        raise ActionRefused(f"{part_label(action.part)} is already pinned in {_frames(taken)}.")
    first, last = range_to_pin(state, here, frame)
    pin = here.model_copy(
        update={
            "first_frame": first if action.first is None else min(action.first, frame),
            "last_frame": last if action.last is None else max(action.last, frame),
        }
    )
    floor = _floor_under(state, pin, frame) if action.floor else {}
    return _with_pins(state, (*state.doc.pins, _beside_neighbours(state, pin, frame))).model_copy(
        update=floor
    )


def change_pin(state: EditorState, action: do.ChangePin) -> Session:
    """Other frames, points or floor; what is left out stays. A neighbour stops both ends."""
    old = _require(state, action.index)
    pin = _moved(state, action, old)
    if action.landmarks is not None:
        pin = pin.model_copy(update={"landmarks": action.landmarks, "point_m": None})
        _require_held(state, pin)
        others = _without(state.doc.pins, action.index)
        taken = next((other for other in others if other.overlaps(pin)), None)
        if taken is not None:
            raise ActionRefused(
                f"Another pin holds this point in {_frames(taken)}. Shorten one of them first."
            )
    floor: dict[str, float] = {}
    if action.floor is not None:
        pin = pin.model_copy(update={"floor": action.floor})
        floor = _floor_under(state, pin, pin.first_frame) if action.floor else {}
    pins = list(state.doc.pins)
    pins[action.index] = pin
    return _with_pins(state, pins).model_copy(update=floor)


def delete_pin(state: EditorState, action: do.DeletePin) -> Session:
    """One pin fewer."""
    _require(state, action.index)
    return _with_pins(state, _without(state.doc.pins, action.index))


def split_pin(state: EditorState, action: do.SplitPin) -> Session:
    """Two pins instead of one, the second from a frame on, each with a place of its own."""
    pin = _require(state, action.index)
    if not pin.first_frame < action.frame <= pin.last_frame:
        raise ActionRefused(f"Frame {action.frame} does not split this pin, {_frames(pin)}.")
    before = pin.model_copy(update={"last_frame": action.frame - 1})
    after = pin.model_copy(update={"first_frame": action.frame})
    at = action.index
    return _with_pins(state, (*state.doc.pins[:at], before, after, *state.doc.pins[at + 1 :]))


def accept_pins(state: EditorState, action: do.AcceptPins) -> Session:
    """The proposed pins that were named, or all of them."""
    accepted = named_proposals(state, action)
    if not accepted:
        raise ActionRefused("No pin is proposed here any more.")
    return _with_pins(state, (*state.doc.pins, *accepted))


def named_proposals(state: EditorState, action: do.AcceptPins | do.DismissPins) -> tuple[Pin, ...]:
    """Select proposals of a part, or of a part that begins at a frame, or all that are open."""
    found = open_proposals(state)
    if action.part is not None:
        found = tuple(pin for pin in found if pin.part == action.part)
    if action.first is not None:
        found = tuple(pin for pin in found if pin.first_frame == action.first)
    return found


def soften_keys(state: EditorState, action: do.SoftenKeys) -> Session:
    """Soften the keyframes that are named, and still are keyframes: the motion need
    only come near.
    """
    if not set(state.keys).intersection(action.frames):
        raise ActionRefused("None of these frames is a keyframe any more.")
    return with_keyframes(
        state.doc,
        [
            each.model_copy(update={"soft": True}) if each.frame in action.frames else each
            for each in state.doc.keyframes
        ],
    )


def soften_key(state: EditorState, action: do.SoftenKey | do.ExactKey) -> Session:
    """A keyframe that the motion need only come near, or one it meets exactly."""
    keyframe = find(state.doc.keyframes, action.frame)
    if keyframe is None:
        raise ActionRefused(f"Frame {action.frame} is not a keyframe.")
    soft = isinstance(action, do.SoftenKey)
    if keyframe.soft == soft:
        return state.doc
    changed = keyframe.model_copy(update={"soft": soft})
    return with_keyframes(state.doc, (*without(state.doc.keyframes, action.frame), changed))


# --- frames


def _moved(state: EditorState, action: do.ChangePin, old: Pin) -> Pin:
    """Move to the frames that were asked for, as far as neighbours and the video let it."""
    first = old.first_frame if action.first is None else action.first
    last = old.last_frame if action.last is None else action.last
    least, most = _room(state, old, action.index)
    shift = first - old.first_frame
    if shift != 0 and shift == last - old.last_frame:
        shift = min(max(shift, least - old.first_frame), most - old.last_frame)
        first, last = old.first_frame + shift, old.last_frame + shift
    elif first != old.first_frame:
        first = min(max(first, least), max(old.last_frame - 1, least))
        last = old.last_frame if action.last is None else min(max(last, first), most)
    else:
        last = max(min(last, most), min(first + 1, most))
    return old.model_copy(update={"first_frame": first, "last_frame": last})


def _room(state: EditorState, pin: Pin, index: int) -> tuple[int, int]:
    """First and last frame that a pin may reach between its neighbours."""
    others = [p for p in _without(state.doc.pins, index) if shares_points(p, pin)]
    before = [p.last_frame + 1 for p in others if p.last_frame < pin.first_frame]
    after = [p.first_frame - 1 for p in others if p.first_frame > pin.last_frame]
    return max(before, default=0), min(after, default=state.frame_count - 1)


def _beside_neighbours(state: EditorState, pin: Pin, frame: int) -> Pin:
    """Cut where the next pins of the same points are, and widened to the least length."""
    here = pin.model_copy(update={"first_frame": frame, "last_frame": frame})
    least, most = _room(state, here, len(state.doc.pins))
    first, last = max(pin.first_frame, least), min(pin.last_frame, most)
    missing = LEAST_FRAMES - (last - first + 1)
    if missing > 0:
        first = max(least, first - missing // 2)
        last = min(most, first + LEAST_FRAMES - 1)
        first = max(least, last - LEAST_FRAMES + 1)
    return pin.model_copy(update={"first_frame": first, "last_frame": last})


# --- the small moves


def _pin(**values: object) -> Pin:
    try:
        return Pin.model_validate(values)
    except ValidationError as error:
        raise ActionRefused(one_sentence(error)) from None


def _require(state: EditorState, index: int) -> Pin:
    if index >= len(state.doc.pins):
        raise ActionRefused("This pin no longer exists.")
    return state.doc.pins[index]


def _require_held(state: EditorState, pin: Pin) -> None:
    """Refused where the body lacks what is to be held."""
    body = state.doc.body
    if pin.part not in body.names:
        raise ActionRefused(f"The body has no part {pin.part!r} to pin.")
    known = body.parts[body.index(pin.part)].landmarks
    missing = [name for name in pin.landmarks if name not in known]
    if missing:
        raise ActionRefused(f"{part_label(pin.part)} has no {missing[0]!r} to pin.")


def _floor_under(state: EditorState, pin: Pin, frame: int) -> dict[str, float]:
    """The floor at this pin's height, where nobody has said yet where it is."""
    if state.doc.floor_m is not None:
        return {}
    return {"floor_m": foot_height(state, pin, frame)}


def _with_pins(state: EditorState, pins: Iterable[Pin]) -> Session:
    return state.doc.model_copy(update={"pins": tuple(pins)})


def _without(pins: Sequence[Pin], index: int) -> tuple[Pin, ...]:
    return (*pins[:index], *pins[index + 1 :])


def _frames(pin: Pin) -> str:
    return named_frames(*pin.span)
