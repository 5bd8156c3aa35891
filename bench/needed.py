"""How many keyframes a clip needs: the next one is added until the motion is good enough."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from bench.measures import Mark
from keypose.tracker.tracking.result import SegmentResult

MEDIAN_PX, WORST_PX = 5.0, 10.0

Outcome = tuple[Sequence[SegmentResult], Sequence[Mark]]
"""What tracking between keyframes gave, and its errors at the marks between them."""
Track = Callable[[tuple[int, ...]], Outcome]
Choose = Callable[[Outcome, Sequence[int]], int]
"""Which of the frames that may become a keyframe is the next one."""


@dataclass(frozen=True)
class Step:
    """Keyframes, and the errors between them."""

    keyframes: tuple[int, ...]
    median: float
    worst: float

    @property
    def enough(self) -> bool:
        return self.median <= MEDIAN_PX and self.worst <= WORST_PX


def steps_to_enough(track: Track, marked: Sequence[int], choose: Choose) -> list[Step]:
    """From keyframes at the first and the last marked frame on, one more at a time.

    The last step is the first that is enough; where none is, as many marked frames are keyframes as
    leave one to measure at.
    """
    keyframes: tuple[int, ...] = (min(marked), max(marked))
    steps: list[Step] = []
    while left := sorted(set(marked) - set(keyframes)):
        outcome = track(keyframes)
        px = [mark.px for mark in outcome[1]]
        steps.append(Step(keyframes, float(np.median(px)), max(px)))
        if steps[-1].enough:
            break
        keyframes = tuple(sorted((*keyframes, choose(outcome, left))))
    return steps


def where_worst(outcome: Outcome, left: Sequence[int]) -> int:
    """The frame with the joint that is furthest off, as somebody sees who looks at all of them."""
    return max((mark for mark in outcome[1] if mark.frame in left), key=lambda m: m.px).frame


def where_suggested(outcome: Outcome, left: Sequence[int]) -> int:
    """The frame that is marked and nearest to the one the verdicts name: lost before check, and the
    longer segment first. Where none is named, the middle of the longest segment."""
    rank = {"lost": 2, "check": 1}
    segments = [s for s in outcome[0] if any(s.first < frame < s.last for frame in left)]
    worst = max(segments, key=lambda s: (rank.get(str(s.kind), 0), s.last - s.first))
    go = (worst.first + worst.last) / 2 if worst.go is None else worst.go
    inside = [frame for frame in left if worst.first < frame < worst.last]
    return min(inside, key=lambda frame: abs(frame - go))


def words(steps: Sequence[Step]) -> str:
    """Such as "4"; "> 6" where even so many are not enough."""
    count = len(steps[-1].keyframes)
    return str(count) if steps[-1].enough else f"> {count}"
