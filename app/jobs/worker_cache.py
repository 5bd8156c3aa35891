"""Keep what is ready between jobs in the worker."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.operations.films import film_beside, prepared_film
from keypose.tracker.operations.occlusion import ignored_regions
from keypose.tracker.operations.track import fitter_of, steps_of, tracker_of
from keypose.tracker.session import Session
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence
from keypose.tracker.storage import sidecars
from keypose.tracker.storage.evidence import files_of
from keypose.tracker.storage.files import open_for_work, open_video_of, video_path
from keypose.tracker.storage.fingerprints import background_turns, steady_camera
from keypose.tracker.surface.fit.fitter import SurfaceFitter
from keypose.tracker.surface.mesh import Steps
from keypose.tracker.tracking.film_beside import FilmBeside
from keypose.tracker.tracking.pool import SegmentTracker
from keypose.tracker.tracking.prepared_film import PreparedFilm
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video
from keypose.tracker.video.clip_loader import AGAIN, Memory


class WorkerCache:
    """The open video, its prepared pictures, the skeleton.

    Pictures stay prepared while video, camera, masks and the plate setting are the same; what is
    built for the body stays while the body does. Of surfaces the latest meshes stay.
    """

    def __init__(self, memory: Memory = AGAIN) -> None:
        self._memory = memory
        self._video: Video | None = None
        self._opened: Any = None
        self._prepared_for: Any = None
        self._tracker: Tracker | None = None
        self._fitted_for: Any = None
        self._fitter: SurfaceFitter | None = None
        self._keypoints: tuple[Path, Keypoints] | None = None
        self._others: dict[str, tuple[Any, Video, PreparedFilm]] = {}

    def tracker(self, session: Session, video_path: str, folder: Path = Path()) -> SegmentTracker:
        """What tracks the segments of a session.

        folder: of the session's file, where the motion lies that it may start from.

        KeyposeError in one sentence where it cannot be had.
        """
        return _TRACKERS.of(session)(self, session, video_path, folder)

    def fitter(self, session: Session, path: str, folder: Path) -> SurfaceFitter:
        """What fits the surfaces of a session; as the last one while nothing of it is
        another.
        """
        made_of = (session.subject.body, session.view.surface, session.subject.keyframes)
        video = self.video(session, path, folder)
        if self._fitter is None or self._fitted_for != made_of:
            self._fitter, self._fitted_for = fitter_of(session, video), made_of
        return self._fitter

    def surfaces(self, session: Session, path: str, folder: Path) -> Steps:
        """The surfaces that a session is fitted to, in the camera's frame."""
        return steps_of(session, self.video(session, path, folder))

    def of_film(self, session: Session, path: str, folder: Path) -> SegmentTracker:
        """What tracks the segments of a film."""
        return self._film_tracker(session, path, folder)

    def follower(self, session: Session, path: str, folder: Path) -> Tracker:
        """What follows the body of a film, of which one keyframe is enough."""
        return self._film_tracker(session, path, folder, fewest=1)

    def _film_tracker(self, session: Session, path: str, folder: Path, fewest: int = 2) -> Tracker:
        video = self.video(session, path)
        masks, static = ignored_regions(session), session.has_static_camera
        around = steady_camera(session), background_turns(session) is not None
        prepared_for = (self._opened, session.view.camera, masks, static, *around)
        if prepared_for != self._prepared_for:
            self._tracker, self._prepared_for = None, prepared_for
        self._tracker = tracker_of(
            session,
            video,
            self._memory,
            first_motion=sidecars.load_first_motion(session, folder),
            like=self._tracker,
            keypoints=self.keypoints(session, folder),
            fewest=fewest,
            films=self._films_beside(session, folder),
        )
        return self._tracker

    def _films_beside(self, session: Session, folder: Path) -> tuple[FilmBeside, ...]:
        """The other films of a session; their pictures stay prepared while nothing that they are
        prepared with is another."""
        films = []
        for view in session.views[1:]:
            alone = session.alone(view.id)
            made_of: tuple[Any, ...] = (
                files_of(alone).state(alone, video_path(alone, folder / "session.json"), folder),
                view.video,
                view.camera,
                view.ignore_masks,
                view.camera_motion,
                view.camera_keyframes,
                alone.has_static_camera,
                session.settings.cues_used,
            )
            kept = self._others.get(view.id)
            if kept is None or kept[0] != made_of:
                self._close_other(view.id)
                video = open_video_of(alone, folder / "session.json")
                kept = (made_of, video, prepared_film(session, view, video, self._memory))
                self._others[view.id] = kept
            films.append(film_beside(session, view, kept[2], folder))
        for gone in set(self._others) - {view.id for view in session.views[1:]}:
            self._close_other(gone)
        return tuple(films)

    def _close_other(self, view_id: str) -> None:
        kept = self._others.pop(view_id, None)
        if kept is not None:
            kept[1].close()

    def keypoints(self, session: Session, folder: Path) -> Keypoints | None:
        """The keypoints beside a session's file, read again only when they are others.

        KeypointError as of `keypoints_of_session`.
        """
        if session.view.keypoints is None:
            return None
        path = folder / session.view.keypoints.file  # named by its content
        if self._keypoints is None or self._keypoints[0] != path:
            read_keypoints = sidecars.keypoints_of_session(session, folder)
            self._keypoints = None if read_keypoints is None else (path, read_keypoints)
        return self._keypoints and self._keypoints[1]

    def video(self, session: Session, path: str, folder: Path = Path()) -> Video:
        """The video at a path, opened again only when another file lies there now; or when the
        session has its surfaces read otherwise.

        folder: of the session's file.  SessionError where there are now more or fewer surfaces
        than the session has steps: every one after that would be another one's.
        """
        opened = files_of(session).state(session, Path(path), folder)
        if self._video is None or opened != self._opened:
            self.close()
            self._video = open_for_work(session, Path(path), folder)
            self._opened = opened
        return self._video

    def close(self) -> None:
        """Close the video."""
        if self._video is not None:
            self._video.close()
        for view_id in list(self._others):
            self._close_other(view_id)
        self._video = self._opened = self._prepared_for = self._tracker = None
        self._fitter = self._fitted_for = None


_TRACKERS = ByEvidence({FilmEvidence: WorkerCache.of_film, SurfaceEvidence: WorkerCache.fitter})
