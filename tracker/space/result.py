"""What the last solve found for a stretch of neighbouring segments."""

from __future__ import annotations

from dataclasses import dataclass

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.results import PinResult, SpaceFinding


@dataclass(frozen=True, eq=False)
class SpaceResult:
    """The motion of a stretch in space.

    key: of what it was solved for, see `keypose.tracker.operations.solve_space`.
    pins: how well each holds.  proposed: where feet stand still that have none.
    findings: what is not plausible.  floor_m: height of the floor, where pins on it show it.
    """

    key: str
    motion: Trajectory
    pins: tuple[PinResult, ...] = ()
    proposed: tuple[Pin, ...] = ()
    findings: tuple[SpaceFinding, ...] = ()
    floor_m: float | None = None

    @property
    def span(self) -> tuple[int, int]:
        return self.motion.first_frame, self.motion.last_frame
