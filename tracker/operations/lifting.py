"""What lifts the depth of a session's keypoints."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.lifted_depth import DepthLifter
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.fingerprints import lifts_depth


def depth_lifter(session: Session, file_times_s: Array, *, up: bool = False) -> DepthLifter:
    """What lifts keypoints of a session's film.

    file_times_s: (frames,) of the file.  up: whether it is told what is up, where that is known.
    """
    times_s = session.evidence.times_s(file_times_s)
    return DepthLifter(session.view.camera, times_s, _up_camera(session) if up else None)


def lifter_for_drafts(session: Session, file_times_s: Callable[[], Array]) -> DepthLifter | None:
    """The same for drafts, which are told what is up; None where the session's cues leave it out.

    file_times_s: asked only where it is needed: a film may have to be opened for it.
    """
    return depth_lifter(session, file_times_s(), up=True) if lifts_depth(session) else None


def _up_camera(session: Session) -> Array | None:
    """What is up in the camera's axes, (3,), or (frames, 3) of a camera that moves."""
    if session.world.up_world is None:
        return None
    up, path = np.array(session.world.up_world), session.camera_path
    return up if path is None else path.Ts_camera_world[:, :3, :3] @ up
