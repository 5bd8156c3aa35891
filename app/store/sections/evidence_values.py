"""Give what the body is compared with as JSON: cues, keypoints, observed surfaces."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import PurePath
from typing import Any, Final

import numpy as np

from keypose.app.editor.state import EditorState
from keypose.app.orders.drawing import Tint
from keypose.app.posing import part_label
from keypose.app.render.tints import LEGENDS, css_stops
from keypose.app.state.app_state import AppState
from keypose.app.store.sections.json_value import Json, doc_of
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.model_files import (
    MODELS,
    Model,
    added_models,
    adding,
    adding_own,
)
from keypose.tracker.keypoints.on_body import HEAD_POINTS, is_persons, points_on_body
from keypose.tracker.session.annotations import KeypointCorrection
from keypose.tracker.session.evidence import surface_of
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import ALL_CUES, LEADING_CUES, Cue, TrackSettings
from keypose.tracker.storage.fingerprints import needs_masks, shows_background
from keypose.tracker.storage.pace import seconds_a_frame

_TITLES: Final[Mapping[str, str]] = {
    "brightness": "Follow how the body’s brightness moves from frame to frame",
    "keypoints": "Compare the body’s joints with those found in each frame",
    "depth": "Lift the joints’ depth from a second of keypoints around each frame",
    "silhouette": "Compare where the body is with what moves, or where a network sees the person",
}
_PERSONS: Final[tuple[Cue, ...]] = ("keypoints", "depth")
"""Those that only a person's body can be compared with."""


def cues(app_state: AppState) -> Json:
    """Every cue there is: whether it is chosen, and why it does not count here."""
    doc = doc_of(app_state)
    if doc is None:
        return []
    return [
        {
            "id": cue,
            "label": part_label(cue),
            "title": _TITLES.get(cue, ""),
            "on": cue in doc.settings.cues_used,
            "off": _why_off(doc, cue),
            "leads": cue in LEADING_CUES,
        }
        for cue in ALL_CUES
    ]


def _why_off(doc: Session, cue: Cue) -> str:
    """Why a cue does not count here, whatever is chosen; or empty."""
    if cue == "brightness":
        return ""
    if cue in _PERSONS and not is_persons(doc.subject.body):
        return "Needs a person’s body"
    if doc.settings.method == "paper":
        return "Not in the published method"
    if cue == "depth" and "keypoints" not in doc.settings.cues_used:
        return "Needs keypoints"
    if cue == "silhouette" and not (shows_background(doc) or is_persons(doc.subject.body)):
        return "Needs a person’s body, or a camera that stands still or turns"
    return ""


def networks_here(_app_state: AppState) -> tuple[Any, ...]:
    """Which networks are on the disk: one can be added while the page is open; and how long
    a frame of a draft takes by each, where it is known."""
    models = (*MODELS, *added_models())
    return tuple((model, model.is_here, seconds_a_frame(model.name)) for model in models)


def networks(app_state: AppState) -> Json:
    """The networks that find keypoints: which is chosen, and how to add one that is not here."""
    doc, opened = doc_of(app_state), app_state.opened
    chosen = (doc.settings if doc else TrackSettings()).network_used
    fps = 0.0 if doc is None or opened is None or needs_masks(doc) else opened.info.fps
    choices = [
        {
            "id": model.name,
            "label": network_label(model),
            "mb": model.size_mb,
            "chosen": model.name == chosen,
            "of_animals": model.of_animals,
            "remedy": "" if is_here else adding(model),
            "frame_s": frame_s and frame_s / (2 if model.skips_frames_at(fps) else 1),
        }
        for model, is_here, frame_s in networks_here(app_state)
    ]
    if not any(each["chosen"] for each in choices):
        unknown = {"id": chosen, "label": chosen, "mb": 0.0, "chosen": True, "frame_s": None}
        choices.append({**unknown, "of_animals": False, "remedy": adding_own(chosen)})
    return choices


def network_label(model: Model) -> str:
    """What a choice of network is called."""
    if model.of_animals:
        return f"{model.name} (animals)"
    if model.heads is None:
        return f"BlazePose {model.name}"
    return f"{_CALLED.get(model.name, model.name)} + BlazePose"


