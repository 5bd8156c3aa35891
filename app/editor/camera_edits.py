"""Edits of the camera: its lens, its distortion, what is up."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pydantic import ValidationError

from app.editor import actions as do
from app.editor.refusal import Refused
from app.editor.state import EditorState
from app.posing import up_from_vertical
from tracker.errors import one_sentence
from tracker.geometry.camera import Camera
from tracker.session.schema import Session

_DISTORTION = ("k1", "k2", "p1", "p2", "k3")


def set_intrinsics(state: EditorState, action: do.Intrinsics) -> Session:
    """Focal lengths and principal point."""
    changes = action.model_dump(include={"fx", "fy", "cx", "cy"}, exclude_none=True)
    return _with_camera(state, {**changes, "origin": "intrinsics"})


def set_fov(state: EditorState, action: do.FieldOfView) -> Session:
    """An ideal lens whose longer side spans this angle; the distortion stays."""
    old = state.doc.camera
    new = Camera.from_field_of_view(old.width, old.height, math.radians(action.deg))
    return _with_camera(
        state,
        {"fx": new.fx, "fy": new.fy, "cx": new.cx, "cy": new.cy, "origin": "field of view"},
    )


def set_distortion(state: EditorState, action: do.Distortion) -> Session:
    """The lens's distortion."""
    wanted = action.model_dump()
    old = dict(zip(_DISTORTION, state.doc.camera.distortion, strict=True))
    values = tuple(old[k] if wanted[k] is None else wanted[k] for k in _DISTORTION)
    return _with_camera(state, {"distortion": values})


def set_up(state: EditorState, action: do.Vertical) -> Session:
    """Up along a line drawn on the picture."""
    if math.dist(action.a, action.b) < 5:
        raise Refused("Draw a longer line along something upright.")
    up = up_from_vertical(state.doc.camera, action.a, action.b)
    if not np.isfinite(up).all():
        raise Refused("The lens shows nothing at one end of this line. Draw it nearer the centre.")
    x, y, z = (float(v) for v in up)
    return state.doc.model_copy(update={"up_camera": (x, y, z)})


def reset_up(state: EditorState) -> Session:
    """The camera's own up again."""
    return state.doc.model_copy(update={"up_camera": None})


def _with_camera(state: EditorState, changes: dict[str, Any]) -> Session:
    try:
        camera = Camera.model_validate({**state.doc.camera.model_dump(), **changes})
    except ValidationError as error:
        raise Refused(one_sentence(error)) from None
    return state.doc.model_copy(update={"camera": camera})
