"""What the last solve found for a stretch of neighbouring segments."""

from __future__ import annotations

from dataclasses import dataclass

from tracker.body.trajectory import Trajectory
from tracker.session.results import PinResult


@dataclass(frozen=True, eq=False)
class SpaceResult:
    """The motion of a stretch in space.

    key: of what it was solved for, see `tracker.storage.space`.
    pins: how well each holds.  floor_m: height of the floor, where pins on it told.
    """

    key: str
    motion: Trajectory
    pins: tuple[PinResult, ...] = ()
    floor_m: float | None = None

    @property
    def span(self) -> tuple[int, int]:
        return self.motion.first_frame, self.motion.last_frame
