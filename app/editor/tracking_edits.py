"""Edit what tracking is given: regions, settings, and how surfaces are read and fitted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from pydantic import ValidationError

from keypose.app.editor import actions as do
from keypose.app.editor.documents import ActionRefused, require_before_camera, with_times
from keypose.app.editor.shown import find
from keypose.app.editor.state import EditorState
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import one_sentence
from keypose.tracker.geometry.rotations import quaternion_wxyz
from keypose.tracker.session.evidence import surface_of
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.references import Surface
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import IgnoreMask, TrackSettings
from keypose.tracker.surface.placing import METRES, Placement

_PLAIN = ("weights", "distance", "binding", "model_frame", "fps", "units", "up")


def set_surface(state: EditorState, action: do.Observe) -> Session:
    """Only the fields that were named change; where the surfaces lie follows from units and up."""
    before = state.doc.surface
    if before is None:
        raise ActionRefused("This session has a video, not surfaces.")
    named = _named(action)
    _require_keyframe(state, named.get("model_frame"))
    doc = state.doc
    if "units" in named:
        doc = _scaled(state, METRES[named["units"]] / METRES[before.units])
    if "up" in named:
        doc = _turned(doc, state.skeleton, action)
    doc = _with_surface(doc, {**surface_of(doc).model_dump(), **named})
    return with_times(doc, doc.evidence.times_s(None)) if "fps" in named else doc


def _named(action: do.Observe) -> dict[str, Any]:
    """Return what was given. None stands for what was left out, but for the model's frame."""
    given = action.model_dump(include=action.model_fields_set & set(_PLAIN))
    return {name: v for name, v in given.items() if v is not None or name == "model_frame"}


def _require_keyframe(state: EditorState, frame: int | None) -> None:
    if frame is not None and find(state.doc.keyframes, frame) is None:
        raise ActionRefused(f"Frame {frame} is not a keyframe. Pose the body in its surface first.")


def _scaled(state: EditorState, factor: float) -> Session:
    """Everything so much farther away: then it is seen where it was, as large as it was."""
    doc = state.doc
    place = np.array(surface_of(doc).p_camera_surface) * factor
    try:
        moved = _with_poses(doc, state.skeleton, lambda pose: _farther(pose, factor))
    except ActionRefused:
        raise ActionRefused(
            "In these units the surface is so small that the body would be at the camera. "
            "Delete its poses first, or reopen the meshes with other units."
        ) from None
    return _placed(moved, place)


def _with_poses(doc: Session, skeleton: Skeleton, moved: Callable[[Keyframe], Keyframe]) -> Session:
    """Move every pose. Refused where one comes to lie behind the camera."""
    keyframes, drafts = (tuple(map(moved, poses)) for poses in (doc.keyframes, doc.drafts))
    for pose in (*keyframes, *drafts):
        require_before_camera(skeleton, pose.pose(skeleton))
    return doc.model_copy(update={"keyframes": keyframes, "drafts": drafts})


def _farther(pose: Keyframe, factor: float) -> Keyframe:
    x, y, z = pose.root_m
    return pose.model_copy(update={"root_m": (x * factor, y * factor, z * factor)})


def _turned(doc: Session, skeleton: Skeleton, action: do.Observe) -> Session:
    """Change the axes; the point that all is turned about stays where it is, poses go along."""
    old, about = surface_of(doc), np.array(action.about)
    assert action.up is not None
    place = np.array(old.p_camera_surface)
    R_before = Placement(old.units, old.up, place).R_camera_surface
    R_after = Placement(old.units, action.up, place).R_camera_surface
    R = R_after @ R_before.T

    def turned(keyframe: Keyframe) -> Keyframe:
        pose, root = keyframe.pose(skeleton), skeleton.body.names[0]
        q = quaternion_wxyz(R @ pose.Rs_parent_part[0])  # the root's parent is the camera
        p = about + R @ (pose.p_camera_root - about)
        rotations = {**keyframe.rotations_wxyz, root: tuple(map(float, q))}
        return keyframe.model_copy(
            update={"root_m": tuple(map(float, p)), "rotations_wxyz": rotations}
        )

    return _placed(_with_poses(doc, skeleton, turned), about + R @ (place - about))


def _placed(doc: Session, p_camera_surface: np.ndarray[Any, Any]) -> Session:
    place = [float(v) for v in p_camera_surface]
    return _with_surface(doc, {**surface_of(doc).model_dump(), "p_camera_surface": place})


def _with_surface(doc: Session, values: dict[str, Any]) -> Session:
    try:
        surface = Surface.model_validate(values)
    except ValidationError as error:
        raise ActionRefused(one_sentence(error)) from None
    return doc.model_copy(update={"surface": surface})


def add_mask(state: EditorState, action: do.AddMask) -> Session:
    """One more ignored region."""
    mask = _mask(state, action.polygon, action.first, action.last, "")
    return _with_masks(state, (*state.doc.ignore_masks, mask))


def change_mask(state: EditorState, action: do.ChangeMask) -> Session:
    """Another outline, range or note; what is left out stays."""
    old = _require(state, action.index)
    new = _mask(
        state,
        old.polygon if action.polygon is None else action.polygon,
        old.first_frame if action.first is None else action.first,
        old.last_frame if action.last is None else action.last,
        old.note if action.note is None else action.note,
    )
    masks = list(state.doc.ignore_masks)
    masks[action.index] = new
    return _with_masks(state, tuple(masks))


def delete_mask(state: EditorState, action: do.DeleteMask) -> Session:
    """One ignored region fewer."""
    _require(state, action.index)
    masks = list(state.doc.ignore_masks)
    del masks[action.index]
    return _with_masks(state, tuple(masks))


def set_settings(state: EditorState, action: do.Settings) -> Session:
    """Settings; only the fields that were named change."""
    named = action.model_dump(include=action.model_fields_set - {"do", "stroke"})
    settings = TrackSettings.model_validate({**state.doc.settings.model_dump(), **named})
    return state.doc.model_copy(update={"settings": settings})


def _mask(
    state: EditorState, polygon: tuple[do.Spot, ...], first: int, last: int, note: str
) -> IgnoreMask:
    last = min(last, state.frame_count - 1)
    try:
        return IgnoreMask(polygon=polygon, first_frame=first, last_frame=last, note=note)
    except ValidationError as error:
        raise ActionRefused(one_sentence(error)) from None


def _require(state: EditorState, index: int) -> IgnoreMask:
    if index >= len(state.doc.ignore_masks):
        raise ActionRefused("This mask no longer exists.")
    return state.doc.ignore_masks[index]


def _with_masks(state: EditorState, masks: tuple[IgnoreMask, ...]) -> Session:
    return state.doc.model_copy(update={"ignore_masks": masks})
