"""Edit the camera and how a film was taken: lens, distortion, up, rate."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import ValidationError

from keypose.app.editor import actions as do
from keypose.app.editor.documents import ActionRefused, moved_away, with_times
from keypose.app.editor.state import EditorState
from keypose.app.posing import up_from_vertical
from keypose.tracker.errors import one_sentence
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.schema import LensSource, Session


def read_film(state: EditorState, action: do.ReadFilm) -> Session:
    """Only the fields that were named change."""
    named = action.model_dump(include=action.model_fields_set & {"recorded_fps", "deinterlace"})
    return as_taken(state.doc, named, state.file_times_s)


def as_taken(doc: Session, named: Mapping[str, Any], file_times_s: Array | None = None) -> Session:
    """The session of a film that was taken so; poses keep to their frames. Refused of surfaces.

    file_times_s: not needed where a rate is named.
    """
    if doc.surface is not None:
        raise ActionRefused(
            "This session has surfaces, not a video: it has no recording rate or fields."
        )
    doc = doc.model_copy(update={"video": doc.video.model_copy(update=dict(named))})
    if "recorded_fps" not in named:
        return doc
    return with_times(doc, doc.evidence.times_s(file_times_s))


STRAIGHT = (0.0, 0.0, 0.0, 0.0, 0.0)
BENT = (-0.316, 0.127, 0.0, 0.0, -0.026)
"""Of a lens that spreads angles evenly over the picture (r = f θ), as action cameras do: the fit of
θ / tan θ up to 52° off the axis, to 0.0014."""

_DISTORTION = ("k1", "k2", "p1", "p2", "k3")


def set_intrinsics(state: EditorState, action: do.Intrinsics) -> Session:
    """Focal lengths and principal point."""
    changes = action.model_dump(include={"fx", "fy", "cx", "cy"}, exclude_none=True)
    doc = _with_camera(state, {**changes, "origin": "intrinsics"})
    return doc.model_copy(update={"lens_source": "calibration"})


def set_fov(state: EditorState, action: do.FieldOfView) -> Session:
    """A lens whose longer side spans this angle; the distortion stays."""
    old = state.doc.camera
    new = Camera.from_field_of_view(old.width, old.height, math.radians(action.deg))
    return _with_lens(state, new.model_copy(update={"distortion": old.distortion}), "person")


def set_lens(state: EditorState, action: do.Lens) -> Session:
    """The lens by its focal length on 35 mm film, or a guess."""
    size = (state.doc.camera.width, state.doc.camera.height)
    if action.mm is None:
        camera = Camera.guess(*size)
    else:
        camera = Camera.from_focal_length(*size, action.mm)
    bent = {True: BENT, False: STRAIGHT, None: state.doc.camera.distortion}[action.bent]
    known = "guess" if action.mm is None else action.known
    return _with_lens(state, camera.model_copy(update={"distortion": bent}), known)


def _with_lens(state: EditorState, lens: Camera, source: LensSource) -> Session:
    """Change the lens. What was posed keeps its place in the picture: a longer lens shows it as
    large as before from farther away.
    """
    old = state.doc.camera
    names = ("fx", "fy", "cx", "cy", "distortion", "origin")
    changes = {name: getattr(lens, name) for name in names}
    doc = _with_camera(state, changes)
    farther = 1.0 if old.telephoto_distance_m is not None else lens.fx / old.fx
    return moved_away(doc.model_copy(update={"lens_source": source}), state.skeleton, farther)


def set_distortion(state: EditorState, action: do.Distortion) -> Session:
    """The lens's distortion."""
    wanted = action.model_dump()
    old = dict(zip(_DISTORTION, state.doc.camera.distortion, strict=True))
    values = tuple(old[k] if wanted[k] is None else wanted[k] for k in _DISTORTION)
    return _with_camera(state, {"distortion": values})


def set_up(state: EditorState, action: do.Vertical) -> Session:
    """Up along a line drawn on the picture."""
    if math.dist(action.a, action.b) < 5:
        raise ActionRefused("Draw a longer line along something upright.")
    up = up_from_vertical(state.doc.camera, action.a, action.b)
    if not np.isfinite(up).all():
        raise ActionRefused(
            "The lens shows nothing at one end of this line. Draw it nearer the centre."
        )
    x, y, z = (float(v) for v in up)
    return state.doc.model_copy(update={"up_camera": (x, y, z), "up_from_feet": False})


def reset_up(state: EditorState) -> Session:
    """The camera's own up again."""
    return state.doc.model_copy(update={"up_camera": None, "up_from_feet": False})


def _with_camera(state: EditorState, changes: dict[str, Any]) -> Session:
    try:
        camera = Camera.model_validate({**state.doc.camera.model_dump(), **changes})
    except ValidationError as error:
        raise ActionRefused(one_sentence(error)) from None
    return state.doc.model_copy(update={"camera": camera})
