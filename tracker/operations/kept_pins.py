"""Solve for a session on its floor, and release the contacts that would harm its motion."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import SessionError
from keypose.tracker.operations.solve_space import asked, compared, stances
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.schema import Session
from keypose.tracker.solver.sigmas import TILT_GIVES_RAD
from keypose.tracker.space.harm import Harm, harms, worst_apart, worst_of_each
from keypose.tracker.space.soles import AIR_M, foot_heights
from keypose.tracker.space.solve import SpaceProblem, SpaceSolution, solve_space
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.storage.stretches import SegmentRun, stretches
from keypose.tracker.tracking.result import SegmentResult

ROUNDS: Final = 3
"""Solves at most: all but the last release what harms most, this one all that does."""
APART_S: Final = 0.5
"""What is so near to a pin that harms more may be harmed by that alone."""
MOST_TILT_RAD: Final = np.radians(8.0)
"""A floor does not tilt by more: what seems so are stairs."""

Cancelled = Callable[[], bool] | None


@dataclass(frozen=True, eq=False)
class Solved:
    """A stretch on the floor.  pins: those within, clipped to its frames."""

    problem: SpaceProblem
    solution: SpaceSolution
    pins: tuple[Pin, ...]

    @cached_property
    def harms(self) -> tuple[Harm, ...]:
        """What every pin does."""
        return harms(compared(self.problem, self.solution), self.pins)

    @property
    def in_world(self) -> Trajectory:
        """The motion."""
        return self.problem.in_world(self.solution.motion)


@dataclass(frozen=True, eq=False)
class Kept:
    """A session on its floor, and how its stretches were solved for.  released: what contacts that
    are no pins now would have done."""

    session: Session
    runs: tuple[Solved, ...]
    released: tuple[Harm, ...]

    @property
    def harms(self) -> tuple[Harm, ...]:
        """What every pin does that is left."""
        gone = [harm.pin for harm in self.released]
        return tuple(harm for run in self.runs for harm in run.harms if harm.pin not in gone)

    def hanging(self) -> tuple[tuple[Pin, float], ...]:
        """Feet that stand still above the floor and are not pinned, and by how many metres."""
        session, up = self.session, self.session.world.up
        skeleton, hanging_feet = Skeleton.of(session.subject.body), []
        for run in self.runs:
            for pin in stances(session, run.in_world, up):
                heights = foot_heights(skeleton, run.in_world, pin, up).min(axis=1)
                high = float(np.median(heights)) - (session.world.floor_m or 0.0)
                gone = [harm.pin for harm in self.released]
                held = any(pin.overlaps(kept_pin) for kept_pin in (*session.subject.pins, *gone))
                if high > AIR_M and not held:
                    hanging_feet.append((pin, high))
        return tuple(hanging_feet)


def without_harm(
    session: Session,
    proposed: Collection[Pin],
    fitting: Mapping[Span, SegmentResult],
    cancelled: Cancelled = None,
    *,
    tilts: bool = True,
) -> Kept:
    """The session on its floor without those of the proposed pins that would harm its motion, the
    others kept whatever they do; SessionError where no foot could stay on the floor.

    tilts: whether the floor may.
    """
    tracked = {span: segment_result.as_tracked for span, segment_result in fitting.items()}
    released: list[Harm] = []
    starts: dict[int, Trajectory] = {}
    for left in reversed(range(ROUNDS)):
        floored, runs = _floored(session, stretches(session, tracked), starts, cancelled, tilts)
        kept = Kept(floored, runs, tuple(released))
        much = [harm for harm in kept.harms if harm.is_too_much and harm.pin in proposed]
        if not much or (cancelled is not None and cancelled()):
            return kept
        rate = runs[0].problem.frames_per_second
        released += worst_apart(much, round(APART_S * rate)) if left else worst_of_each(much)
        gone = [harm.pin for harm in released]
        pins = tuple(pin for pin in session.subject.pins if pin not in gone)
        session = session.changed({"pins": pins})
        _require_floor(stretches(session, tracked), released)
        starts = {run.problem.motion.first_frame: run.solution.motion for run in runs}
    return Kept(floored.changed({"pins": pins}), runs, tuple(released))


def _require_floor(runs: Sequence[SegmentRun], released: Sequence[Harm]) -> None:
    if not any(pin.floor for run in runs for pin in run.pins):
        worst = max(released, key=lambda harm: harm.share)
        does = (
            f"move a joint by {worst.amount:.0f} px in the picture"
            if worst.kind == "picture"
            else f"bend a knee by {np.degrees(worst.amount):.0f}°"
        )
        raise SessionError(
            f"No foot can be held where it seems to stand: that would {does}. Check the depth of "
            "the keyframes and the horizon, or pin a foot by hand."
        )


def _floored(
    session: Session,
    runs: Sequence[SegmentRun],
    starts: Mapping[int, Trajectory],
    cancelled: Cancelled,
    tilts: bool,
) -> tuple[Session, tuple[Solved, ...]]:
    """The session with the floor with which its longest stretch is solved for, its height and its
    tilt, which gives way a little where it may; and all stretches on that."""
    floored = [run for run in runs if any(pin.floor for pin in run.pins)]
    longest = max(floored, key=lambda run: run.span[1] - run.span[0])
    solved_of_span: dict[Span, Solved] = {}
    for run in (longest, *(run for run in runs if run is not longest)):
        problem = asked(session, run).problem
        start = starts.get(run.span[0])
        may_tilt = tilts and run is longest
        if may_tilt:
            tilting = replace(problem, tilt_rad=TILT_GIVES_RAD)
            solution = solve_space(tilting, cancelled, start)
        if not may_tilt or solution.up_world @ problem.up_world < np.cos(MOST_TILT_RAD):
            solution = solve_space(problem, cancelled, start)
        if run is longest:
            x, y, z = solution.up_world.tolist()
            assert solution.floor_m is not None
            floor_m = round(solution.floor_m, 4)
            session = session.changed({"floor_m": floor_m, "up_world": (x, y, z)})
        solved_of_span[run.span] = Solved(problem, solution, run.pins)
    return session, tuple(solved_of_span[span] for span in sorted(solved_of_span))
