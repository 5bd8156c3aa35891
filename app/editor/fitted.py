"""What was fitted to the pictures, taken over as one step that can be undone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from keypose.app.editor.documents import (
    ActionRefused,
    as_soft_as,
    at_new_focal,
    keyframe_of,
    posed,
    require_before_camera,
    require_sound,
    with_keyframes,
)
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.schema import Session


def pose_to_fit(state: EditorState) -> Pose:
    """The pose shown at the present frame; Refused where nothing has been posed yet.

    A surface can also be fitted from the pose in which the session opens.
    """
    if state.doc.evidence.is_posed_first and not (state.doc.keyframes or state.doc.drafts):
        raise ActionRefused("Pose the body roughly first.")
    return shown_pose(state).pose


def require_sizes_to_fit(state: EditorState) -> None:
    """Refused where the sizes cannot be estimated."""
    if len(state.keys) < 2:
        raise ActionRefused("Needs 2 keyframes that show the body from different sides.")


def with_pose_fitted(state: EditorState, frame: int, pose: Pose) -> EditorState:
    """Set this pose at a frame."""
    doc = posed(state.doc, state.skeleton, pose, frame, state.times_s)
    return _after(state, doc, "fit the pose", frame)


def with_sizes_fitted(
    state: EditorState, body: Body, camera: Camera, keyposes: Mapping[int, Pose]
) -> EditorState:
    """Take over this body and camera, and the keyframes posed for them; what is posed as it was
    stays to the last digit.
    """
    skeleton, nearer = Skeleton.of(body), camera.fx / state.doc.camera.fx
    for pose in keyposes.values():
        require_before_camera(skeleton, pose)
    keyframes = [
        known
        if _is_posed_as(state.skeleton, known, keyposes[known.frame])
        else as_soft_as(
            known, keyframe_of(skeleton, keyposes[known.frame], known.frame, state.times_s)
        )
        for known in state.doc.keyframes
    ]
    drafts = tuple(at_new_focal(draft, nearer) for draft in state.doc.drafts)
    parts = tuple(at_new_focal(each, nearer) for each in state.doc.part_keyframes)
    for posed_there in (*drafts, *parts):
        require_before_camera(skeleton, posed_there.pose(skeleton))
    update: dict[str, Any] = {
        "body": body, "camera": camera, "drafts": drafts, "part_keyframes": parts
    }  # fmt: skip
    if nearer != 1.0:
        update["lens_source"] = "fitted"
    doc = with_keyframes(state.doc.model_copy(update=update), keyframes)
    return _after(state, doc, "fit the sizes", state.frame)


def _is_posed_as(skeleton: Skeleton, keyframe: Keyframe, pose: Pose) -> bool:
    own = keyframe.pose(skeleton)
    return np.array_equal(own.Rs_parent_part, pose.Rs_parent_part) and np.array_equal(
        own.p_camera_root, pose.p_camera_root
    )


def _after(state: EditorState, doc: Session, label: str, frame: int) -> EditorState:
    require_sound(state.doc, doc, label)
    history = state.history.after(state.doc, label, frame)
    return replace(state.with_doc(doc), history=history)
