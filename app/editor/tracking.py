"""Edit what tracking is given: regions, settings, and how surfaces are read and fitted."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

import numpy as np
from pydantic import Field, FiniteFloat

from keypose.app.editor.documents import (
    ActionRefused,
    require_all_before_camera,
    seen_as_before,
    valid,
    with_poses,
    with_times,
)
from keypose.app.editor.message import Edit
from keypose.app.editor.shown import find
from keypose.app.editor.state import EditorState
from keypose.app.posing.gesture import Metres, Spot
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import quaternion_wxyz
from keypose.tracker.session.evidence import surface_of
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.references import Surface
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import (
    ALL_CUES,
    Cues,
    FrameIndex,
    IgnoreMask,
    MethodName,
    NetworkName,
    Quality,
    TrackSettings,
    Units,
    UpAxis,
    Weights,
)
from keypose.tracker.surface.placing import METRES, Placement

MaskIndex: TypeAlias = Annotated[int, Field(ge=0, le=10_000)]
Polygon: TypeAlias = Annotated[tuple[Spot, ...], Field(min_length=3, max_length=500)]


class Observe(Edit):
    """How observed surfaces are read and fitted. Fields that are left out stay; `model_frame` may
    be null, the first keyframe. about: the point, camera frame, that other axes turn about."""

    do: Literal["observe"] = "observe"
    verb = "change the surfaces"
    units: Units | None = None
    up: UpAxis | None = None
    about: tuple[Metres, Metres, Metres] = (0.0, 0.0, 0.0)
    fps: Annotated[FiniteFloat, Field(ge=0.001, le=10_000)] | None = None
    model_frame: FrameIndex | None = None
    weights: Weights | None = None
    distance: Literal["plane", "point"] | None = None
    binding: Literal["nearest", "smooth"] | None = None

    def apply(self, state: EditorState) -> Session:
        doc, before = state.doc, state.doc.view.surface
        if before is None:
            raise ActionRefused("This session has a video, not surfaces.")
        named = self.model_dump(include=self.model_fields_set - {"do", "stroke", "about"})
        named = {name: v for name, v in named.items() if v is not None or name == "model_frame"}
        frame = named.get("model_frame")
        if frame is not None and find(doc.subject.keyframes, frame) is None:
            raise ActionRefused(
                f"Frame {frame} is not a keyframe. Pose the body in its surface first."
            )
        if "units" in named:
            doc = _scaled(state, METRES[named["units"]] / METRES[before.units])
        if "up" in named:
            doc = _turned(doc, state.skeleton, self)
        doc = _with_surface(doc, **named)
        return with_times(doc, doc.evidence.times_s(None)) if "fps" in named else doc


class AddMask(Edit):
    do: Literal["add_mask"] = "add_mask"
    verb = "draw a mask"
    polygon: Polygon
    first: FrameIndex
    last: FrameIndex

    def apply(self, state: EditorState) -> Session:
        mask = _mask(state, polygon=self.polygon, first_frame=self.first, last_frame=self.last)
        return _with_masks(state, [*state.doc.view.ignore_masks, mask])


class ChangeMask(Edit):
    """Another outline, range or note; what is left out stays."""

    do: Literal["change_mask"] = "change_mask"
    verb = "change a mask"
    index: MaskIndex
    polygon: Polygon | None = None
    first: FrameIndex | None = None
    last: FrameIndex | None = None
    note: Annotated[str, Field(max_length=200)] | None = None

    def apply(self, state: EditorState) -> Session:
        old, masks = _require(state, self.index), list(state.doc.view.ignore_masks)
        changes = {"polygon": self.polygon, "first_frame": self.first, "last_frame": self.last}
        named = {name: v for name, v in {**changes, "note": self.note}.items() if v is not None}
        masks[self.index] = _mask(state, **{**old.model_dump(), **named})
        return _with_masks(state, masks)


class DeleteMask(Edit):
    do: Literal["delete_mask"] = "delete_mask"
    verb = "delete a mask"
    index: MaskIndex

    def apply(self, state: EditorState) -> Session:
        _require(state, self.index)
        masks = list(state.doc.view.ignore_masks)
        del masks[self.index]
        return _with_masks(state, masks)


class Settings(Edit):
    """Fields that are left out stay; `static_camera` may be given as null, as it was found, and
    `smooth`, not."""

    do: Literal["settings"] = "settings"
    verb = "change the settings"
    method: MethodName | None = None
    quality: Quality | None = None
    static_camera: bool | None = None
    smooth: bool | None = None
    cues: Annotated[Cues, Field(max_length=len(ALL_CUES))] | None = None
    network: NetworkName | None = None

    def apply(self, state: EditorState) -> Session:
        named = self.model_dump(include=self.model_fields_set - {"do", "stroke"})
        settings = TrackSettings.model_validate({**state.doc.settings.model_dump(), **named})
        after = state.doc.changed({"settings": settings})
        if after.camera_path is state.doc.camera_path:
            return after
        return seen_as_before(state.doc, after)


MESSAGES = (Observe, AddMask, ChangeMask, DeleteMask, Settings)


def _scaled(state: EditorState, factor: float) -> Session:
    """Everything so much farther away: then it is seen where it was, as large as it was."""
    doc = state.doc
    place = np.array(surface_of(doc).p_camera_surface) * factor
    try:
        moved = with_poses(doc, lambda pose: _farther(pose, factor))
        require_all_before_camera(moved, state.skeleton)
    except ActionRefused:
        raise ActionRefused(
            "In these units the surface is so small that the body would be at the camera. "
            "Delete its poses first, or reopen the meshes with other units."
        ) from None
    return _with_surface(moved, p_camera_surface=place.tolist())


def _farther(pose: Keyframe, factor: float) -> Keyframe:
    x, y, z = pose.root_m
    return pose.model_copy(update={"root_m": (x * factor, y * factor, z * factor)})


def _turned(doc: Session, skeleton: Skeleton, action: Observe) -> Session:
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

    moved = require_all_before_camera(with_poses(doc, turned), skeleton)
    turned_place = about + R @ (place - about)
    return _with_surface(moved, p_camera_surface=turned_place.tolist())


def _with_surface(doc: Session, **changes: Any) -> Session:
    surface = valid(Surface, {**surface_of(doc).model_dump(), **changes})
    return doc.changed({"surface": surface})


def _mask(state: EditorState, **values: Any) -> IgnoreMask:
    last = min(values["last_frame"], state.frame_count - 1)
    return valid(IgnoreMask, {**values, "last_frame": last})


def _require(state: EditorState, index: int) -> IgnoreMask:
    if index >= len(state.doc.view.ignore_masks):
        raise ActionRefused("This mask no longer exists.")
    return state.doc.view.ignore_masks[index]


def _with_masks(state: EditorState, masks: list[IgnoreMask]) -> Session:
    return state.doc.changed({"ignore_masks": tuple(masks)})
