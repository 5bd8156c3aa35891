"""The session: what a person edits and saves, and the file it lives in."""

from tracker.session.results import Results, SegmentSummary
from tracker.session.schema import Keyframe, PartKeyframe, Session, VideoReference
from tracker.session.settings import IgnoreMask, TrackSettings
from tracker.session.verdict import Verdict

__all__ = [
    "IgnoreMask",
    "Keyframe",
    "PartKeyframe",
    "Results",
    "SegmentSummary",
    "Session",
    "TrackSettings",
    "Verdict",
    "VideoReference",
]
