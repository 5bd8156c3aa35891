"""Edit the motion of the camera: correct it at a frame, take a correction back, leave it."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from keypose.app.editor.camera import SHORTEST_PX
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.frames import T_camera_world, up_of, zoom_at
from keypose.app.editor.message import Edit
from keypose.app.editor.state import EditorState
from keypose.app.posing.gesture import Spot
from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.horizon import up_from_horizon
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.session.camera_motion import CameraKeyframe, CameraMotion
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import FrameIndex

MOST_OFF_PX = 8.0
"""By how much matched points may disagree with any turn of the camera."""


class ForgetCamera(Edit):
    """The camera as it was before its motion was found: the world is what it sees, and whether it
    stands still is as it was found."""

    do: Literal["forget_camera"] = "forget_camera"
    verb = "leave the camera as it was"

    def apply(self, state: EditorState) -> Session:
        settings = state.doc.settings.model_copy(update={"static_camera": None})
        fields = {"camera_motion": None, "camera_keyframes": (), "settings": settings}
        return state.doc.changed(fields)


class CameraHorizon(Edit):
    """The camera at the present frame turned until the horizon of the world lies on a line that was
    drawn, pixels of the picture."""

    do: Literal["camera_horizon"] = "camera_horizon"
    verb = "correct the camera"
    a: Spot
    b: Spot

    def apply(self, state: EditorState) -> Session:
        doc, frame = state.doc, state.frame
        if math.dist(self.a, self.b) < SHORTEST_PX:
            raise ActionRefused("Draw a longer line along the horizon.")
        if doc.world.up_world is None:
            raise ActionRefused("Say what is up first: draw the horizon at another frame.")
        here = up_of(doc, frame)
        seen = up_from_horizon(state.camera.without_distortion(), self.a, self.b, here)
        return _corrected(state, _least_turn(np.array(here), seen), zoom_at(doc, frame))


class CameraMatch(Edit):
    """The camera at the present frame turned until two points of the background lie where the same
    were at another frame, pixels of both pictures."""

    do: Literal["camera_match"] = "camera_match"
    verb = "correct the camera"
    other: FrameIndex
    here: Annotated[tuple[Spot, ...], Field(min_length=2, max_length=100)]
    there: Annotated[tuple[Spot, ...], Field(min_length=2, max_length=100)]

    def apply(self, state: EditorState) -> Session:
        from keypose.tracker.camera_motion.matches import (  # loads what only this needs
            rotation_from_matches,
        )

        doc, frame = state.doc, state.frame
        if self.other >= state.frame_count or self.other == frame:
            raise ActionRefused("Mark the same points at another frame of the film first.")
        camera = doc.view.camera.without_distortion()
        try:
            found = rotation_from_matches(
                np.array(self.there), np.array(self.here), camera, zoom_at(doc, self.other)
            )
        except CameraError as error:
            raise ActionRefused(str(error)) from None
        if np.median(found.error_px) > MOST_OFF_PX:
            raise ActionRefused("No turn of the camera explains these points: check them.")
        R = found.R_other_one @ T_camera_world(doc, self.other)[:3, :3]
        return _corrected(state, R @ T_camera_world(doc, frame)[:3, :3].T, found.zoom)


class DeleteCameraKey(Edit):
    """The camera at a frame as it was found."""

    do: Literal["delete_camera_key"] = "delete_camera_key"
    verb = "take the camera's correction back"
    frame: FrameIndex

    def apply(self, state: EditorState) -> Session:
        kept = tuple(k for k in state.doc.view.camera_keyframes if k.frame != self.frame)
        if len(kept) == len(state.doc.view.camera_keyframes):
            raise ActionRefused(f"The camera is not corrected at frame {self.frame}.")
        return state.doc.changed({"camera_keyframes": kept})


MESSAGES = (ForgetCamera, CameraHorizon, CameraMatch, DeleteCameraKey)


def _corrected(state: EditorState, turn: Array, zoom: float) -> Session:
    """The camera at the present frame turned (3, 3), in its own frame, about where it stands."""
    doc, frame = state.doc, state.frame
    if frame == 0:
        raise ActionRefused("The first frame is the world's own: correct the camera at another.")
    T = T_camera_world(doc, frame).copy()
    T[:3] = turn @ T[:3]
    key = CameraKeyframe.of(frame, T, zoom)
    others = (k for k in doc.view.camera_keyframes if k.frame != frame)
    keys = tuple(sorted((*others, key), key=lambda k: k.frame))
    motion = doc.view.camera_motion
    if motion is None:
        motion = CameraMotion.of("turns", CameraPath.standing_still(state.frame_count))
    settings = doc.settings.model_copy(update={"static_camera": False})
    return doc.changed({"camera_keyframes": keys, "camera_motion": motion, "settings": settings})


def _least_turn(one: Array, other: Array) -> Array:
    """The least rotation (3, 3) that brings one unit vector to another."""
    axis = np.cross(one, other)
    sine, cosine = float(np.linalg.norm(axis)), float(one @ other)
    if sine < 1e-12:
        return np.eye(3)
    return np.asarray(exp_rotation(axis / sine * math.atan2(sine, cosine)))
