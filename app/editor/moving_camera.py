"""Edit the motion of the camera: correct it at a frame, take a correction back, leave it."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field, FiniteFloat

from keypose.app.editor.camera import SHORTEST_PX
from keypose.app.editor.documents import ActionRefused, seen_as_before
from keypose.app.editor.frames import up_of
from keypose.app.editor.message import Edit
from keypose.app.editor.state import EditorState
from keypose.app.posing.gesture import Spot
from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.horizon import up_from_horizon
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.session.camera_motion import CameraKeyframe, CameraMotion
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import FrameIndex

if TYPE_CHECKING:
    from keypose.tracker.camera_motion.matches import Matched

FARTHEST_M = 10_000.0
"""Farther nobody carries a camera while a person is filmed."""
CLICKED_PX = 2.0
"""How far points that are marked by hand usually lie off."""
MOST_OFF_PX = 8.0
"""By how much matched points may disagree with any turn of the camera."""


class ForgetCamera(Edit):
    """The camera as it was before its motion was found: the world is what it sees, and whether it
    stands still is as it was found."""

    do: Literal["forget_camera"] = "forget_camera"
    verb = "leave the camera as it was"

    def apply(self, state: EditorState) -> Session:
        return forgotten(state.doc)


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
        horizon_up = up_from_horizon(state.camera.without_distortion(), self.a, self.b, here)
        return _corrected(
            state, _least_turn(np.array(here), horizon_up), doc.film_camera.zoom_at(frame)
        )


class CameraMatch(Edit):
    """The camera at the present frame turned until two points of the background lie where the same
    were at another frame, pixels of both pictures."""

    do: Literal["camera_match"] = "camera_match"
    verb = "correct the camera"
    other: FrameIndex
    here: Annotated[tuple[Spot, ...], Field(min_length=2, max_length=100)]
    there: Annotated[tuple[Spot, ...], Field(min_length=2, max_length=100)]

    def apply(self, state: EditorState) -> Session:
        doc, frame = state.doc, state.frame
        if self.other == frame:
            raise ActionRefused("Mark the same points at another frame of the film first.")
        try:
            lens, zoom = doc.view.camera.without_distortion(), doc.film_camera.zoom_at(self.other)
            matched = self._matched(lens, zoom)
        except CameraError as error:
            raise ActionRefused(str(error)) from None
        if np.median(matched.error_px) > MOST_OFF_PX:
            raise ActionRefused("No turn of the camera explains these points: check them.")
        R = matched.R_other_one @ doc.film_camera.T_camera_world(self.other)[:3, :3]
        return _corrected(state, R @ doc.film_camera.T_camera_world(frame)[:3, :3].T, matched.zoom)

    def _matched(self, camera: Camera, zoom: float) -> Matched:
        """The turn between both frames; a zoom only where no turn alone explains the points, since
        two that are marked by hand always tell a little of one. zoom: of the other frame."""
        from keypose.tracker.camera_motion.matches import (  # loads what only this needs
            rotation_from_matches,
        )

        marked = np.array(self.there), np.array(self.here)
        with suppress(CameraError):
            matched = rotation_from_matches(*marked, camera, zoom, zooms=False)
            if np.median(matched.error_px) <= CLICKED_PX:
                return matched
        return rotation_from_matches(*marked, camera, zoom)


class CameraFar(Edit):
    """How far the camera went from where it was as a piece of its motion begins, as somebody
    knows. first: the frame at which that is."""

    do: Literal["camera_far"] = "camera_far"
    verb = "set how far the camera went"
    first: FrameIndex = 0
    metres: Annotated[FiniteFloat, Field(gt=0, le=FARTHEST_M)]

    def apply(self, state: EditorState) -> Session:
        from keypose.tracker.operations.find_camera import (  # loads what only this needs
            with_known_way,
        )

        try:
            return with_known_way(state.doc, self.first, self.metres)
        except CameraError as error:
            raise ActionRefused(str(error)) from None


class DeleteCameraKey(Edit):
    """The camera at a frame as it was found."""

    do: Literal["delete_camera_key"] = "delete_camera_key"
    verb = "take the camera's correction back"
    frame: FrameIndex

    def apply(self, state: EditorState) -> Session:
        kept = tuple(k for k in state.doc.view.camera_keyframes if k.frame != self.frame)
        if len(kept) == len(state.doc.view.camera_keyframes):
            raise ActionRefused(f"The camera is not corrected at frame {self.frame}.")
        return _with_camera_keyframes(state.doc, kept)


MESSAGES = (ForgetCamera, CameraHorizon, CameraMatch, CameraFar, DeleteCameraKey)


def forgotten(doc: Session) -> Session:
    """The session as before its camera's motion was found; what is posed is seen as large as it
    was."""
    settings = doc.settings.model_copy(update={"static_camera": None})
    fields = {"camera_motion": None, "camera_keyframes": (), "settings": settings}
    return seen_as_before(doc, doc.changed(fields))


def _with_camera_keyframes(
    doc: Session, keys: tuple[CameraKeyframe, ...], **others: object
) -> Session:
    """The session with these corrections of its camera, and other fields; what is posed is seen as
    large as before, also where the zoom is another one."""
    after = doc.changed({"camera_keyframes": keys, **others})
    return seen_as_before(doc, after)


def _corrected(state: EditorState, turn: Array, zoom: float) -> Session:
    """The camera at the present frame turned (3, 3), in its own frame, about where it stands."""
    doc, frame = state.doc, state.frame
    if frame == 0:
        raise ActionRefused("The first frame is the world's own: correct the camera at another.")
    T = doc.film_camera.T_camera_world(frame).copy()
    T[:3] = turn @ T[:3]
    key = CameraKeyframe.of(frame, T, zoom)
    others = (k for k in doc.view.camera_keyframes if k.frame != frame)
    keys = tuple(sorted((*others, key), key=lambda k: k.frame))
    motion = doc.view.camera_motion
    if motion is None:
        motion = CameraMotion.of("turns", CameraPath.standing_still(state.frame_count))
    settings = doc.settings.model_copy(update={"static_camera": False})
    return _with_camera_keyframes(doc, keys, camera_motion=motion, settings=settings)


def _least_turn(before: Array, after: Array) -> Array:
    """The least rotation (3, 3) that brings one unit vector to another."""
    axis = np.cross(before, after)
    sine, cosine = float(np.linalg.norm(axis)), float(before @ after)
    if sine < 1e-12:
        return np.eye(3)
    return np.asarray(exp_rotation(axis / sine * math.atan2(sine, cosine)))
