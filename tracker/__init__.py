"""The method: from a video, a body and posed keyframes to a drift-corrected motion.

The names below are the whole of what most programs need:

    from tracker import Video, load_session, track_session, TrackFinished

    session = load_session(path)
    with Video.open("clip.mp4") as video:
        for event in track_session(session, video):
            ...                      # SegmentStarted, PassFinished, SegmentFinished, TrackFinished

They are imported when first used, so that importing a corner of the package costs only that corner.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_MODULES = {
    "Body": "tracker.body.body",
    "Camera": "tracker.geometry.camera",
    "Cancelled": "tracker.tracking.pool",
    "FoundAhead": "tracker.tracking.ahead.follow",
    "Keyframe": "tracker.session",
    "KeyposeError": "tracker.errors",
    "PassFinished": "tracker.tracking.pool",
    "Pose": "tracker.body.pose",
    "SegmentFinished": "tracker.tracking.pool",
    "SegmentResult": "tracker.tracking.result",
    "SegmentStarted": "tracker.tracking.pool",
    "Session": "tracker.session",
    "Skeleton": "tracker.body.skeleton",
    "TrackFinished": "tracker.tracking.pool",
    "TrackResult": "tracker.tracking.result",
    "TrackSettings": "tracker.session",
    "Tracker": "tracker.tracking.tracker",
    "Trajectory": "tracker.body.trajectory",
    "Verdict": "tracker.session",
    "Video": "tracker.video",
    "VideoReference": "tracker.session",
    "evaluate": "tracker.evaluate",
    "interpolate": "tracker.body.trajectory",
    "load_session": "tracker.storage.files",
    "open_video_of": "tracker.storage.files",
    "preset": "tracker.body.body",
    "save_result": "tracker.storage.tracks",
    "save_session": "tracker.storage.files",
    "track_ahead": "tracker.storage.tracking",
    "track_session": "tracker.storage.tracking",
    "verdict_words": "tracker.formats.verdict_words",
}

__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'tracker' has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return __all__
