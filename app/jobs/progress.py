"""How far a job is, and how long it may still take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from keypose.tracker.session.settings import Quality
from keypose.tracker.storage.results import Span
from keypose.tracker.tracking.pool import PassFinished, SegmentFinished

COST = {"preview": 1.0, "full": 4.0}
"""Of one frame, by quality, relative to each other."""
KNOWN_SHARE = 0.1
KNOWN_SECONDS = 1.0
"""Before so much is done, and so long has passed, the time that is left is not known."""

Wanted: TypeAlias = tuple[int, int, str]
"""First frame, last frame and key of a segment to track."""
Step = tuple[Span, Quality]


def reaching(wanted: Sequence[Wanted], frames: Span | None) -> list[Wanted]:
    """Keep the segments that reach between two frames, all where none are given; one that only
    meets them with its end does not."""
    if frames is None:
        return list(wanted)
    first, last = frames
    if first == last:
        return [span for span in wanted if span[0] <= first <= span[1]]
    return [span for span in wanted if span[0] < last and span[1] > first]


@dataclass(frozen=True)
class Shares:
    """Those of a job's steps (a segment at one quality) that are done. Immutable.

    started_at, now: any clock in seconds, the same one throughout.
    given: the share of the whole job that was there when it began: a fit may go on.
    """

    started_at: float
    weights: Mapping[Step, float]
    shares: Mapping[Step, float] = field(default_factory=dict)
    given: float = 0.0

    @classmethod
    def of(cls, wanted: Sequence[Wanted], stages: Sequence[Quality], now: float) -> Shares:
        """Nothing is done yet."""
        weights = {
            ((first, last), quality): (last - first) * COST[quality]
            for first, last, _ in wanted
            for quality in stages
        }
        return cls(now, weights)

    def after(self, event: PassFinished | SegmentFinished) -> Shares:
        """Add what tracking tells."""
        step = (event.result.span, event.result.quality)
        if isinstance(event, SegmentFinished):
            return self._with(step, 1.0)
        # a segment may take more passes than expected, and is not done before it is judged
        after = self._with(step, min((event.number + 1) / (event.of + 1), 0.95))
        if not _is_of_surfaces(event) or step in self.shares:
            return after
        return replace(after, given=after.given + after.share - self.share)

    @property
    def share(self) -> float:
        """The share of the whole job, 0 to 1."""
        total = sum(self.weights.values())
        done = sum(share * self.weights.get(step, 0.0) for step, share in self.shares.items())
        return done / total if total else 1.0

    def share_of(self, span: Span) -> float:
        """The share of one segment, all its stages together."""
        weights = {step: weight for step, weight in self.weights.items() if step[0] == span}
        done = sum(self.shares.get(step, 0.0) * weight for step, weight in weights.items())
        return done / sum(weights.values()) if weights else 0.0

    def seconds_left(self, now: float) -> float | None:
        """Extrapolate as if the rest went as fast as what is done; None while that says little."""
        return seconds_left(now - self.started_at, self.share, self.given)

    def _with(self, step: Step, share: float) -> Shares:
        reached = max(share, self.shares.get(step, 0.0))
        return replace(self, shares={**self.shares, step: reached})


def words_of(event: PassFinished) -> str:
    """Such as "pass 3 of 8"."""
    unit = "step" if _is_of_surfaces(event) else "pass"
    return f"{unit} {event.number + 1} of {max(event.of, event.number + 1)}"


def _is_of_surfaces(event: PassFinished) -> bool:
    """Of surfaces the steps of time that are done are counted."""
    return event.result.steps == ("fit",)


def seconds_left(elapsed: float, share: float, given_share: float = 0.0) -> float | None:
    """Extrapolate as if the rest went as fast as what is done, a share without what was given; None
    while that says little.
    """
    done = share - given_share
    if done < KNOWN_SHARE or elapsed < KNOWN_SECONDS:
        return None
    return elapsed * (1.0 - share) / done
