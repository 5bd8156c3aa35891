"""Sessions and results in a handful of frames, for what the page's server keeps."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from keypose.tracker.body.trajectory import Pass, Trajectory
from keypose.tracker.session import Session
from keypose.tracker.session.settings import Quality
from keypose.tracker.session.verdict import GOOD, Verdict
from keypose.tracker.storage.results import Results, segment_key
from keypose.tracker.tracking.result import Diagnostics, SegmentResult
from tests.tracker import session_cases as cases

PARTS = cases.SKELETON.part_count


def session(**changes: Any) -> Session:
    """Keyframes at 0, 4 and 8."""
    return cases.session().changed(changes)


def track(
    of: Session, first: int, last: int, quality: Quality = "full", kind: cases.Kind = "good",
    bend: float = 0.1,
) -> SegmentResult:  # fmt: skip
    """A finished segment with its present key."""
    found = cases.segment(first, last, kind, bend)
    return replace(found, key=segment_key(of, first, last), quality=quality)


def passing(of: Session, first: int, last: int, bend: float, quality: Quality = "full") -> Any:
    """A trajectory on the way."""
    path = cases.segment(first, last, bend=bend).trajectory
    return SegmentResult.on_the_way(Pass("pass", path, 2.0), segment_key(of, first, last), quality)


def both(of: Session) -> Results:
    """Both segments of `session`, finished."""
    return Results().with_result(track(of, 0, 4)).with_result(track(of, 4, 8))


def judged(
    first: int, last: int, verdict: Verdict = GOOD, observability: Any = None
) -> SegmentResult:
    """A finished segment of any length with a verdict."""
    steps = last - first
    path = Trajectory(first, np.tile(np.eye(3), (steps + 1, 2, 1, 1)), np.ones((steps + 1, 3)))
    seen = np.full((steps, 2), 0.9) if observability is None else observability
    found = Diagnostics(np.full(steps, 3), np.ones((steps, 3)), seen, np.ones((steps, 2)))
    return SegmentResult(path, verdict, found, (1.0,), ("pass",), key=f"{first}-{last}")
