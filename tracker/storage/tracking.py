"""Tracking a saved session: its keyframes, masks and settings handed to the tracker."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from tracker.body.skeleton import Skeleton
from tracker.body.trajectory import Trajectory
from tracker.errors import SessionError
from tracker.session.schema import Session
from tracker.surface.fit.fitter import SurfaceFitter
from tracker.surface.picture import SurfaceVideo
from tracker.surface.source import SurfaceSteps, UnratedSteps
from tracker.surface.steps import Steps
from tracker.tracking.pool import Progress, SegmentTracker, never, run
from tracker.tracking.tracker import Tracker
from tracker.video import Video
from tracker.video.clip_loader import MEMORY_BYTES


def tracker_of(
    session: Session,
    video: Video,
    memory: int = MEMORY_BYTES,
    first_motion: Trajectory | None = None,
) -> Tracker:
    """A session made ready to be tracked; SessionError with fewer than two keyframes, or without
    the first motion that the session speaks of and its settings use."""
    require_first_motion(session, first_motion)
    skeleton = Skeleton.of(session.body)
    return Tracker(
        video,
        session.camera,
        skeleton,
        {keyframe.frame: keyframe.pose(skeleton) for keyframe in session.keyframes},
        session.ignore_masks,
        session.settings.static_camera,
        memory,
        first_motion,
    )


def fitter_of(session: Session, video: Video) -> SurfaceFitter:
    """A session about surfaces made ready to be fitted; `video` as `open_video_of` opens it.

    SessionError without a keyframe.
    """
    return SurfaceFitter(session, steps_of(session, video))


def steps_of(session: Session, video: Video) -> Steps:
    """The surfaces that a session is fitted to: its cameras are asked only where they count."""
    steps = surfaces_of(video)
    believed = session.surface is not None and session.surface.weights in ("both", "photo")
    return steps if believed else UnratedSteps(steps)


def surfaces_of(video: Video) -> SurfaceSteps:
    """The surfaces that a session's video shows; SessionError where it is a film."""
    if not isinstance(video, SurfaceVideo):
        raise SessionError("The session is about surfaces: open them with open_video_of.")
    return video.steps


def track_session(
    session: Session,
    video: Video,
    *,
    segments: Sequence[int] | None = None,
    workers: int = 1,
    cancelled: Callable[[], bool] = never,
    first_motion: Trajectory | None = None,
) -> Iterator[Progress]:
    """Track a session's segments with its own settings; see `pool.run` for the events.

    Each worker may hold one segment's pictures. first_motion: what `first_motion.of_session` reads
    beside the session's file. A session about surfaces is fitted to them.
    """
    tracker: SegmentTracker
    if session.surface is None:
        tracker = tracker_of(session, video, MEMORY_BYTES, first_motion)
    else:
        tracker = fitter_of(session, video)
    yield from run(tracker, session.settings, segments, workers, cancelled)


def require_first_motion(session: Session, first_motion: Trajectory | None) -> None:
    """SessionError unless the motion that the settings start from is there."""
    initial, told = session.settings.initial, session.first_motion
    if initial == "import" and told is None:
        raise SessionError(
            "settings.initial is import, but the session has no imported motion: run keypose "
            "import first, or set it to auto."
        )
    if initial != "linear" and told is not None and first_motion is None:
        raise SessionError(
            f"The imported motion {told.file} was not read; tracking starts from it."
        )
