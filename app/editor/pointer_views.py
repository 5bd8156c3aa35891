"""The four views of a document, as posing needs them."""

from __future__ import annotations

from app.posing import CAMERA_UP, PointerView, view_rotations
from tracker.session.schema import Session


def up_of(doc: Session) -> tuple[float, float, float]:
    """The world's up direction in the camera frame."""
    return CAMERA_UP if doc.up_camera is None else doc.up_camera


def pointer_views(doc: Session) -> dict[str, PointerView]:
    """main, top, side and front."""
    views: dict[str, PointerView] = {"main": PointerView.of(doc.camera)}
    for name, R in view_rotations(up_of(doc)).items():
        views[name] = PointerView.parallel(name, R)
    return views
