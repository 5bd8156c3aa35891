"""Pictures of many frames, one after the other: the video with the body, or the motion alone as a
new camera sees it.

A view keeps its place and its scale through the whole film. Frames are drawn side by side in
threads, a few ahead of the one that is asked for; no more are held than these.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from keypose.app.orders.drawing import FilmView, Paint, Size, Tint, View, Viewpoint
from keypose.app.render.palette import Picture
from keypose.app.render.pictures import FourViewLayout, Framing, framing_of, middle
from keypose.app.render.poses import KnownPoses
from keypose.app.render.stills import ground_below, natural_size
from keypose.app.render.studio import Studio
from keypose.app.render.surfaces import SurfaceLayer, SurfaceLayers
from keypose.app.render.viewpoints import Ground, least_distance, round_trip, smoothed, view_from
from keypose.tracker.body.pose import Pose
from keypose.tracker.errors import SessionError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.schema import Session
from keypose.tracker.video import Video

Draw: TypeAlias = Callable[[int, Picture | None], Picture]
"""The picture of a frame; the video's own is given where it is seen."""

THREADS = min(4, os.cpu_count() or 1)
SMOOTHED_SECONDS = 0.5
"""An orbiting camera follows the body this slowly."""


@dataclass(frozen=True)
class Film:
    """What is asked for: frames first to last. size: None for the video's own, made even.

    tint: of observed surfaces.
    """

    view: FilmView
    first: int
    last: int
    paint: Paint = field(default_factory=lambda: Paint("both", 0.5))
    size: Size | None = None
    tint: Tint = "clay"

    @property
    def needs_video(self) -> bool:
        return self.view in ("main", "all")


def film_size(session: Session, poses: KnownPoses, film: Film) -> Size:
    """The size of the film's pictures, both sides even."""
    width, height = film.size or natural_size(Studio.of(session, poses.skeleton), film.view)
    return width + width % 2, height + height % 2


def film_pictures(
    session: Session, video: Video | None, poses: KnownPoses, film: Film, fps: float
) -> Iterator[Picture]:
    """The pictures (H, W, 3) of all frames in turn. The body is drawn where there is a pose.

    SessionError when no frame of the film has one.
    """
    studio = Studio.of(session, poses.skeleton, poses.figures_beside)
    size = film_size(session, poses, film)
    layers = SurfaceLayers.of(session, video, film.tint)
    draw = _artist(studio, poses, film, size, fps, layers)
    numbers = range(film.first, film.last + 1)
    images: Iterable[tuple[int, Picture | None]] = ((number, None) for number in numbers)
    if video is not None and film.needs_video and (layers is None or layers.is_clay):
        images = video.frames(film.first, film.last + 1)
    return _ahead(draw, images)


def posed_frames(poses: KnownPoses, film: Film) -> tuple[int, ...]:
    """The frames of the film in which the body is drawn."""
    return tuple(frame for frame in poses.frames if film.first <= frame <= film.last)


def _artist(
    studio: Studio,
    poses: KnownPoses,
    film: Film,
    size: Size,
    fps: float,
    layers: SurfaceLayers | None,
) -> Draw:
    """What draws the frames of a film; all that is common to them is found out before."""
    view, paint = film.view, film.paint
    frames = posed_frames(poses, film)
    if not frames:
        raise SessionError(
            f"Frames {film.first} to {film.last} have no pose: track the session first, or choose "
            "other frames."
        )

    def ground(frame: int, image: Picture | None) -> Picture | None:
        if layers is not None and not layers.is_clay:
            return layers.picture(frame, poses.pose(frame))
        return None if image is None else studio.session.view.camera.rectify(image)

    def layer_at(frame: int) -> SurfaceLayer | None:
        return None if layers is None else layers.at(frame, poses.pose(frame))

    if view == "main":

        def over_video(frame: int, image: Picture | None) -> Picture:
            here = studio.at(frame)
            return here.main(ground(frame, image), frame, poses.pose(frame), size, paint)

        return over_video
    if isinstance(view, Viewpoint) or view == "orbit":
        return _new_camera(studio, poses, film, frames, size, fps, layer_at)
    framing = _framing(studio, poses, frames, view, size)

    def framing_at(frame: int) -> Framing:
        if studio.session.camera_path is None or framing.centre_m is None:
            return framing
        centre = studio.session.film_camera.points_to_camera(frame, framing.centre_m)
        return replace(framing, centre_m=centre, Rs=studio.at(frame).Rs)

    if view == "all":

        def four(frame: int, image: Picture | None) -> Picture:
            pose = poses.pose(frame)
            surface_layer = layer_at(frame)
            image, here = ground(frame, image), studio.at(frame)
            return here.four(image, frame, pose, size, paint, framing_at(frame), surface_layer)

        return four
    return lambda frame, _: studio.at(frame).parallel(
        view, poses.pose(frame), size, framing_at(frame), layer_at(frame)
    )


