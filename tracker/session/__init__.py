"""The session: what a person edits and saves, and the file it lives in."""

from tracker.session.schema import (
    IgnoreMask,
    Keyframe,
    Results,
    SegmentSummary,
    Session,
    TrackSettings,
    VideoReference,
)

__all__ = [
    "IgnoreMask",
    "Keyframe",
    "Results",
    "SegmentSummary",
    "Session",
    "TrackSettings",
    "VideoReference",
]
