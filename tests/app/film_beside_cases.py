"""A session with a second film of its motion, beside whatever its first is."""

from __future__ import annotations

from typing import Any

import numpy as np

from keypose.tracker.geometry.rotations import quaternion_wxyz, rotation_from_euler
from keypose.tracker.session import Session
from keypose.tracker.session.views import Clock, View

ID = "film-2"
R_SIDE = rotation_from_euler(0.05, np.radians(60.0), 0.08)
MIDDLE = np.array([0.3, -0.1, 5.4])
"""Where the person of the sample stands at frame 24, before both cameras, metres."""


def beside(session: Session, clock: Clock, **changes: Any) -> View:
    """The first film once more, as if it was taken from the side at another time."""
    there = {
        "id": ID,
        "clock": clock,
        "R_camera_world_wxyz": tuple(float(q) for q in quaternion_wxyz(R_SIDE)),
        "p_camera_world": tuple(float(p) for p in MIDDLE - R_SIDE @ MIDDLE),
        "camera_motion": None,
        "keypoints": None,
    }
    return session.view.model_copy(update=there | changes)


def with_film(session: Session, clock: Clock | None = None, **changes: Any) -> Session:
    """The session with that film."""
    film = beside(session, clock or Clock(begins=3.4, sigma=0.1, also=(31.5,)), **changes)
    after = session.model_copy(update={"views": (*session.views, film)})
    return Session.model_validate(after.model_dump())
