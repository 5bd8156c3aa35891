"""Where the cameras of a session's views are beside each other at a moment."""

from __future__ import annotations

import numpy as np

from keypose.tracker.geometry.camera import Camera
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


def frame_in(view: View, frame: int) -> int:
    """The frame of a view's film that is nearest to a frame of the first film, within it or not."""
    return round(float(view.film_clock.frames_at(frame)))


def lens_in(session: Session, view: View, frame: int) -> Camera:
    """The lens of a view without its distortion, as it filmed the moment of a frame of the first
    film; where it did not film it, at its first or last frame."""
    inside = min(max(frame_in(view, frame), 0), view.video.frame_count - 1)
    return session.alone(view.id).film_camera.at(inside).without_distortion()


def measured_share(session: Session) -> float | None:
    """How far other films' cameras were measured to be from the first one, as a multiple of how far
    the session has them; None unless that was measured of all of them."""
    measured = [view.placed and view.placed.measured_m for view in session.views[1:]]
    if not measured or not all(measured):
        return None
    taken = [float(np.linalg.norm(view.p_camera_world)) for view in session.views[1:]]
    return sum(each or 0.0 for each in measured) / sum(taken) if all(taken) else None


def T_world_camera(session: Session, frames: Array) -> Array:
    """(4, 4) of the first view's camera at a frame (1,), with its fraction, kept within its film;
    the identity where it stands still."""
    path = session.camera_path
    if path is None:
        return np.eye(4)
    inside = np.clip(frames, 0, len(path) - 1)
    return np.asarray(path.sampled(inside).Ts_world_camera[0])
