"""What tracking has found, segment by segment, each with the key of what it was tracked for.

A segment is up to date when there is a result of its present key. Results of other keys stay for a
while: undoing a change finds them again.
"""

from __future__ import annotations

from tracker.storage.results.collection import Results, State
from tracker.storage.results.disk import load_results, save_results, tidy_tracks
from tracker.storage.results.frames import (
    Fitting,
    listed,
    observability,
    pose_at,
    residual,
    rotations,
)
from tracker.storage.results.keys import Span, segment_key, segment_keys
from tracker.storage.results.track import SegmentTrack

__all__ = [
    "Fitting",
    "Results",
    "SegmentTrack",
    "Span",
    "State",
    "listed",
    "load_results",
    "observability",
    "pose_at",
    "residual",
    "rotations",
    "save_results",
    "segment_key",
    "segment_keys",
    "tidy_tracks",
]