def _framing(
    studio: Studio, poses: KnownPoses, frames: tuple[int, ...], view: View, size: Size
) -> Framing:
    """What shows the whole motion at one scale."""
    corners = _box_of_motion(studio, poses, frames)
    if view == "main" or view == "all":
        sizes = FourViewLayout.of(studio.camera, studio.height_of_four(size)).views
    else:
        sizes = {view: size}
    return framing_of(corners, sizes, studio.Rs)


def _new_camera(
    studio: Studio,
    poses: KnownPoses,
    film: Film,
    frames: tuple[int, ...],
    size: Size,
    fps: float,
    layer_at: Callable[[int], SurfaceLayer | None],
) -> Draw:
    """A camera that stands still, or that goes round the body; always far enough to see it all."""
    level, count = studio.Rs["front"], film.last - film.first + 1
    if film.view == "orbit":
        viewpoints = round_trip(count)
        centres = smoothed(_middles(studio, poses, film, frames), SMOOTHED_SECONDS * fps)
    else:
        assert isinstance(film.view, Viewpoint)
        viewpoints = [film.view] * count
        centre = _box_of_motion(studio, poses, frames).mean(axis=0)
        centres = np.broadcast_to(centre, (count, 3))
    distance = viewpoints[0].distance_m or max(
        least_distance(
            viewpoints[frame - film.first],
            level,
            centres[frame - film.first],
            _points(studio, poses, frame),
            size,
        )
        for frame in frames
    )
    first = frames[0]
    ground = ground_below(studio.at(first), poses, first)

    def from_new_camera(frame: int, _: Picture | None) -> Picture:
        i, here = frame - film.first, studio.at(frame)
        centre = studio.session.film_camera.points_to_camera(frame, centres[i])
        view = view_from(viewpoints[i], distance, here.Rs["front"], centre, size)
        below = _carried(studio, ground, first, frame)
        return here.perspective(view, below, centre, poses.pose(frame), layer_at(frame))

    return from_new_camera


def _carried(studio: Studio, ground: Ground, first: int, frame: int) -> Ground:
    """The floor that the camera sees at one frame as it sees it at another."""
    if studio.session.camera_path is None:
        return ground
    down = studio.Rs["front"][1]
    film_camera, origin = studio.session.film_camera, np.zeros(3)
    rise = film_camera.points_to_world(first, origin) - film_camera.points_to_world(frame, origin)
    level, floor_m = studio.at(frame).Rs["front"], ground.floor_m + float(down @ rise)
    return replace(ground, R_level_camera=level, floor_m=floor_m)


def _points(studio: Studio, poses: KnownPoses, frame: int) -> Array:
    """(K, 3) of all bodies at a frame, in the world."""
    p_camera = studio.at(frame).points(_posed(poses, frame))
    return studio.session.film_camera.points_to_world(frame, p_camera)


def _box_of_motion(studio: Studio, poses: KnownPoses, frames: tuple[int, ...]) -> Array:
    """The corners (8, 3), in the world, of the upright box around the body in all these frames."""
    R_level_camera = studio.Rs["front"]
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for frame in frames:
        points = _points(studio, poses, frame) @ R_level_camera.T
        low, high = np.minimum(low, points.min(axis=0)), np.maximum(high, points.max(axis=0))
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True), indexing="ij"), axis=-1)
    return np.asarray(corners.reshape(8, 3) @ R_level_camera)


def _middles(studio: Studio, poses: KnownPoses, film: Film, frames: tuple[int, ...]) -> Array:
    """(N, 3) where the body is in every frame of the film; between known places, on the line."""
    middles = np.array([middle(_points(studio, poses, frame)) for frame in frames])
    every = np.arange(film.first, film.last + 1)
    return np.stack([np.interp(every, frames, column) for column in middles.T], axis=1)


def _posed(poses: KnownPoses, frame: int) -> Pose:
    pose = poses.pose(frame)
    assert pose is not None
    return pose


def _ahead(draw: Draw, images: Iterable[tuple[int, Picture | None]]) -> Iterator[Picture]:
    """The pictures in order, a few being drawn while one is used."""
    waiting: deque[Future[Picture]] = deque()
    with ThreadPoolExecutor(THREADS) as threads:
        try:
            for number, image in images:
                waiting.append(threads.submit(draw, number, image))
                if len(waiting) > THREADS:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            for future in waiting:
                future.cancel()
