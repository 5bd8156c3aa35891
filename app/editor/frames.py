"""In which frame things are shown: that of the camera at the present frame.

What the session keeps of the world (up, the floor, places) is in the world's frame, the camera's as
the film begins. Poses are each in the frame of the camera at their own frame, where a person posed
them over the picture. Where the camera stands still all of these are one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from keypose.app.posing import (
    CAMERA_UP,
    Eye,
    PointerView,
    eye_rotation,
    opening_pose,
    view_rotations,
)
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import blended, carried
from keypose.tracker.geometry.camera_path import rigid_inverse
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewName
from keypose.tracker.session.schema import Session


def up_of(doc: Session, frame: int) -> tuple[float, float, float]:
    """The world's up direction in the frame of the camera at a frame."""
    up, path = up_in_world(doc), doc.camera_path
    if path is None:
        return up
    x, y, z = path.Ts_camera_world[frame, :3, :3] @ up
    return float(x), float(y), float(z)


def up_in_world(doc: Session) -> tuple[float, float, float]:
    """The world's up direction; that of its camera as the film begins, where nobody knows."""
    return CAMERA_UP if doc.world.up_world is None else doc.world.up_world


def zoom_at(doc: Session, frame: int) -> float:
    """The focal length at a frame, as a multiple of the camera's."""
    path = doc.camera_path
    return 1.0 if path is None else float(path.zoom[frame])


def T_camera_world(doc: Session, frame: int) -> Array:
    """(4, 4) where the world is for the camera at a frame."""
    path = doc.camera_path
    return np.eye(4) if path is None else np.asarray(path.Ts_camera_world[frame])


def to_world(doc: Session, frame: int, direction: ArrayLike) -> Array:
    """A direction (3,) that the camera sees at a frame, in the world."""
    return np.asarray(T_camera_world(doc, frame)[:3, :3].T @ np.asarray(direction))


def carried_to(doc: Session, frame: int, Ts_camera: Array, frames: ArrayLike) -> Array:
    """Ts_camera (N, ..., 4, 4), each in the frame of the camera at its own of N frames, in that of
    the camera at one frame; themselves where the camera stands still.
    """
    path = doc.camera_path
    if path is None:
        return Ts_camera
    T = path.Ts_camera_world[frame] @ path.Ts_world_camera[np.asarray(frames)]
    return np.asarray(T.reshape(-1, *(1,) * (Ts_camera.ndim - 3), 4, 4) @ Ts_camera)


def in_world(doc: Session, Ts_camera: Array, frames: ArrayLike) -> Array:
    """Ts_camera (N, ..., 4, 4), each in the frame of the camera at its own of N frames, in the
    world; themselves where the camera stands still.
    """
    path = doc.camera_path
    if path is None:
        return Ts_camera
    T = path.Ts_world_camera[np.asarray(frames)]
    return np.asarray(T.reshape(-1, *(1,) * (Ts_camera.ndim - 3), 4, 4) @ Ts_camera)


def carried_pose(doc: Session, frame: int, pose: Pose, to: int) -> Pose:
    """The pose of a frame where it stands in the world, as the camera sees it at another one."""
    if doc.camera_path is None:
        return pose
    return pose.carried(carried_to(doc, to, np.eye(4)[None], [frame])[0])


def even_motion(
    doc: Session, start: Pose, end: Pose, span: tuple[int, int], frames: NDArray[np.int64]
) -> tuple[Array, Array]:
    """Rotations (N, P, 3, 3) and root positions (N, 3) at frames (N,) of the motion from one pose,
    at the first frame of a span, to another at its last, that is even in the world, as the camera
    sees it."""
    first, last = span
    path, shares = doc.camera_path, (frames - first) / (last - first)
    if path is None:
        return blended(start, end, shares)
    Ts = path.Ts_camera_world
    begin, finish = rigid_inverse(Ts[[first, last]])
    return carried(*blended(start.carried(begin), end.carried(finish), shares), Ts[frames])


def views_of(doc: Session, frame: int) -> tuple[dict[ViewName, Array], Array]:
    """R_view_camera of the small views, which stand still in the world, and where its origin (3,)
    is, in the frame of the camera at a frame."""
    rotations, T = view_rotations(up_in_world(doc)), T_camera_world(doc, frame)
    if doc.camera_path is not None:
        rotations = {name: R @ T[:3, :3].T for name, R in rotations.items()}
    return rotations, T[:3, 3]


def pointer_views(doc: Session, frame: int, eye: Eye | None = None) -> dict[str, PointerView]:
    """main, top, side and front at a frame; with an eye also free."""
    views: dict[str, PointerView] = {"main": PointerView.of(doc.camera_at(frame))}
    rotations, origin = views_of(doc, frame)
    for name, R in rotations.items():
        views[name] = PointerView.parallel(name, R, origin)
    if eye is not None:
        R = eye_rotation(eye.azimuth_deg, eye.elevation_deg) @ rotations["front"]
        views["free"] = PointerView.free(R, eye.at_m)
    return views


def first_pose(doc: Session) -> Pose:
    """Where a body stands before anybody posed it."""
    return opening_pose(doc.subject.body, doc.view.camera, up_in_world(doc))
