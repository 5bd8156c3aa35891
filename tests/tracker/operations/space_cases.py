"""Sessions that ask for the last solve, with results as tracked."""

from __future__ import annotations

from typing import Any

import numpy as np

from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.session import Session
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.results import PinResult, SpaceFinding
from keypose.tracker.space.result import SpaceResult
from keypose.tracker.storage.results import Results
from keypose.tracker.storage.stretches import SegmentRun
from tests.app.results_cases import both, session
from tests.tracker import session_cases as cases

PIN = Pin(part="left_hand", landmarks=("tip",), first_frame=1, last_frame=6)


def smooth(of: Session | None = None, **changes: Any) -> Session:
    """With smoothing, and perhaps other settings."""
    given = session() if of is None else of
    settings = given.settings.model_copy(update={"smooth": True, **changes})
    return given.changed({"settings": settings})


def pinned(*pins: Pin, **changes: Any) -> Session:
    """With these pins; with one where none is given."""
    return session(pins=pins or (PIN,), **changes)


def softened(of: Session, *frames: int) -> Session:
    """With soft keyframes at these frames."""
    keyframes = tuple(
        keyframe.model_copy(update={"soft": keyframe.frame in frames})
        for keyframe in of.subject.keyframes
    )
    return of.changed({"keyframes": keyframes})


def solution(stretch: SegmentRun, shift_m: float = 0.01, soft: tuple[int, ...] = ()) -> SpaceResult:
    """As the solve might end, with something of every kind to say of it; keyframes stay where they
    are, but for those that are soft."""
    tracked = joined([segment.as_tracked.trajectory for segment in stretch.segments])
    bow = np.full((len(tracked), 1), shift_m) * (0.0, 0.0, 1.0)
    bow[[frame - tracked.first_frame for segment in stretch.segments for frame in segment.span
         if frame not in soft]] = 0.0  # fmt: skip
    motion = Trajectory(tracked.first_frame, tracked.Rs_parent_part, tracked.ps_camera_root + bow)
    result = PinResult(
        part="left_hand", landmarks=("tip",), first_frame=1, last_frame=6, off_m=0.012,
        usual_off_m=0.003, frame=4, keyframe=4,
    )  # fmt: skip
    finding = SpaceFinding(
        kind="slides", part="left_hand", first_frame=0, last_frame=3, go=2, amount=0.07
    )
    proposed = Pin(part="right_arm", first_frame=2, last_frame=7)
    return SpaceResult(stretch.key, motion, (result,), (proposed,), (finding,), -0.8)


def solved(of: Session, results: Results | None = None, shift_m: float = 0.01) -> Results:
    """All that is wanted in space found."""
    found = both(of) if results is None else results
    for stretch in found.unsolved(of):
        soft = tuple(keyframe.frame for keyframe in of.subject.keyframes if keyframe.soft)
        found = found.with_space(solution(stretch, shift_m, soft))
    return found


def depths(results: Results, of: Session) -> list[float]:
    """The root's depth at every segment's second frame."""
    found = results.fitting(of)
    return [float(found[span].trajectory.ps_camera_root[1, 2]) for span in sorted(found)]


__all__ = [
    "PIN", "both", "cases", "depths", "pinned", "session", "smooth", "softened", "solution",
    "solved",
]  # fmt: skip
