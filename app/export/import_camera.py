"""A camera from elsewhere brought to a session: its lens, what is up, and the floor."""

from __future__ import annotations

import numpy as np

from keypose.app.editor.documents import moved_away, require_sound
from keypose.tracker.body.heading import CAMERA_UP
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.formats.reading_camera import CameraFile
from keypose.tracker.session.schema import Session

DECIMALS = 6
SAME_DEG, SAME_M = 1e-3, 1e-4
"""What a file's rounding may change: the session then keeps its own, and tracked motion its key."""
LEAST_FLOOR_M = 0.05
"""The floor lies at least this far above or below the camera."""


def with_camera_file(session: Session, found: CameraFile) -> Session:
    """The session with that camera.

    What was posed keeps its place in the picture as far as the focal length goes: a longer lens
    shows it as large as before from farther away. What is as it was stays, so that a camera that
    comes back unchanged outdates no motion. Refused where that cannot be.
    """
    old, new = session.view.camera, found.camera
    telephoto = {old.projection, new.projection} != {"perspective"}
    farther = 1.0 if telephoto else new.fx / old.fx
    seen = session.changed({"lens_source": "calibration", "camera": new})
    if new.model_copy(update={"origin": old.origin}) == old:
        seen = seen.changed({"camera": old})
    turned = seen.with_up(found.up_camera)
    if turned_deg(session, turned) > SAME_DEG:
        seen = turned
    floor_m = found.floor_m
    if floor_m is not None and abs(floor_m) >= LEAST_FLOOR_M and not _is_near(floor_m, session):
        seen = seen.changed({"floor_m": round(floor_m, DECIMALS)})
    made = moved_away(seen, Skeleton.of(session.subject.body), farther)
    require_sound(session, made, "import the camera")
    return made


def turned_deg(session: Session, made: Session) -> float:
    """Return by how much what is up has changed, degrees."""
    before, after = (np.array(s.world.up_world or CAMERA_UP) for s in (session, made))
    cosine = before @ after / np.linalg.norm(before) / np.linalg.norm(after)
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def _is_near(floor_m: float, session: Session) -> bool:
    return session.world.floor_m is not None and abs(session.world.floor_m - floor_m) < SAME_M
