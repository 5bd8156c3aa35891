"""What stays ready in the worker from one job to the next."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tracker.body.pose import Pose
from tracker.body.skeleton import Skeleton
from tracker.errors import SessionError
from tracker.session import Session
from tracker.storage.files import open_same_at, open_video_at
from tracker.storage.first_motion import of_session
from tracker.storage.results import Span
from tracker.storage.tracking import fitter_of, require_first_motion, steps_of
from tracker.surface.files.sources import SUFFIXES
from tracker.surface.fit.fitter import SurfaceFitter
from tracker.surface.steps import Steps
from tracker.tracking.pool import SegmentTracker
from tracker.tracking.tracker import Tracker
from tracker.video import Video


class WorkerCache:
    """The open video, its prepared pictures, the body laid out.

    Pictures stay prepared while video, camera, masks and the plate setting are the same; what is
    laid out for the body stays while the body is. Of surfaces the latest meshes stay.
    """

    def __init__(self) -> None:
        self._video: Video | None = None
        self._opened: Any = None
        self._prepared_for: Any = None
        self._tracker: Tracker | None = None
        self._fitted_for: Any = None
        self._fitter: SurfaceFitter | None = None

    def tracker(
        self, session: Session, video_path: str, first: int, last: int, folder: Path = Path()
    ) -> SegmentTracker:
        """A tracker of one segment, which depends on nothing but that segment.

        folder: of the session's file, where the motion lies that it may start from.

        KeyposeError in one sentence where it cannot be had.
        """
        if session.surface is not None:
            return self.fitter(session, video_path, folder).only(first, last)
        return self._of_film(session, self.video(session, video_path), (first, last), folder)

    def fitter(self, session: Session, path: str, folder: Path) -> SurfaceFitter:
        """What fits the surfaces of a session; as the last one while nothing of it is another."""
        made_of = (session.body, session.surface, session.keyframes)
        video = self.video(session, path, folder)
        if self._fitter is None or self._fitted_for != made_of:
            self._fitter, self._fitted_for = fitter_of(session, video), made_of
        return self._fitter

    def surfaces(self, session: Session, path: str, folder: Path) -> Steps:
        """The surfaces that a session is fitted to, in the camera's frame."""
        return steps_of(session, self.video(session, path, folder))

    def _of_film(self, session: Session, video: Video, span: Span, folder: Path) -> Tracker:
        first, last = span
        masks, static = session.ignore_masks, session.settings.static_camera
        prepared_for = (self._opened, session.camera, masks, static)
        if prepared_for != self._prepared_for:
            self._tracker, self._prepared_for = None, prepared_for
        skeleton = self._skeleton(session)
        poses = _ends(session, skeleton, first, last)
        start = of_session(session, folder)
        require_first_motion(session, start)
        if self._tracker is None:
            self._tracker = Tracker(
                video, session.camera, skeleton, poses, masks, static, first_motion=start
            )
        else:
            self._tracker = self._tracker.renewed(skeleton, poses, start)
        return self._tracker

    def video(self, session: Session, path: str, folder: Path = Path()) -> Video:
        """The video at a path, opened again only when another file lies there now; or when the
        session has its surfaces read otherwise.

        folder: of the session's file.  SessionError where there are now more or fewer surfaces
        than the session has steps: every one after that would be another one's.
        """
        opened = (_identity(Path(path)), *_reading(session, Path(path), folder))
        if self._video is None or opened != self._opened:
            self.close()
            opens = open_video_at if session.surface is None else open_same_at
            self._video = opens(session, Path(path), folder)
            self._opened = opened
        return self._video

    def close(self) -> None:
        """Let go of the video."""
        if self._video is not None:
            self._video.close()
        self._video = self._opened = self._prepared_for = self._tracker = None
        self._fitter = self._fitted_for = None

    def _skeleton(self, session: Session) -> Skeleton:
        if self._tracker is not None and self._tracker.skeleton.body == session.body:
            return self._tracker.skeleton
        return Skeleton.of(session.body)


def _ends(session: Session, skeleton: Skeleton, first: int, last: int) -> dict[int, Pose]:
    """The two keyposes of a segment."""
    keyframes = {keyframe.frame: keyframe for keyframe in session.keyframes}
    for frame in (first, last):
        if frame not in keyframes:
            raise SessionError(f"Frame {frame} has no keyframe; pose it first.")
    return {frame: keyframes[frame].pose(skeleton) for frame in (first, last)}


def _reading(session: Session, meshes: Path, folder: Path) -> tuple[Any, ...]:
    """What besides the file decides what is seen of a session's surfaces; nothing of a film."""
    surface = session.surface
    if surface is None:
        return ()
    cameras = None if surface.cameras is None else _identity(folder / surface.cameras)
    files = _identities(meshes) if meshes.is_dir() else ()
    return (surface.units, surface.up, surface.p_camera_surface, cameras, files)


def _identities(folder: Path) -> tuple[Any, ...]:
    """Equal while the same meshes lie in a folder: one written over does not change the folder."""
    try:
        files = [file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES]
    except OSError:  # opening it will say what is wrong
        return ()
    return tuple(_identity(file) for file in sorted(files))


def _identity(path: Path) -> Any:
    """Equal while the same file lies at a path."""
    try:
        found = path.stat()
    except OSError:  # opening it will say what is wrong
        return path, None
    return path, found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns
