"""The motion in space as the free view draws it, as JSON. Points are metres, camera frame."""

from __future__ import annotations

from keypose.app.editor.feet import feet_paths
from keypose.app.editor.shown import find
from keypose.app.posing import part_label
from keypose.app.store.sections.body_values import side_of
from keypose.app.store.sections.json_value import Json, doc_of
from keypose.app.store.state import AppState
from keypose.tracker.body.pose import pose_transforms


def feet(app_state: AppState) -> Json:
    """The floor, and the ways of the feet."""
    edit = app_state.edit
    if edit is None:
        return None
    found = feet_paths(edit)
    body = edit.settled.body
    return {
        "floor_m": round(found.floor_m, 4),
        "frames": found.frames.tolist(),
        "paths": [
            {
                "part": part,
                "label": part_label(part),
                "side": side_of(body, part),
                "points": path.round(4).tolist(),
            }
            for part, path in found.paths.items()
        ],
    }


def ghosts(app_state: AppState) -> Json:
    """Where the parts stand at the keyframes before and after the present frame."""
    edit = app_state.edit
    if edit is None or not edit.display.ghosts or edit.doc.body is not edit.settled.body:
        return []
    before = [key for key in edit.keys if key < edit.frame][-1:]
    after = [key for key in edit.keys if key > edit.frame][:1]
    found = []
    for frame in (*before, *after):
        keyframe = find(edit.settled.keyframes, frame)
        if keyframe is not None:
            Ts = pose_transforms(edit.skeleton, keyframe.pose(edit.skeleton))
            rows = Ts[:, :3].reshape(-1, 12).round(4).tolist()
            found.append({"frame": frame, "T": dict(zip(edit.doc.body.names, rows, strict=True))})
    return found


def solids(app_state: AppState) -> Json:
    """Points of every part's convex surface, in its own frame."""
    doc = doc_of(app_state)
    if doc is None:
        return None
    return {part.name: part.shape.mesh().vertices.round(4).tolist() for part in doc.body.parts}
