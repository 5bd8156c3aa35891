"""What tracking compares the body with, and the networks that find keypoints, as JSON."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from keypose.app.posing import part_label
from keypose.app.store.sections.json_value import Json, doc_of
from keypose.app.store.state import AppState
from keypose.tracker.keypoints.model_files import FULL, MODELS
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import ALL_CUES, Cue

_TITLES: Final[Mapping[str, str]] = {
    "brightness": "Follow how the body’s brightness moves from frame to frame",
    "keypoints": "Compare the body’s joints with those found in each frame",
    "silhouette": "Compare where the body is with what moves before the background",
}
_PERSONS: Final[tuple[Cue, ...]] = ("keypoints",)
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
            "leads": cue != "silhouette",
        }
        for cue in ALL_CUES
    ]


def _why_off(doc: Session, cue: Cue) -> str:
    """Why a cue does not count here, whatever is chosen; or empty."""
    if cue == "brightness":
        return ""
    if cue in _PERSONS and not is_persons(doc.body):
        return "Needs a person’s body"
    if doc.settings.method == "paper":
        return "Not in the published method"
    if cue == "silhouette" and not doc.has_static_camera:
        return "Needs a still camera"
    return ""


def networks_here(_app_state: AppState) -> tuple[Any, ...]:
    """Which networks are on the disk: one can be added while the page is open."""
    return tuple(model.is_here for model in MODELS)


def networks(app_state: AppState) -> Json:
    """The networks that find keypoints: which is chosen, and how to add one that is not here."""
    doc = doc_of(app_state)
    chosen = (doc.settings.network if doc else None) or FULL.name
    return [
        {
            "id": model.name,
            "label": part_label(model.name),
            "mb": model.size_mb,
            "chosen": model.name == chosen,
            "remedy": "" if model.is_here else f"keypose models add {model.name}",
        }
        for model in MODELS
    ]
