"""The other films of a session, made ready to be tracked with the first."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from keypose.tracker.films.mend import SeenInFilm
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.film_clock import sampled
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import Keypoints, joints_in
from keypose.tracker.session.between_views import T_film_first
from keypose.tracker.session.schema import Session
from keypose.tracker.session.views import View
from keypose.tracker.storage.files import open_video_of
from keypose.tracker.storage.fingerprints import background_turns, steady_camera
from keypose.tracker.storage.sidecars import keypoints_of_session
from keypose.tracker.tracking.film_beside import FilmBeside
from keypose.tracker.tracking.prepared_film import PreparedFilm
from keypose.tracker.video import Video
from keypose.tracker.video.clip_loader import AGAIN, Memory


def open_other_films(session: Session, session_path: Path) -> dict[str, Video]:
    """The videos of all views but the first, by the view's id, to be closed.

    KeyposeError in one sentence where one cannot be had.
    """
    videos: dict[str, Video] = {}
    try:
        for view in session.views[1:]:
            videos[view.id] = open_video_of(session.alone(view.id), session_path)
    except BaseException:
        close_all(videos)
        raise
    return videos


def close_all(videos: Mapping[str, Video]) -> None:
    """Close videos."""
    for video in videos.values():
        video.close()


def films_beside(
    session: Session, videos: Mapping[str, Video], folder: Path, memory: Memory = AGAIN
) -> tuple[FilmBeside, ...]:
    """The other films of a session as its segments are tracked with them.

    videos: by the view's id.  folder: of the session's file.  KeyposeError in one sentence where
    keypoints of one cannot be read.
    """
    return tuple(
        film_beside(session, view, prepared_film(session, view, videos[view.id], memory), folder)
        for view in session.views[1:]
    )


def prepared_film(session: Session, view: View, video: Video, memory: Memory) -> PreparedFilm:
    """The pictures of a view's film."""
    alone = session.alone(view.id)
    return PreparedFilm(
        video,
        view.camera,
        view.ignore_masks,
        alone.has_static_camera,
        memory,
        steady_camera(alone),
        background_turns(alone),
    )


def film_beside(session: Session, view: View, film: PreparedFilm, folder: Path) -> FilmBeside:
    """A view's film beside the first; its pictures may have been prepared before."""
    alone, clock = session.alone(view.id), view.film_clock
    count, first_count = view.video.frame_count, session.view.video.frame_count
    own, first = np.arange(count, dtype=float), np.arange(first_count, dtype=float)
    keypoints: Keypoints | None = None
    if "keypoints" in session.settings.cues_used:
        keypoints = keypoints_of_session(alone, folder)
    steady = steady_camera(alone)
    if keypoints is not None and steady is not None:
        keypoints = keypoints.steadied(steady)
    return FilmBeside(
        film,
        clock,
        _between(session, alone, view, clock.moments_of(own), own),
        _between(session, alone, view, first, clock.frames_at(first)),
        keypoints,
    )


def keypoints_of_films(session: Session, folder: Path) -> dict[str, Keypoints]:
    """The keypoints in files of all films that have any, as a person corrected them, by the view's
    id.  folder: of the session's file.  KeypointError as of `keypoints_of_session`."""
    keypoints = {}
    for view in session.views:
        of_film = keypoints_of_session(session.alone(view.id), folder)
        if of_film is not None:
            keypoints[view.id] = of_film.corrected(view.keypoint_corrections)
    return keypoints


def seen_in_films(
    session: Session, keypoints: Mapping[str, Keypoints], frame: int
) -> list[SeenInFilm]:
    """What every film of a session shows at a frame of the first.  keypoints: by the view's id."""
    sights = []
    for view in session.views:
        alone, own = session.alone(view.id), view.film_clock.frames_at([frame])
        inside = 0 <= own[0] <= view.video.frame_count - 1
        if view.id not in keypoints or not inside:
            continue
        over = keypoints[view.id].over(0, view.video.frame_count - 1)
        camera = alone.film_camera.at(round(float(own[0])))
        uv = sampled(joints_in(over, over.uv), own)[0]
        visibility = np.nan_to_num(sampled(joints_in(over, over.visibility), own)[0])
        ideal = camera.without_distortion()
        uv = ideal.project(camera.back_project(uv, 1.0)) if camera.is_distorted else uv
        T = T_film_first(session, view, frame)
        sights.append(SeenInFilm(ideal, T, uv, visibility))
    return sights


def seen_beside(session: Session, folder: Path) -> dict[int, list[SeenInFilm]]:
    """What all films but the first show of each keyframe, by its frame; nothing where there are no
    others.  folder: of the session's file.  KeyposeError where keypoints cannot be read."""
    keypoints = keypoints_of_films(session, folder)
    keypoints.pop(session.view.id, None)
    frames = [keyframe.frame for keyframe in session.subject.keyframes] if keypoints else []
    return {frame: seen_in_films(session, keypoints, frame) for frame in frames}


def _between(
    session: Session,
    alone: Session,
    view: View,
    moments: Array,
    frames: Array,
) -> Array:
    """(K, 4, 4) from the first camera's frame at moments of its film to the view's at the frames of
    its own that were taken then, each as its film is tracked."""
    to_world = _path_at(session, moments)
    from_world = _path_at(alone, frames)
    T = np.broadcast_to(view.T_camera_world, (len(moments), 4, 4))
    if from_world is not None:
        T = from_world.Ts_camera_world @ T
    return T if to_world is None else np.asarray(T @ to_world.Ts_world_camera)


def _path_at(session: Session, frames: Array) -> CameraPath | None:
    """Where the camera was, in whose place the first view's film is tracked, at frames with
    fractions; None where it stands still."""
    path, steady = session.camera_path, steady_camera(session)
    if path is None:
        return None
    Ts = path.Ts_camera_world
    if steady is not None:
        Ts = steady.Ts_steady_camera @ Ts
    inside = np.clip(frames, 0, len(path) - 1)
    return CameraPath(Ts, np.ones(len(path))).sampled(inside)
