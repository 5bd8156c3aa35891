"""The kept poses, as JSON."""

from __future__ import annotations

from dataclasses import astuple

from keypose.app.store.sections.json_value import Json, doc_of
from keypose.app.store.state import AppState


def poses(app_state: AppState) -> Json:
    """Every kept pose with its picture, and whether the present body has any of its parts."""
    doc = doc_of(app_state)
    names = set(doc.body.names) if doc is not None else set()
    return [
        {
            "id": pose.id,
            "name": pose.name,
            "body": pose.copied.body,
            "fits": not names.isdisjoint(pose.copied.keys[0].rotations_wxyz),
            "strokes": [list(astuple(stroke)) for stroke in pose.strokes],
        }
        for pose in app_state.poses
    ]
