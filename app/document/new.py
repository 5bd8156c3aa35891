"""A session that is begun: of a video, or of observed surfaces."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from keypose.app.document.defaults import read_defaults
from keypose.app.document.folder_lock import locked
from keypose.app.editor.camera import as_taken
from keypose.app.editor.documents import NEAREST_M
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.modify import with_height
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import SessionError, SurfaceError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.session.evidence import surface_of
from keypose.tracker.session.references import Surface, VideoReference
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.atomic import make_folder
from keypose.tracker.storage.evidence import with_cameras_fingerprint
from keypose.tracker.storage.files import load_session, save_session, video_path
from keypose.tracker.surface.cameras.rig import Rig
from keypose.tracker.surface.files.sequence import MeshSequence
from keypose.tracker.surface.new_session import Reading, choose_reading, first_mesh
from keypose.tracker.surface.source import SurfaceSteps, holds_meshes
from keypose.tracker.video import Video, VideoInfo
from keypose.tracker.video.still_camera import still_camera

PEOPLE_M = (0.5, 2.5)
"""Heights of surfaces that may well be a person's."""


def new_session(video: Video, session_path: Path) -> Session:
    """An empty session of a video: the camera that the file names, or a guessed one, an adult, no
    keyframes; and whether the camera stands still, as a few frames show it. Body and settings are
    a person's defaults."""
    require_text(video.info.path)
    defaults = read_defaults()
    stands_still = still_camera(video).still
    info = video.info  # only now: reading frames may have corrected it
    return Session.begin(
        video=VideoReference(
            path=path_from(info.path, session_path.parent),
            fingerprint=video.fingerprint(),
            frame_count=info.frame_count,
            width=info.width,
            height=info.height,
            stands_still=stands_still,
        ),
        camera=camera_of(info),
        body=preset(defaults.body),
        lens_source=None if info.lens is None else "file",
        settings=defaults.track_settings,
    )


def camera_of(info: VideoInfo) -> Camera:
    """The camera of the lens that the file names; without one, a usual camera."""
    if info.lens is None:
        return Camera.guess(info.width, info.height)
    return Camera.from_focal_length(info.width, info.height, info.lens.focal_mm)


def new_surface_session(
    meshes: Path, session_path: Path, reading: Reading, cameras: Path | None = None
) -> tuple[Session, tuple[str, ...]]:
    """An empty session of observed surfaces: a camera before them, an adult, no keyframes; and
    what had to be guessed, in a sentence. SurfaceError where there are no meshes to use.

    cameras: the file of the cameras that took them.
    """
    require_text(meshes)
    rig = None
    if cameras is not None:
        require_text(cameras)
        rig = Rig.open(cameras)
        reading = replace(reading, cameras=path_from(cameras, session_path.parent))
    with MeshSequence.open(meshes) as sequence:
        surface_setup = choose_reading(sequence, reading, rig)
        video = VideoReference(
            path=path_from(meshes, session_path.parent),
            fingerprint=sequence.fingerprint(),
            frame_count=sequence.frame_count,
            width=surface_setup.camera.width,
            height=surface_setup.camera.height,
        )
    body = _as_tall(preset(read_defaults().body), surface_setup.height_m)
    surface = (
        surface_setup.surface
        if cameras is None
        else with_cameras_fingerprint(surface_setup.surface, cameras)
    )
    session = Session.begin(video=video, camera=surface_setup.camera, body=body, surface=surface)
    return session, surface_setup.guesses


def _as_tall(body: Body, height_m: float) -> Body:
    """The body with the height of what is observed, where that may be a person's."""
    low, high = PEOPLE_M
    return with_height(body, height_m) if low <= height_m <= high else body


def open_as_taken(
    path: Path, session_for: Callable[[Path], Path], taken: Mapping[str, Any]
) -> Path:
    """The session of a film, written or changed so that it was taken as a person says."""
    session_path, _ = _session_of(path, session_for)
    if session_path.exists():
        session = load_session(session_path)
    else:
        with Video.open(path, deinterlace=taken.get("deinterlace", True)) as video:
            session = new_session(video, session_path)
    session = as_taken(session, taken)
    make_folder(session_path.parent, error=SessionError)
    with locked(session_path, "close it there"):
        save_session(session, session_path)
    return session_path


