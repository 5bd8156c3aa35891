"""Edits of keypoints: where a person says that a joint is seen, whatever was found there."""

from __future__ import annotations

import numpy as np

from keypose.app.editor import actions as do
from keypose.app.editor.refusal import Refused
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.session.annotations import KeypointCorrection
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import Pixel

DECIMALS = 2


def correct_keypoint(state: EditorState, action: do.CorrectKeypoint) -> Session:
    """The keypoint is there, for sure."""
    uv = _in_video(state.doc.camera, action.at)
    return _with(state, action, KeypointCorrection(frame=action.frame, joint=action.joint, uv=uv))


def ignore_keypoint(state: EditorState, action: do.IgnoreKeypoint) -> Session:
    """What was found there does not count."""
    return _with(state, action, KeypointCorrection(frame=action.frame, joint=action.joint))


def restore_keypoint(state: EditorState, action: do.RestoreKeypoint) -> Session:
    """As it was found."""
    return _with(state, action, None)


def _with(
    state: EditorState,
    action: do.CorrectKeypoint | do.IgnoreKeypoint | do.RestoreKeypoint,
    correction: KeypointCorrection | None,
) -> Session:
    _require_counting(state.doc, action.joint)
    place = (action.frame, action.joint)
    others = [each for each in state.doc.keypoint_corrections if _place(each) != place]
    every = others if correction is None else [*others, correction]
    return state.doc.model_copy(update={"keypoint_corrections": tuple(sorted(every, key=_place))})


def _place(each: KeypointCorrection) -> tuple[int, str]:
    return each.frame, each.joint


def _require_counting(doc: Session, joint: str) -> None:
    """Refused where tracking has no use for such a keypoint."""
    if doc.surface is not None:
        raise Refused("Keypoints are found in a video, not in surfaces.")
    if not len(points_on_body(doc.body, [joint]).indices):
        raise Refused(f"This body has no keypoint {part_label(joint).lower()}.")


def _in_video(camera: Camera, at: Pixel) -> Pixel:
    """From pixels of the main view, whose lens is ideal, to those of the video."""
    spot = np.array(at)
    if camera.is_distorted:
        spot = camera.project(camera.without_distortion().back_project(spot, 1.0))
    if not np.isfinite(spot).all():
        raise Refused("The lens shows nothing there.")
    u, v = spot.round(DECIMALS).tolist()
    return u, v
