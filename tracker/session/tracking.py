"""Tracking a saved session: its keyframes, masks and settings handed to the tracker."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from tracker.loading import MEMORY_BYTES
from tracker.session.schema import Session
from tracker.skeleton import Skeleton
from tracker.track import Progress, Tracker, never, run
from tracker.video import Video


def tracker_of(session: Session, video: Video, memory: int = MEMORY_BYTES) -> Tracker:
    """A session made ready to be tracked; SessionError with fewer than two keyframes."""
    skeleton = Skeleton.of(session.body)
    return Tracker(
        video,
        session.camera,
        skeleton,
        {keyframe.frame: keyframe.pose(skeleton) for keyframe in session.keyframes},
        session.ignore_masks,
        session.settings.static_camera,
        memory,
    )


def track_session(
    session: Session,
    video: Video,
    *,
    segments: Sequence[int] | None = None,
    workers: int = 1,
    cancelled: Callable[[], bool] = never,
) -> Iterator[Progress]:
    """Track a session's segments with its own settings; see tracker.track.run for the events.

    Each worker may hold one segment's pictures.
    """
    tracker = tracker_of(session, video, MEMORY_BYTES)
    yield from run(tracker, session.settings, segments, workers, cancelled)
