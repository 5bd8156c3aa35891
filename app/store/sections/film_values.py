"""Give the other films of a session as JSON: their frame of the present moment and their camera."""

from __future__ import annotations

import hashlib
from pathlib import Path

from keypose.app.state.app_state import AppState
from keypose.app.store.sections.json_value import Json
from keypose.app.words.films import film_words
from keypose.tracker.session.between_views import T_film_first, frame_in, lens_in
from keypose.tracker.session.schema import Session
from keypose.tracker.session.views import View

DECIMALS = 6
"""Of metres, and of a rotation's numbers."""


def films(app_state: AppState) -> Json:
    """Every view after the first, as it is at the present frame."""
    edit = app_state.edit
    if edit is None:
        return []
    return [_film(edit.doc, view, edit.frame) for view in edit.doc.views[1:]]


def _film(doc: Session, view: View, frame: int) -> Json:
    clock, own = view.clock, frame_in(view, frame)
    last = view.video.frame_count - 1
    lens = lens_in(doc, view, frame)
    T = T_film_first(doc, view, frame)
    return {
        "id": view.id,
        "name": Path(view.video.path).name,
        "frames": view.video.frame_count,
        "frame": own if 0 <= own <= last else None,
        "begins": view.film_clock.begins,
        "rate": view.film_clock.rate,
        "sigma": None if clock is None else clock.sigma,
        "also": [] if clock is None else list(clock.also),
        "words": film_words(view),
        "camera": lens.model_dump(include=_OF_LENS),
        "T": (T[:3].reshape(12).round(DECIMALS) + 0.0).tolist(),
        "image_version": film_version(view),
    }


_OF_LENS = {"width", "height", "fx", "fy", "cx", "cy", "projection", "telephoto_distance_m"}
"""What a picture without distortion is drawn by."""


def film_version(view: View) -> str:
    """What pictures of a view's film are named by, as `image_version` names those of the first."""
    camera = view.camera
    lens = (camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion)
    video = view.video.fingerprint or view.video.path
    made_of = (video, lens if camera.is_distorted else (), view.video.deinterlace)
    return hashlib.sha256(repr(made_of).encode()).hexdigest()[:16]
