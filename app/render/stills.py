"""A picture of one frame as a person asks for it: any view, any size, over the video or on nothing.

What is asked for plainly is the page's own picture.
"""

from __future__ import annotations

import numpy as np

from keypose.app.orders.drawing import PictureOrder, Size, Viewpoint
from keypose.app.render.painting import Figure
from keypose.app.render.palette import CutOut, Picture
from keypose.app.render.pictures import FourViewLayout, middle, posed_points
from keypose.app.render.poses import KnownPoses
from keypose.app.render.studio import Studio, ViewStyle, background, snapshot
from keypose.app.render.surfaces import SurfaceLayer, SurfaceLayers
from keypose.app.render.viewpoints import Ground, least_distance, view_from
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import SessionError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.session.schema import Session
from keypose.tracker.video import Video


def still(
    session: Session, video: Video | None, frame: int, poses: KnownPoses, wanted: PictureOrder
) -> Picture | CutOut:
    """The picture at a frame that has a pose."""
    pose = poses.pose(frame)
    if pose is None:
        raise SessionError(f"Frame {frame} has no pose.")
    if wanted.is_plain and not isinstance(wanted.view, Viewpoint):
        look = ViewStyle(wanted.view, wanted.style, wanted.opacity, wanted.tint)
        return snapshot(session, video, frame, pose, look, poses.figures_beside(frame))
    studio = Studio.of(session, poses.skeleton, poses.figures_beside).at(frame)
    size = _size(studio, wanted)
    if wanted.on_nothing:
        return _on_nothing(studio, pose, wanted, size)
    layers = SurfaceLayers.of(session, video, wanted.tint)
    if wanted.view == "main":
        image = background(session, video, layers, frame, pose)
        return studio.main(image, frame, pose, size, wanted.paint)
    surface = None if layers is None else layers.at(frame, pose)
    if isinstance(wanted.view, Viewpoint):
        return _from_viewpoint(studio, poses, frame, wanted.view, size, surface)
    if wanted.view != "all":
        return studio.parallel(wanted.view, pose, size, surface=surface)
    image = background(session, video, layers, frame, pose)
    return studio.four(image, frame, pose, size, wanted.paint, surface=surface)


def natural_size(studio: Studio, view: object) -> Size:
    """The size of a picture for which none is asked."""
    camera = studio.camera
    if view == "all":
        return FourViewLayout.of(camera, camera.height).width, camera.height
    return camera.width, camera.height


def _size(studio: Studio, wanted: PictureOrder) -> Size:
    if wanted.size is not None:
        return wanted.size
    width, height = natural_size(studio, wanted.view)
    return max(1, round(width * wanted.scale)), max(1, round(height * wanted.scale))


def _on_nothing(studio: Studio, pose: Pose, wanted: PictureOrder, size: Size) -> CutOut:
    if isinstance(wanted.view, Viewpoint):
        return studio.cut_out_by(_view(studio, pose, wanted.view, size)[0], pose)
    if wanted.view == "main":
        return studio.main_cut_out(pose, size, wanted.paint)
    if wanted.view == "all":
        return studio.four_cut_out(pose, size, wanted.paint)
    return studio.parallel_cut_out(wanted.view, pose, size)


def from_viewpoint(
    session: Session,
    frame: int,
    pose: Pose,
    viewpoint: Viewpoint,
    floor_height_m: float,
    size: Size,
    beside: tuple[Figure, ...] = (),
) -> Picture:
    """The body, and those beside it, in the middle of a picture, on a floor of this height along up
    in the world."""
    skeleton = Skeleton.of(session.subject.body)
    studio = Studio.of(session, skeleton, lambda _: beside).at(frame)
    view, centre = _view(studio, pose, viewpoint, size)
    down = studio.Rs["front"][1]
    origin = studio.session.film_camera.points_to_camera(frame, np.zeros(3))
    ground = Ground.at(studio.skeleton, studio.Rs["front"], floor_height_m - float(down @ origin))
    return studio.perspective(view, ground, centre, pose, None)


def _from_viewpoint(
    studio: Studio,
    poses: KnownPoses,
    frame: int,
    viewpoint: Viewpoint,
    size: Size,
    surface: SurfaceLayer | None,
) -> Picture:
    """About the body as it is at this frame; the floor is where the whole motion has it."""
    pose = poses.pose(frame)
    assert pose is not None
    view, centre = _view(studio, pose, viewpoint, size)
    ground = ground_below(studio, poses, frame)
    return studio.perspective(view, ground, centre, pose, surface)


def ground_below(studio: Studio, poses: KnownPoses, frame: int) -> Ground:
    """The floor under the whole motion, as the camera sees it at a frame. studio: of that frame."""
    film_camera, level, lowest = studio.session.film_camera, studio.Rs["front"], -np.inf
    for each in poses.frames:
        pose = poses.pose(each)
        if pose is not None:
            p_world = film_camera.points_to_world(each, posed_points(studio.skeleton, pose))
            p_camera = film_camera.points_to_camera(frame, p_world)
            lowest = max(lowest, float((p_camera @ level[1]).max()))
    return Ground.at(studio.skeleton, level, -lowest)


def _view(studio: Studio, pose: Pose, viewpoint: Viewpoint, size: Size) -> tuple[ViewCamera, Array]:
    """What looks at the body's middle (3,), which comes with it."""
    level = studio.Rs["front"]
    points = studio.points(pose)
    centre = middle(points @ level.T) @ level
    distance = viewpoint.distance_m or least_distance(viewpoint, level, centre, points, size)
    return view_from(viewpoint, distance, level, centre, size), centre