_CALLED: Final = {"thunder": "MoveNet Thunder"}

SHOWN: Final = (*JOINTS, *HEAD_POINTS, "right_ear")
"""Keypoints that the page shows; `HEAD_POINTS` has the left ear alone, whose mirror image is the
right one."""


def keypoints(app_state: AppState) -> Json:
    """Where each is, in pixels of the main view, how sure that is, and what a person said of
    it; null where nothing is known of this frame.

    Of an ignored one it is given where it was found, so that it can be put back.
    """
    edit = app_state.edit
    if edit is None or edit.doc.view.surface is not None:
        return None
    detected = app_state.keypoints.at(edit.frame)
    said = {c.joint: c for c in edit.doc.view.keypoint_corrections if c.frame == edit.frame}
    if detected is None and not said:
        return None
    on_body = points_on_body(edit.doc.subject.body, SHOWN).indices
    names = [SHOWN[k] for k in on_body]
    at = {name: k for k, name in enumerate(detected.names)} if detected is not None else {}
    points = []
    for name in names:
        uv, sure = np.full(2, np.nan), 0.0
        if detected is not None and name in at:
            uv, sure = detected.uv[0, at[name]], float(detected.visibility[0, at[name]])
        points.append(_point(name, uv, sure, said.get(name), edit.camera))
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


def surface(app_state: AppState) -> Json:
    """None where the session has no surfaces."""
    edit, surface_seen = app_state.edit, app_state.surface
    if edit is None or not edit.doc.evidence.has_surface:
        return None
    session_surface, model = surface_of(edit.doc), edit.doc.model_keyframe
    return {
        **session_surface.model_dump(
            include={"units", "up", "fps", "weights", "distance", "binding"}
        ),
        "cameras": PurePath(session_surface.cameras).name if session_surface.cameras else None,
        "model_frame": None if model is None else model.frame,
        "problem": surface_seen.problem if surface_seen.frame == edit.frame else "",
        "unusable": app_state.unusable,
        "faces": surface_seen.faces,
        "middle": None if surface_seen.middle is None else list(surface_seen.middle),
        "rims": surface_seen.rims,
        "tints": [_tint(app_state, kind) for kind in LEGENDS],
        "ramp": css_stops(),
    }


def _tint(app_state: AppState, kind: Tint) -> Json:
    legend = LEGENDS[kind]
    return {
        "id": kind,
        "label": legend.label,
        "title": legend.title,
        "low": legend.clay,
        "high": legend.plum,
        "off": _unavailable(app_state, kind),
    }


def _unavailable(app_state: AppState, kind: Tint) -> str:
    """Why a surface cannot be coloured so, or ''."""
    assert app_state.edit is not None
    if kind == "photo":
        return "" if app_state.surface.photo else "These surfaces come without pictures of cameras"
    posed = kind == "clay" or bool(app_state.edit.doc.subject.keyframes)
    return "" if posed else "Pose the first keyframe first"


def surface_version(edit: EditorState) -> str:
    """What pictures of the surfaces differ by: where they lie, and what colours them.

    A gesture under way does not count, nor do poses that a fit is still on its way to.
    """
    doc = edit.settled
    if not doc.evidence.has_surface:
        return ""
    session_surface, camera = surface_of(doc), doc.view.camera
    made_of: list[object] = [
        session_surface.units,
        session_surface.up,
        session_surface.p_camera_surface,
    ]
    made_of += [session_surface.cameras, session_surface.cameras_fingerprint]
    made_of += [camera.fx, camera.fy, camera.cx, camera.cy]
    kind = edit.display.tint
    if kind in ("contact", "distance"):
        fitting = edit.results.fitting(doc)
        done = [track for track in fitting.values() if track.finished]
        result_keys = sorted(f"{t.key}{t.quality}{t.missing}" for t in done)
        made_of += [
            session_surface,
            doc.subject.keyframes,
            doc.subject.drafts,
            doc.subject.body,
            result_keys,
        ]
    made_of.append(kind)
    return hashlib.sha256(repr(made_of).encode()).hexdigest()[:16]
