"""Give the other films of a session as JSON: their frame of the present moment and their camera."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from keypose.app.editor.motion import known_motion
from keypose.app.state.app_state import AppState
from keypose.app.store.sections.json_value import Json
from keypose.app.words.films import film_words
from keypose.tracker.body.trajectory import runs
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.review.places import review_of
from keypose.tracker.session.between_views import T_film_first, frame_in, lens_in
from keypose.tracker.session.schema import Session
from keypose.tracker.session.views import View

MOST_MOMENTS = 1500
"""Of a long motion, at which it is told which film sees it."""
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


def films_seen(app_state: AppState) -> Json:
    """Which film sees the selected part, or the body, and where films disagree of it, in runs of
    frames, the first film among them; and in which film each place of the review is looked at. Null
    where there is one film, or no motion."""
    edit, keypoints = app_state.edit, app_state.keypoints
    if edit is None or len(edit.doc.views) == 1:
        return None
    doc = edit.settled
    body, motion, of_films = (
        doc.subject.body,
        known_motion(edit, MOST_MOMENTS),
        keypoints.by_view(doc),
    )
    if motion is None or not of_films or not is_persons(body):
        return None
    from keypose.tracker.operations.seen_by import seen_by  # loads scipy

    by_films = seen_by(doc, of_films, motion.frames, motion.Ts_world_part)
    index = {name: number for number, name in enumerate(body.names)}
    joints = by_films.of_part(index.get(edit.selected or ""))
    joints = joints if joints.any() else by_films.of_part(None)
    places = review_of(doc, edit.results).places
    chosen = {each.id: by_films.best_at(each.frame, index.get(each.part or "")) for each in places}
    sees = by_films.sees(joints)
    return {
        "seen": {
            view: _runs(by_films.frames, row)
            for view, row in zip(by_films.views, sees, strict=True)
        },
        "disagree": _runs(by_films.frames, by_films.disagree(joints)),
        "places": {name: view for name, view in chosen.items() if view is not None},
    }


def _runs(frames: NDArray[np.int64], flags: NDArray[np.bool_]) -> list[Json]:
    """First and last frame of every run of moments at which something is so; a thinned moment
    stands for those up to the next one."""
    stops = np.append(frames[1:], frames[-1] + 1)
    return [[int(frames[a]), int(stops[b]) - 1] for a, b in runs(flags)]


_OF_LENS = {"width", "height", "fx", "fy", "cx", "cy", "projection", "telephoto_distance_m"}
"""What a picture without distortion is drawn by."""


def film_version(view: View) -> str:
    """What pictures of a view's film are named by, as `image_version` names those of the first."""
    camera = view.camera
    lens = (camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion)
    video = view.video.fingerprint or view.video.path
    made_of = (video, lens if camera.is_distorted else (), view.video.deinterlace)
    return hashlib.sha256(repr(made_of).encode()).hexdigest()[:16]
