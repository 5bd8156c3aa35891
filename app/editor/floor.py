"""Edit the floor: how high it lies, and which way is up from it."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from keypose.app.editor.camera import SHORTEST_PX
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.frames import up_of
from keypose.app.editor.message import Edit
from keypose.app.editor.pinned import default_landmarks
from keypose.app.editor.shown import part_at, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label
from keypose.app.posing.gesture import Metres, Spot
from keypose.tracker.body.body import Name
from keypose.tracker.geometry.horizon import up_from_horizon
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.geometry.up import UpEvidence
from keypose.tracker.session.pins import Pin, sole_of
from keypose.tracker.session.schema import Session
from keypose.tracker.solver.sigmas import LEAN_RAD
from keypose.tracker.space.level import HELD_LEVEL, up_from_places

LEAST_M = 0.05
"""The floor lies at least this far above or below the camera."""
LEAST_APART_M = 0.5
"""Feet that stand nearer to each other than this do not determine what is level."""
STEEP = 0.15
"""Feet that differ more in height, as a share of how far apart they are, stand on no one floor."""


class Floor(Edit):
    """The floor's height along up from the camera, or that of the pinned feet, or of a part as it
    stands at the present frame; none of them: it is not known."""

    do: Literal["floor"] = "floor"
    verb = "change the floor"
    height_m: Metres | None = None
    pinned_feet: bool = False
    under: Name | None = None

    def apply(self, state: EditorState) -> Session:
        if self.pinned_feet:
            return _with_floor(state, _height_of_pins(state))
        if self.under is None:
            return _with_floor(state, self.height_m)
        foot = _here(state, self.under, default_landmarks(state.doc.subject.body, self.under))
        return _with_floor(state, foot_height(state, foot, state.frame))


class UpFromFeet(Edit):
    """Up so that the pinned feet stand level; what they do not determine stays as it is."""

    do: Literal["up_from_feet"] = "up_from_feet"
    verb = "level the pinned feet"

    def apply(self, state: EditorState) -> Session:
        places, apart = _places_of_feet(state)
        if apart < LEAST_APART_M:
            raise ActionRefused("Pin two steps first, at least half a metre apart.")
        levelled = state.doc.with_up_chosen(up_from_places(places, _known_up(state.doc)))
        if levelled.world.floor_m is None:
            return levelled
        state = state.with_doc(levelled)
        return _with_floor(state, _height_of_pins(state))


class Horizon(Edit):
    """A line drawn on the picture where level ground ends far away, in pixels; its ends may lie
    beside the picture. The floor comes under the pinned feet, or the lower one at this frame; where
    nothing is posed, or the body has no feet, it stays."""

    do: Literal["horizon"] = "horizon"
    verb = "set the horizon"
    a: Spot
    b: Spot

    def apply(self, state: EditorState) -> Session:
        doc = state.doc
        if math.dist(self.a, self.b) < SHORTEST_PX:
            raise ActionRefused("Draw a longer line along the horizon.")
        lens = doc.film_camera.at(state.frame).without_distortion()
        up = up_from_horizon(lens, self.a, self.b, up_of(doc, state.frame))
        levelled = doc.with_up_seen(state.frame, up)
        state = state.with_doc(levelled)
        if any(pin.landmarks for pin in doc.subject.pins):
            return _with_floor(state, _height_of_pins(state))
        feet = _feet_here(state) if shown_pose(state).source != "rest" else ()
        if not feet:
            return levelled
        height, foot = min((foot_height(state, pin, state.frame), pin.part) for pin in feet)
        if height > -LEAST_M:
            raise ActionRefused(
                f"{part_label(foot)} stands above this line. Draw the horizon higher."
            )
        return _with_floor(state, height)


MESSAGES = (Floor, UpFromFeet, Horizon)


def uneven_feet_m(state: EditorState) -> float | None:
    """By how much pinned feet differ in height while nobody has said what is up, metres;
    None where that is no more than where one stands on a slope.
    """
    if state.doc.world.up_world is not None or not state.doc.subject.pins:
        return None
    places, apart = _places_of_feet(state)
    rise = float(np.ptp(places @ state.doc.world.up)) if len(places) else 0.0
    return rise if apart > LEAST_APART_M and rise > STEEP * apart else None


def _known_up(doc: Session) -> UpEvidence:
    """What is known of up beside the feet. These are to stand level, so that it counts as no surer
    than how a person leans."""
    up, sigma_rad = doc.world.up_world, doc.world.up_sigma_rad or 0.0
    if up is None:
        return HELD_LEVEL
    return UpEvidence.of(np.array(up), max(LEAN_RAD, sigma_rad), "set")


def _places_of_feet(state: EditorState) -> tuple[Array, float]:
    """(feet, 3) where the pinned ones stand in the world, and how far apart they are, metres."""
    places = np.array([_middle(state, pin) for pin in state.doc.subject.pins if pin.landmarks])
    return places, float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0


def _feet_here(state: EditorState) -> list[Pin]:
    """The soles of the body at the present frame, as if they were pinned there."""
    soles = [(part.name, sole_of(part)) for part in state.doc.subject.body.parts]
    return [_here(state, name, sole) for name, sole in soles if sole]


def _here(state: EditorState, part: str, landmarks: tuple[str, ...]) -> Pin:
    at = state.frame
    return Pin(part=part, landmarks=landmarks, first_frame=at, last_frame=at)


def foot_height(state: EditorState, pin: Pin, frame: int) -> float:
    """How high a pin's lowest point lies at a frame, metres along up in the world."""
    return round(float((_points_at(state, pin, frame) @ state.doc.world.up).min()), 4)


def _height_of_pins(state: EditorState) -> float:
    """The median height of what is pinned to the floor, or else of all pinned feet."""
    feet = [pin for pin in state.doc.subject.pins if pin.landmarks]
    pins = [pin for pin in state.doc.subject.pins if pin.floor] or feet
    if not pins:
        raise ActionRefused("No foot is pinned yet. Pin one that stands on the floor first.")
    return float(np.median([foot_height(state, pin, _middle_frame(pin)) for pin in pins]))


def _middle(state: EditorState, pin: Pin) -> Array:
    """(3,) where a pinned foot stands in the world, metres."""
    return np.asarray(_points_at(state, pin, _middle_frame(pin)).mean(axis=0))


def _middle_frame(pin: Pin) -> int:
    return (pin.first_frame + pin.last_frame) // 2


def _points_at(state: EditorState, pin: Pin, frame: int) -> Array:
    """(points, 3) in the world, metres."""
    T = part_at(state, pin.part, frame)
    p_camera = np.array(pin.points(state.doc.subject.body)) @ T[:3, :3].T + T[:3, 3]
    path = state.doc.camera_path
    if path is None:
        return np.asarray(p_camera)
    return apply_transform(path.Ts_world_camera[frame], p_camera)


def _with_floor(state: EditorState, height_m: float | None) -> Session:
    if height_m is not None and abs(height_m) < LEAST_M:
        raise ActionRefused("The floor would go through the camera. Set it lower.")
    rounded = None if height_m is None else round(height_m, 4)
    return state.doc.changed({"floor_m": rounded})
