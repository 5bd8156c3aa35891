"""A session with a second film of its motion, beside whatever its first is, and what is seen in
both."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import quaternion_wxyz, rotation_from_euler
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.session import Session
from keypose.tracker.session.between_views import T_film_first
from keypose.tracker.session.views import Clock, View
from keypose.tracker.storage.sidecars import save_keypoints

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


def seen_of(doc: Session, pose: Pose, frame: int = 10) -> dict[str, Keypoints]:
    """What an exact detector says of a body that stands still so, in all films: by the view's id.

    pose: in the frame of the first camera at a frame.
    """
    index, parts, points = points_on_body(doc.subject.body, JOINTS)
    T = pose_transforms(Skeleton.of(doc.subject.body), pose)[parts]
    p = np.einsum("kab,kb->ka", T[:, :3, :3], points) + T[:, :3, 3]
    keypoints = {}
    for view in doc.views:
        T_film = T_film_first(doc, view, frame)
        uv = np.full((view.video.frame_count, len(JOINTS), 2), np.nan)
        uv[:, index] = view.camera.project(p @ T_film[:3, :3].T + T_film[:3, 3])
        keypoints[view.id] = Keypoints(0, JOINTS, uv, np.ones(uv.shape[:2]))
    return keypoints


def saved_in(folder: Path, doc: Session, keypoints: Mapping[str, Keypoints]) -> Session:
    """The session with the keypoints of its films, which are written beside its file."""
    views = []
    for view in doc.views:
        alone = save_keypoints(
            doc.alone(view.id), folder / "session.json", keypoints[view.id], "a detector"
        )
        views.append(view.model_copy(update={"keypoints": alone.view.keypoints}))
    return doc.model_copy(update={"views": tuple(views)})
