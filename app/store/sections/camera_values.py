"""Give the motion of the camera as JSON: how it moves, how surely, where it was."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Final

import numpy as np

from keypose.app.state.app_state import AppState
from keypose.app.store.sections.json_value import Json, doc_of
from keypose.app.words.camera import camera_sentence, finding_sentence
from keypose.app.words.up import SIGMAS_SAID
from keypose.tracker.geometry.camera_path import CameraPath, rigid_inverse
from keypose.tracker.session.camera_motion import CameraMotion, CameraWay

if TYPE_CHECKING:
    from keypose.tracker.camera_motion import FollowedPoints

MOST_PLACES: Final = 240
"""At which the camera is drawn along its path."""


def camera_motion(app_state: AppState) -> Json:
    """How the camera moves: null where it stands still or nobody looked."""
    doc = doc_of(app_state)
    if doc is None or doc.view.camera_motion is None:
        return None
    motion, path = doc.view.camera_motion, doc.camera_path
    errors = motion.errors_px
    usual = float(np.nanmedian(errors)) if np.isfinite(errors).any() else None
    return {
        "kind": motion.kind,
        "source": motion.source,
        "counts": path is not None,
        "words": camera_sentence(motion.kind, motion.path.zooms, usual),
        "ways": [] if motion.kind != "moves" else [_way(camera_way) for camera_way in motion.ways],
        "error_px": [None if np.isnan(e) else round(float(e), 3) for e in errors],
        "keys": [keyframe.frame for keyframe in doc.view.camera_keyframes],
        "findings": [
            {
                "kind": camera_finding.kind,
                "first": camera_finding.first_frame,
                "last": camera_finding.last_frame,
                "words": finding_sentence(camera_finding),
            }
            for camera_finding in (*motion.findings, *motion.unscaled)
        ],
        "path": None if path is None else _places(path),
    }


def _way(camera_way: CameraWay) -> Json:
    """How far the camera went from where it was as a piece begins, and what is said as ±."""
    far, sigma = camera_way.farthest_m, camera_way.sigma
    off = None if far is None or sigma is None else SIGMAS_SAID * sigma * far
    return {
        "first": camera_way.first_frame,
        "last": camera_way.last_frame,
        "metres": None if far is None else float(f"{far:.3g}"),
        "off_m": None if off is None else float(f"{off:.1g}"),
    }


def _places(path: CameraPath) -> Json:
    """Frames at which the camera is drawn, and T_world_camera (3, 4) there, by rows."""
    frames = np.unique(np.linspace(0, len(path) - 1, MOST_PLACES).round().astype(int))
    rows = path.Ts_world_camera[frames, :3].reshape(-1, 12).round(5).tolist()
    return {"frames": frames.tolist(), "T": rows, "zoom": path.zoom[frames].round(4).tolist()}


def camera_here(app_state: AppState) -> Json:
    """T_world_camera (3, 4) of the present frame, by rows."""
    edit = app_state.edit
    if edit is None:
        return None
    T = rigid_inverse(edit.doc.film_camera.T_camera_world(edit.frame))
    return list((T[:3].reshape(12).round(6) + 0.0).tolist())


def background_points(app_state: AppState) -> Json:
    """The points of the background at the present frame, pixels of the rectified picture, while
    they are shown; null where nobody kept them."""
    edit = app_state.edit
    if edit is None or not edit.display.background or edit.doc.view.camera_motion is None:
        return None
    points = _points(edit.doc.view.camera_motion)
    if points is None:
        return None
    pixels, good = points.of(edit.frame)
    uv = pixels.astype(np.float64)
    camera = edit.doc.view.camera
    if camera.is_distorted:
        ideal = camera.without_distortion()
        uv = ideal.project(camera.back_project(uv, 1.0))
    return {"uv": np.round(uv, 1).tolist(), "good": good.tolist()}


@lru_cache(maxsize=1)
def _points(motion: CameraMotion) -> FollowedPoints | None:
    from keypose.tracker.operations.find_camera import points_of  # loads what only this needs

    return points_of(motion)
