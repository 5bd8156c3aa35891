"""The method: from a video, a body and posed keyframes to a drift-corrected motion.

The names below are the whole of what most programs need:

    from keypose.tracker import Video, load_session, track_session, TrackFinished

    session = load_session(path)
    with Video.open("clip.mp4") as video:
        for event in track_session(session, video):
            ...                      # SegmentStarted, PassFinished, SegmentFinished, TrackFinished

Sessions that were drafted, or have imported keypoints, are tracked with what lies beside their
file: `track_session(session, video, keypoints=keypoints_of_session(session, path.parent))`.

They are imported when first used, so that importing a corner of the package costs only that corner.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_MODULES = {
    "Body": "keypose.tracker.body.body",
    "Camera": "keypose.tracker.geometry.camera",
    "Cancelled": "keypose.tracker.tracking.pool",
    "FoundAhead": "keypose.tracker.tracking.ahead.follow",
    "Keyframe": "keypose.tracker.session",
    "KeyposeError": "keypose.tracker.errors",
    "PassFinished": "keypose.tracker.tracking.pool",
    "Pose": "keypose.tracker.body.pose",
    "SegmentFinished": "keypose.tracker.tracking.pool",
    "SegmentResult": "keypose.tracker.tracking.result",
    "SegmentStarted": "keypose.tracker.tracking.pool",
    "Session": "keypose.tracker.session",
    "Skeleton": "keypose.tracker.body.skeleton",
    "TrackFinished": "keypose.tracker.tracking.pool",
    "TrackResult": "keypose.tracker.tracking.result",
    "TrackSettings": "keypose.tracker.session",
    "Tracker": "keypose.tracker.tracking.tracker",
    "Trajectory": "keypose.tracker.body.trajectory",
    "Verdict": "keypose.tracker.session",
    "Video": "keypose.tracker.video",
    "VideoReference": "keypose.tracker.session",
    "evaluate": "keypose.tracker.evaluate",
    "interpolate": "keypose.tracker.body.trajectory",
    "keypoints_of_session": "keypose.tracker.storage.sidecars",
    "load_session": "keypose.tracker.storage.files",
    "open_video_of": "keypose.tracker.storage.files",
    "preset": "keypose.tracker.body.body",
    "save_result": "keypose.tracker.storage.tracks",
    "save_session": "keypose.tracker.storage.files",
    "track_ahead": "keypose.tracker.operations.track",
    "track_session": "keypose.tracker.operations.track",
    "verdict_words": "keypose.tracker.formats.verdict_words",
}

__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'tracker' has no attribute {name!r}")
    return getattr(import_module(_MODULES[name]), name)


def __dir__() -> list[str]:
    return __all__
