"""Do one order on the worker's threads, and keep what is ready between orders."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from threading import Event
from typing import Any

from pydantic import ValidationError

from keypose.app.jobs.messages import (
    JobFailed,
    JobFinished,
    Order,
    PassFinished,
    Report,
    SegmentFinished,
    SpaceOrder,
    SpaceSolved,
    Started,
)
from keypose.app.jobs.wire import failure_message
from keypose.tracker.errors import SessionError, one_sentence
from keypose.tracker.session import Session
from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence
from keypose.tracker.session.settings import Quality, TrackSettings
from keypose.tracker.storage import sidecars
from keypose.tracker.storage.evidence import files_of
from keypose.tracker.storage.files import open_for_work
from keypose.tracker.storage.tracking import fitter_of, steps_of, tracker_of
from keypose.tracker.surface.fit.fitter import SurfaceFitter
from keypose.tracker.surface.mesh import Steps
from keypose.tracker.tracking import pool as tracked
from keypose.tracker.tracking.pool import (
    SegmentEvent,
    SegmentFailed,
    SegmentTracker,
    Task,
    run_tasks,
)
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video


class WorkerCache:
    """The open video, its prepared pictures, the skeleton.

    Pictures stay prepared while video, camera, masks and the plate setting are the same; what is
    built for the body stays while the body does. Of surfaces the latest meshes stay.
    """

    def __init__(self) -> None:
        self._video: Video | None = None
        self._opened: Any = None
        self._prepared_for: Any = None
        self._tracker: Tracker | None = None
        self._fitted_for: Any = None
        self._fitter: SurfaceFitter | None = None

    def tracker(self, session: Session, video_path: str, folder: Path = Path()) -> SegmentTracker:
        """Return what tracks the segments of a session.

        folder: of the session's file, where the motion lies that it may start from.

        KeyposeError in one sentence where it cannot be had.
        """
        return _TRACKERS.of(session)(self, session, video_path, folder)

    def fitter(self, session: Session, path: str, folder: Path) -> SurfaceFitter:
        """Return what fits the surfaces of a session; as the last one while nothing of it is
        another.
        """
        made_of = (session.body, session.surface, session.keyframes)
        video = self.video(session, path, folder)
        if self._fitter is None or self._fitted_for != made_of:
            self._fitter, self._fitted_for = fitter_of(session, video), made_of
        return self._fitter

    def surfaces(self, session: Session, path: str, folder: Path) -> Steps:
        """The surfaces that a session is fitted to, in the camera's frame."""
        return steps_of(session, self.video(session, path, folder))

    def of_film(self, session: Session, path: str, folder: Path) -> SegmentTracker:
        """Return what tracks the segments of a film."""
        return self._film_tracker(session, path, folder)

    def follower(self, session: Session, path: str, folder: Path) -> Tracker:
        """Return what follows the body of a film, of which one keyframe is enough."""
        return self._film_tracker(session, path, folder, fewest=1)

    def _film_tracker(self, session: Session, path: str, folder: Path, fewest: int = 2) -> Tracker:
        video = self.video(session, path)
        masks, static = session.ignore_masks, session.has_static_camera
        prepared_for = (self._opened, session.camera, masks, static)
        if prepared_for != self._prepared_for:
            self._tracker, self._prepared_for = None, prepared_for
        self._tracker = tracker_of(
            session,
            video,
            first_motion=sidecars.first_motion_of_session(session, folder),
            like=self._tracker,
            keypoints=sidecars.keypoints_of_session(session, folder),
            fewest=fewest,
        )
        return self._tracker

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
        self._video = self._opened = self._prepared_for = self._tracker = None
        self._fitter = self._fitted_for = None


_TRACKERS = ByEvidence({FilmEvidence: WorkerCache.of_film, SurfaceEvidence: WorkerCache.fitter})


Send = Callable[[Report], None]


class Job:
    """An order at work. Every segment ends at its next pass once `cancelled` is set."""

    def __init__(self, order: Order, cancelled: Event, send: Send) -> None:
        self.order = order
        self._cancelled = cancelled
        self._send = send
        self.error: Exception | None = None
        """The first that was met, as it was raised; SessionError where memory ran out."""

    def run(self, worker_cache: WorkerCache, threads: Executor) -> None:
        """Do the work and report how it goes. Returns when all of it is done or left."""
        try:
            self._run(worker_cache, threads)
        except Exception as error:  # noqa: BLE001 — said in a sentence; rerun raises it again
            self.error = error
            self._send(JobFailed(self.order.job, _message(error)))

    def _run(self, worker_cache: WorkerCache, threads: Executor) -> None:
        order = self.order
        session = Session.model_validate_json(order.session)
        stages = _stages(session.settings, order.stages)
        self._send(Started(order.job, order.wanted, stages))
        tasks = [
            Task(index, (first, last), _settings(session.settings, stage), key)
            for stage in stages
            for index, (first, last, key) in enumerate(order.wanted)
        ]
        complete = True
        if tasks:
            tracker = worker_cache.tracker(session, order.video_path, Path(order.folder))
            complete = run_tasks(tracker, tasks, threads, self._report, self._cancelled.is_set)
        if self.error is not None:
            self._send(JobFailed(order.job, _message(self.error)))
        else:
            self._send(JobFinished(order.job, cancelled=not complete))

    def _report(self, event: SegmentEvent) -> None:
        job = self.order.job
        match event:
            case SegmentFailed():
                self.error = self.error or _as_session_error(event)
            case tracked.SegmentFinished():
                self._send(SegmentFinished(job, event.result))
            case tracked.PassFinished() if event.result.quality != "preview":
                # of a preview the next pass would be there before this one is drawn
                self._send(PassFinished(job, event.number, event.of, event.result))


def _stages(settings: TrackSettings, stages: tuple[Quality, ...]) -> tuple[Quality, ...]:
    """The published method knows no qualities: once is enough."""
    return stages[-1:] if settings.method == "paper" else stages


def _settings(settings: TrackSettings, stage: Quality) -> TrackSettings:
    """The session's settings at one quality; a preview keeps to its own number of passes."""
    passes = None if stage == "preview" and settings.method == "keypose" else settings.passes
    return settings.model_copy(update={"quality": stage, "passes": passes})


def _too_long(first: int, last: int) -> str:
    return (
        f"There is not enough memory to track {first}–{last}: set a keyframe between, "
        "or close other programs."
    )


def _as_session_error(failed: SegmentFailed) -> Exception:
    too_large = isinstance(failed.error, MemoryError)
    return SessionError(_too_long(*failed.span)) if too_large else failed.error


def _message(error: Exception) -> str:
    """One sentence for the person; of a fault, all of it for whoever reads the log."""
    if isinstance(error, ValidationError):
        return one_sentence(error)
    return failure_message(
        error,
        "Tracking failed with an internal error ({}). Finished work is kept; try again.",
    )


_FAULT = "Smoothing failed with an internal error ({}). The motion is as it was tracked."


def solve_order(order: SpaceOrder, cancelled: Event, send: Send) -> None:
    """Do the work and report every stretch, and how it ended."""
    from keypose.tracker.storage.space import solved  # loads what only this needs

    try:
        session = Session.model_validate_json(order.session)
        for stretch in order.stretches:
            found = solved(session, stretch, cancelled.is_set)
            if cancelled.is_set():
                break
            send(SpaceSolved(order.job, found))
    except Exception as error:  # noqa: BLE001 — a fault, reported as such
        send(JobFailed(order.job, failure_message(error, _FAULT)))
    else:
        send(JobFinished(order.job, cancelled=cancelled.is_set()))
