"""The views of the page as a session's camera and up direction make them."""

from __future__ import annotations

from keypose.app.posing import CAMERA_UP, Eye, PointerView, eye_rotation, view_rotations
from keypose.tracker.session.schema import Session


def up_of(doc: Session) -> tuple[float, float, float]:
    """The world's up direction in the camera frame."""
    return CAMERA_UP if doc.up_camera is None else doc.up_camera


def pointer_views(doc: Session, eye: Eye | None = None) -> dict[str, PointerView]:
    """main, top, side and front; with an eye also free."""
    views: dict[str, PointerView] = {"main": PointerView.of(doc.camera)}
    rotations = view_rotations(up_of(doc))
    for name, R in rotations.items():
        views[name] = PointerView.parallel(name, R)
    if eye is not None:
        R = eye_rotation(eye.azimuth_deg, eye.elevation_deg) @ rotations["front"]
        views["free"] = PointerView.free(R, eye.at_m)
    return views
