"""Keep tracking results by segment, each with the key of what it was tracked for.

A segment is up to date when there is a result of its present key. Results of other keys stay for a
while: undoing a change finds them again.
"""

from __future__ import annotations

from keypose.tracker.storage.fingerprints import Span, segment_key, segment_keys
from keypose.tracker.storage.results.collection import Results, State
from keypose.tracker.storage.results.disk import (
    load_all_results,
    load_results,
    save_all_results,
    save_results,
    tidy_tracks,
)
from keypose.tracker.storage.results.frames import (
    Fitting,
    expected_gain,
    listed,
    observability,
    pose_at,
    ranks,
    residual,
    root_positions,
    rotations,
)

__all__ = [
    "Fitting",
    "Results",
    "Span",
    "State",
    "expected_gain",
    "listed",
    "load_all_results",
    "load_results",
    "observability",
    "pose_at",
    "ranks",
    "residual",
    "root_positions",
    "rotations",
    "save_all_results",
    "save_results",
    "segment_key",
    "segment_keys",
    "tidy_tracks",
]
