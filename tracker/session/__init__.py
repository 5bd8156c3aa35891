"""Describe a session, what a person edits and saves, as plain validated data."""

from keypose.tracker.session.keyframe import Keyframe, PartKeyframe
from keypose.tracker.session.references import VideoReference
from keypose.tracker.session.results import Results, SegmentSummary
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import IgnoreMask, TrackSettings
from keypose.tracker.session.verdict import Verdict

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
