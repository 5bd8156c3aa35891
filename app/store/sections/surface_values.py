"""Observed surfaces, as JSON: how they are read and fitted, what is seen of them, their colours."""

from __future__ import annotations

import hashlib
from pathlib import PurePath

from keypose.app.editor.state import EditorState
from keypose.app.render.tints import LEGENDS, Tint, css_stops
from keypose.app.store.sections.json_value import Json
from keypose.app.store.state import AppState
from keypose.tracker.session.evidence import surface_of


def surface(app_state: AppState) -> Json:
    """None where the session has no surfaces."""
    edit, seen = app_state.edit, app_state.surface
    if edit is None or not edit.doc.evidence.has_surface:
        return None
    given, model = surface_of(edit.doc), edit.doc.model_keyframe
    return {
        **given.model_dump(include={"units", "up", "fps", "weights", "distance", "binding"}),
        "cameras": PurePath(given.cameras).name if given.cameras else None,
        "model_frame": None if model is None else model.frame,
        "problem": seen.problem if seen.frame == edit.frame else "",
        "unusable": app_state.unusable,
        "faces": seen.faces,
        "middle": None if seen.middle is None else list(seen.middle),
        "rims": seen.rims,
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
    posed = kind == "clay" or bool(app_state.edit.doc.keyframes)
    return "" if posed else "Pose the first keyframe first"


def surface_version(edit: EditorState) -> str:
    """What pictures of the surfaces differ by: where they lie, and what colours them.

    A gesture under way does not count, nor do poses that a fit is still on its way to.
    """
    doc = edit.settled
    if not doc.evidence.has_surface:
        return ""
    given, camera = surface_of(doc), doc.camera
    made_of: list[object] = [given.units, given.up, given.p_camera_surface]
    made_of += [given.cameras, given.cameras_fingerprint]
    made_of += [camera.fx, camera.fy, camera.cx, camera.cy]
    kind = edit.display.tint
    if kind in ("contact", "distance"):
        fitting = edit.results.fitting(doc)
        done = [track for track in fitting.values() if track.finished]
        found = sorted(f"{t.key}{t.quality}{t.missing}" for t in done)
        made_of += [given, doc.keyframes, doc.drafts, doc.body, found]
    made_of.append(kind)
    return hashlib.sha256(repr(made_of).encode()).hexdigest()[:16]
