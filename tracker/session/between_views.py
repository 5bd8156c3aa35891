"""Where the cameras of a session's views are beside each other at a moment."""

from __future__ import annotations

import numpy as np

from keypose.tracker.geometry.camera_path import rigid_inverse
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.schema import Session
from keypose.tracker.session.views import View


def T_film_first(session: Session, view: View, frame: int) -> Array:
    """(4, 4) from the first camera's frame, as it filmed a frame, to the camera of a view, as it
    filmed that moment."""
    own = view.film_clock.frames_at([float(frame)])
    to_world = T_world_camera(session, np.array([float(frame)]))
    T = view.T_camera_world @ to_world
    return np.asarray(rigid_inverse(T_world_camera(session.alone(view.id), own)) @ T)


def T_world_camera(session: Session, frames: Array) -> Array:
    """(4, 4) of the first view's camera at a frame (1,), with its fraction, kept within its film;
    the identity where it stands still."""
    path = session.camera_path
    if path is None:
        return np.eye(4)
    inside = np.clip(frames, 0, len(path) - 1)
    return np.asarray(path.sampled(inside).Ts_world_camera[0])
