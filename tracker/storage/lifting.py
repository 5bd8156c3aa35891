"""What lifts the depth of a session's keypoints."""

from __future__ import annotations

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.lifted_depth import DepthLifter
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.session.schema import Session


def lifts_depth(session: Session) -> bool:
    """Whether the depth of keypoints is lifted from what is seen around a frame."""
    settings = session.settings
    wanted = settings.method == "keypose" and {"keypoints", "depth"} <= set(settings.cues_used)
    return wanted and is_persons(session.subject.body)


def depth_lifter(session: Session, file_times_s: Array, *, up: bool = False) -> DepthLifter:
    """What lifts keypoints of a session's film.

    file_times_s: (frames,) of the file.  up: whether it is told what is up, where that is known.
    """
    times_s = session.evidence.times_s(file_times_s)
    return DepthLifter(session.view.camera, times_s, _up_camera(session) if up else None)


def _up_camera(session: Session) -> Array | None:
    """What is up in the camera's axes, (3,), or (frames, 3) of a camera that moves."""
    if session.world.up_world is None:
        return None
    up, path = np.array(session.world.up_world), session.camera_path
    return up if path is None else path.Ts_camera_world[:, :3, :3] @ up
