"""Edits of the floor: how high it lies."""

from __future__ import annotations

import numpy as np

from app.editor import actions as do
from app.editor.pinned import default_landmarks
from app.editor.pointer_views import up_of
from app.editor.refusal import Refused
from app.editor.shown import shown_pose
from app.editor.state import EditorState
from tracker.body.pose import pose_transforms
from tracker.geometry.rotations import Array
from tracker.session.pins import Pin
from tracker.session.schema import Session

LEAST_M = 0.05
"""The floor lies at least this far above or below the camera."""


def set_floor(state: EditorState, action: do.Floor) -> Session:
    """The floor's height: given, that of pinned feet or of one foot, or not known any more."""
    if action.pinned_feet:
        return _with_floor(state, _height_of_pins(state))
    if action.under is not None:
        held = default_landmarks(state.doc.body, action.under)
        at = state.frame
        foot = Pin(part=action.under, landmarks=held, first_frame=at, last_frame=at)
        state.doc.body.index(foot.part)
        return _with_floor(state, foot_height(state, foot, at))
    return _with_floor(state, action.height_m)


def foot_height(state: EditorState, pin: Pin, frame: int) -> float:
    """How high a pin's lowest point lies at a frame, metres along up from the camera."""
    return round(float((_points_at(state, pin, frame) @ np.array(up_of(state.doc))).min()), 4)


def _height_of_pins(state: EditorState) -> float:
    """The median height of what is pinned to the floor, or else of all pinned feet."""
    feet = [pin for pin in state.doc.pins if pin.landmarks]
    pins = [pin for pin in state.doc.pins if pin.floor] or feet
    if not pins:
        raise Refused("No foot is pinned yet. Pin one that stands on the floor first.")
    middles = [(pin.first_frame + pin.last_frame) // 2 for pin in pins]
    heights = [foot_height(state, pin, at) for pin, at in zip(pins, middles, strict=True)]
    return float(np.median(heights))


def _points_at(state: EditorState, pin: Pin, frame: int) -> Array:
    """(points, 3) camera frame, metres."""
    Ts = pose_transforms(state.skeleton, shown_pose(state, frame).pose)
    T = Ts[state.doc.body.index(pin.part)]
    return np.asarray(np.array(pin.points(state.doc.body)) @ T[:3, :3].T + T[:3, 3])


def _with_floor(state: EditorState, height_m: float | None) -> Session:
    if height_m is not None and abs(height_m) < LEAST_M:
        raise Refused("The floor would go through the camera. Set it lower.")
    rounded = None if height_m is None else round(height_m, 4)
    return state.doc.model_copy(update={"floor_m": rounded})
