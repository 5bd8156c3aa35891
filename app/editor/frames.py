"""In which frame things are shown: that of the camera at the present frame.

What the session keeps of the world (up, the floor, places) is in the world's frame, the camera's as
the film begins. Poses are each in the frame of the camera at their own frame, where a person posed
them over the picture. Where the camera stands still all of these are one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from keypose.app.editor.documents import film_of
from keypose.app.posing import (
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
from keypose.tracker.session.between_views import T_film_first, lens_in
from keypose.tracker.session.schema import Session


def up_of(doc: Session, frame: int) -> tuple[float, float, float]:
    """The world's up direction in the frame of the camera at a frame."""
    x, y, z = doc.film_camera.T_camera_world(frame)[:3, :3] @ doc.world.up
    return float(x), float(y), float(z)


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
    rotations, T = view_rotations(doc.world.up), doc.film_camera.T_camera_world(frame)
    if doc.camera_path is not None:
        rotations = {name: R @ T[:3, :3].T for name, R in rotations.items()}
    return rotations, T[:3, 3]


def pointer_views(
    doc: Session, frame: int, eye: Eye | None = None, film: str | None = None
) -> dict[str, PointerView]:
    """main, top, side and front at a frame; with an eye also free, with a view's id also film."""
    views: dict[str, PointerView] = {"main": PointerView.of(doc.film_camera.at(frame))}
    rotations, origin = views_of(doc, frame)
    for name, R in rotations.items():
        views[name] = PointerView.parallel(name, R, origin)
    if eye is not None:
        R = eye_rotation(eye.azimuth_deg, eye.elevation_deg) @ rotations["front"]
        views["free"] = PointerView.free(R, eye.at_m)
    if film is not None:
        view = film_of(doc, film)
        views["film"] = PointerView.film(lens_in(doc, view, frame), T_film_first(doc, view, frame))
    return views


def first_pose(doc: Session) -> Pose:
    """Where a body stands before anybody posed it."""
    return opening_pose(doc.subject.body, doc.view.camera, doc.world.up)
