"""Sessions and results in a handful of frames, for what the page's server keeps."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.tracker import session_cases as cases
from tracker.body.trajectory import Trajectory
from tracker.session import Session
from tracker.session.settings import Quality
from tracker.session.verdict import GOOD, Verdict
from tracker.storage.results import Results, SegmentTrack, segment_key

PARTS = cases.SKELETON.part_count


def session(**changes: Any) -> Session:
    """Keyframes at 0, 4 and 8."""
    return cases.session().model_copy(update=changes)


def track(
    of: Session, first: int, last: int, quality: Quality = "full", kind: cases.Kind = "good",
    bend: float = 0.1,
) -> SegmentTrack:  # fmt: skip
    """A finished segment with its present key."""
    found = cases.segment(first, last, kind, bend)
    return SegmentTrack.of(segment_key(of, first, last), quality, found)


def passing(of: Session, first: int, last: int, bend: float, quality: Quality = "full") -> Any:
    """A trajectory on the way."""
    path = cases.segment(first, last, bend=bend).trajectory
    return SegmentTrack.on_the_way(segment_key(of, first, last), quality, path, 2.0)


def both(of: Session) -> Results:
    """Both segments of `session`, finished."""
    return Results().with_track(track(of, 0, 4)).with_track(track(of, 4, 8))


def judged(
    first: int, last: int, verdict: Verdict = GOOD, observability: Any = None
) -> SegmentTrack:
    """A finished segment of any length with a verdict."""
    steps = last - first
    path = Trajectory(first, np.tile(np.eye(3), (steps + 1, 2, 1, 1)), np.ones((steps + 1, 3)))
    seen = np.full((steps, 2), 0.9) if observability is None else observability
    return SegmentTrack(
        first, last, f"{first}-{last}", "full", path, verdict, (1.0,), ("pass",), 0, 0.0,
        np.full(steps, 3), np.ones((steps, 3)), seen, np.ones((steps, 2)),
    )  # fmt: skip