def _session_of(path: Path, session_for: Callable[[Path], Path]) -> tuple[Path, bool]:
    """The session's file of what is to be opened, and whether that was named itself."""
    named = path / "session.json" if (path / "session.json").is_file() else path
    is_session = named.suffix.lower() == ".json"
    return (named if is_session else session_for(path)), is_session


def open_with_reading(
    path: Path, session_for: Callable[[Path], Path], reading: Reading, cameras: Path | None
) -> tuple[Path, tuple[str, ...]]:
    """The session of meshes, written or changed so that they are read as a person says; and what
    had to be guessed all the same, in a sentence.

    SessionError where the body was posed in them as they are read now: then only the page changes
    that, for the poses follow there.
    """
    session_path, is_session = _session_of(path, session_for)
    if not is_session and not holds_meshes(path):
        raise SessionError(f"{str(path)!r} holds no meshes: only these have units and an up axis.")
    meshes = path
    if session_path.exists():
        session = load_session(session_path)
        if session.view.surface is None:
            raise SessionError(f"{session_path.name} is about a video, not about meshes.")
        meshes = video_path(session, session_path)
        if _is_read_so(session.view.surface, reading) and cameras is None:
            return session_path, ()
        if session.subject.keyframes or session.subject.drafts:
            raise SessionError(
                f"{session_path.name} has poses already: open it without --units, --up and "
                "--cameras, and change units and up under Fit, where the poses follow."
            )
        reading, cameras = _filled(session.view.surface, session_path, reading, cameras)
    new, news = new_surface_session(meshes, session_path, reading, cameras)
    if session_path.exists():
        new = _read_anew(session, new)
    make_folder(session_path.parent, error=SessionError)
    with locked(session_path, "close it there"):
        save_session(new, session_path)
    return session_path, news


def _filled(
    surface: Surface, session_path: Path, reading: Reading, cameras: Path | None
) -> tuple[Reading, Path | None]:
    """What a person says now, and what is left out as the session has it."""
    filled = Reading(reading.units or surface.units, reading.up or surface.up)
    if cameras is None and surface.cameras is not None:
        cameras = session_path.absolute().parent / surface.cameras
    return filled, cameras


def _read_anew(session: Session, new: Session) -> Session:
    """A session whose meshes are read as in a new one; fitted they are as it says itself."""
    surface, read = surface_of(session), surface_of(new)
    names = ("units", "up", "p_camera_surface", "cameras", "cameras_fingerprint")
    surface = surface.model_copy(update={name: getattr(read, name) for name in names})
    return session.changed({"surface": surface, "camera": new.view.camera})


def _is_read_so(surface: Surface, reading: Reading) -> bool:
    return reading.units in (None, surface.units) and reading.up in (None, surface.up)


def standing_in(pose: Pose, body: Body, steps: SurfaceSteps) -> Pose:
    """The same pose in the middle of the first surface that can be used; as it is without one."""
    try:
        mesh = steps.shape(first_mesh(steps.sequence)[0])
    except SurfaceError:
        return pose
    skeleton = Skeleton.of(body)
    Ts = pose_transforms(skeleton, pose)
    shapes = [
        apply_transform(T, part.shape.mesh().vertices)
        for T, part in zip(Ts, body.parts, strict=True)
    ]
    to_middle = _middle(mesh.vertices) - _middle(np.concatenate(shapes))
    moved = Pose(pose.Rs_parent_part, pose.p_camera_root + to_middle)
    in_sight = pose_transforms(skeleton, moved)[:, 2, 3].min() > NEAREST_M
    return moved if in_sight else pose


def _middle(points: Array) -> Array:
    """(3,) of the box around points."""
    return np.asarray((points.min(axis=0) + points.max(axis=0)) / 2)


def path_from(path: Path, folder: Path) -> str:
    """Relative where both lie on one disk, so that a folder can be moved as a whole."""
    try:
        return Path(os.path.relpath(path.absolute(), folder.absolute())).as_posix()
    except ValueError:  # another drive
        return str(path.absolute())


def require_text(path: Path) -> None:
    """A session is text, so are what it calls its video and what the page is sent; SessionError."""
    try:
        str(path).encode()
    except UnicodeEncodeError:
        raise SessionError(
            f"The name {str(path)!r} is not valid UTF-8: rename it or its folder."
        ) from None
