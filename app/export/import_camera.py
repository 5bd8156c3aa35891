"""A camera from elsewhere brought to a session: its lens, what is up, and the floor."""

from __future__ import annotations

import numpy as np

from app.editor.documents import moved_away, require_sound
from tracker.body.skeleton import Skeleton
from tracker.formats.reading_camera import CameraFile
from tracker.session.schema import Session

DECIMALS = 6
LEAST_FLOOR_M = 0.05
"""The floor lies at least this far above or below the camera."""


def with_camera_file(session: Session, found: CameraFile) -> Session:
    """The session with that camera.

    What was posed keeps its place in the picture as far as the focal length goes: a longer lens
    shows it as large as before from farther away. Refused where that cannot be.
    """
    old, new = session.camera, found.camera
    telephoto = {old.projection, new.projection} != {"perspective"}
    farther = 1.0 if telephoto else new.fx / old.fx
    x, y, z = (round(float(v), DECIMALS) + 0.0 for v in found.up_camera)
    update = {"camera": new, "lens_source": "calibration", "up_camera": (x, y, z)}
    if found.floor_m is not None and abs(found.floor_m) >= LEAST_FLOOR_M:
        update["floor_m"] = round(found.floor_m, DECIMALS)
    update["up_from_feet"] = False
    seen = session.model_copy(update=update)
    made = moved_away(seen, Skeleton.of(session.body), farther)
    require_sound(session, made, "import the camera")
    return made


def turned_deg(session: Session, made: Session) -> float:
    """By how much what is up has changed, degrees."""
    before, after = (np.array(s.up_camera or (0.0, -1.0, 0.0)) for s in (session, made))
    cosine = before @ after / np.linalg.norm(before) / np.linalg.norm(after)
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))
