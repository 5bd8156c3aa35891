"""The keypoints of the present frame, as JSON: those that tracking can compare with the body."""

from __future__ import annotations

from typing import Final

import numpy as np

from keypose.app.posing import part_label
from keypose.app.store.sections.json_value import Json
from keypose.app.store.state import AppState
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import HEAD_POINTS, points_on_body
from keypose.tracker.session.annotations import KeypointCorrection

SHOWN: Final = (*JOINTS, *HEAD_POINTS, "right_ear")


def keypoints(app_state: AppState) -> Json:
    """Where each is, in pixels of the main view, how sure that is, and what a person said of it;
    null where nothing is known of this frame.

    Of an ignored one it is given where it was found, so that it can be put back.
    """
    edit = app_state.edit
    if edit is None or edit.doc.surface is not None:
        return None
    found = app_state.keypoints.at(edit.frame)
    said = {c.joint: c for c in edit.doc.keypoint_corrections if c.frame == edit.frame}
    if found is None and not said:
        return None
    on_body = points_on_body(edit.doc.body, SHOWN).indices
    names = [SHOWN[k] for k in on_body]
    at = {name: k for k, name in enumerate(found.names)} if found is not None else {}
    points = []
    for name in names:
        uv, sure = np.full(2, np.nan), 0.0
        if found is not None and name in at:
            uv, sure = found.uv[0, at[name]], float(found.visibility[0, at[name]])
        points.append(_point(name, uv, sure, said.get(name), edit.doc.camera))
    return {"frame": edit.frame, "points": [point for point in points if point is not None]}


def _point(
    name: str, uv: Array, sure: float, said: KeypointCorrection | None, camera: Camera
) -> Json:
    state = "found" if said is None else "ignored" if said.uv is None else "corrected"
    if said is not None and said.uv is not None:
        uv, sure = np.array(said.uv), 1.0
    if camera.is_distorted:
        uv = camera.without_distortion().project(camera.back_project(uv, 1.0))
    if not np.isfinite(uv).all():
        return None
    return {
        "joint": name,
        "label": part_label(name),
        "at": uv.round(2).tolist(),
        "sure": round(0.0 if state == "ignored" else sure, 3),
        "state": state,
    }
