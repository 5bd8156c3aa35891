"""How far a job is, and how long it may still take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from keypose.app.jobs.messages import PassFinished, Report, SegmentFinished, Started
from keypose.tracker.session.settings import Quality
from keypose.tracker.storage.results import Span

COST = {"preview": 1.0, "full": 4.0}
"""Of one frame, by quality, relative to each other."""
KNOWN_SHARE, KNOWN_SECONDS = 0.1, 1.0
"""Before so much is done, and so long has passed, the time that is left is not known."""

Step = tuple[Span, Quality]


@dataclass(frozen=True)
class Progress:
    """Shares of a job's steps (a segment at one quality) that are done. Immutable.

    started_at, now: any clock in seconds, the same one throughout.
    given: the share of the whole job that was there when it began: a fit may go on.
    """

    started_at: float
    weights: Mapping[Step, float]
    shares: Mapping[Step, float] = field(default_factory=dict)
    given: float = 0.0

    @classmethod
    def of(cls, started: Started, now: float) -> Progress:
        """Nothing is done yet."""
        weights = {
            ((first, last), quality): (last - first) * COST[quality]
            for first, last, _ in started.wanted
            for quality in started.stages
        }
        return cls(now, weights)

    def after(self, report: Report) -> Progress:
        """Add what a report tells."""
        if isinstance(report, PassFinished):
            # a segment may take more passes than expected, and is not done before it is judged
            share = min((report.number + 1) / (report.of + 1), 0.95)
            step = (report.result.span, report.result.quality)
            after = self._with(step, share)
            if report.unit == "pass" or step in self.shares:
                return after
            return replace(after, given=after.given + after.share - self.share)
        if isinstance(report, SegmentFinished):
            return self._with((report.result.span, report.result.quality), 1.0)
        return self

    @property
    def share(self) -> float:
        """Return the share of the whole job, 0 to 1."""
        total = sum(self.weights.values())
        done = sum(share * self.weights.get(step, 0.0) for step, share in self.shares.items())
        return done / total if total else 1.0

    @property
    def percent(self) -> int:
        return int(100 * self.share)

    def percent_of(self, span: Span) -> int:
        """Return the share of one segment, all its stages together."""
        weights = {step: weight for step, weight in self.weights.items() if step[0] == span}
        done = sum(self.shares.get(step, 0.0) * weight for step, weight in weights.items())
        return int(100 * done / sum(weights.values())) if weights else 0

    def seconds_left(self, now: float) -> float | None:
        """Extrapolate as if the rest went as fast as what is done; None while that says little."""
        return seconds_left(now - self.started_at, self.share, self.given)

    def _with(self, step: Step, share: float) -> Progress:
        reached = max(share, self.shares.get(step, 0.0))
        return replace(self, shares={**self.shares, step: reached})


def seconds_left(elapsed: float, share: float, given: float = 0.0) -> float | None:
    """Extrapolate as if the rest went as fast as what is done, a share without what was given; None
    while that says little.
    """
    done = share - given
    if done < KNOWN_SHARE or elapsed < KNOWN_SECONDS:
        return None
    return elapsed * (1.0 - share) / done
