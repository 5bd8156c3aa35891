"""Figures of a segment, as a report writes them."""

from __future__ import annotations

import math

from keypose.app.posing.labels import number_text
from keypose.tracker.tracking.result import SegmentResult


def figure(value: float, digits: int) -> str:
    """A number, or a dash where there is none."""
    return number_text(value, digits) if math.isfinite(value) else "–"


def best_score(track: SegmentResult) -> float:
    """The score of the pass that was kept; NaN where a file names one that is not there."""
    known = 0 <= track.best_pass < len(track.scores)
    return track.scores[track.best_pass] if known else math.nan
