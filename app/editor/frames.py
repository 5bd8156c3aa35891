"""In which frame things are shown: that of the camera at the present frame.

What the session keeps of the world (up, the floor, places) is in the world's frame, the camera's as
the film begins. Poses are each in the frame of the camera at their own frame, where a person posed
them over the picture. Where the camera stands still all of these are one.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from keypose.app.editor.documents import film_of
from keypose.app.posing import (
    Eye,
    PointerView,
    eye_rotation,
    opening_pose,
    view_rotations,
)
from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewName
from keypose.tracker.session.between_views import T_film_first, lens_in
from keypose.tracker.session.schema import Session

BESIDE_M: Final = 0.6
"""How far beside another body one stands that nobody has posed yet."""


def up_of(doc: Session, frame: int) -> tuple[float, float, float]:
    """The world's up direction in the frame of the camera at a frame."""
    x, y, z = doc.film_camera.T_camera_world(frame)[:3, :3] @ doc.world.up
    return float(x), float(y), float(z)


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
    """Where a body stands before anybody posed it: beside one that is posed, where there is one, on
    the side where the picture has more room."""
    pose = opening_pose(doc.subject.body, doc.view.camera, doc.world.up)
    others = (body for body in doc.bodies if body.id != doc.subject.id)
    neighbour = next((each for body in others for each in (*body.keyframes, *body.drafts)), None)
    if neighbour is None or doc.view.camera.telephoto_distance_m is not None:
        return pose
    p_beside = np.array(neighbour.root_m)
    p_beside[0] += -BESIDE_M if p_beside[0] > 0 else BESIDE_M
    return replace(pose, p_camera_root=p_beside)
