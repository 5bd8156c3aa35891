"""All results that may be of use again: by their keys, so that undo finds the old ones."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal, TypeAlias

from keypose.tracker.session import Session
from keypose.tracker.session.settings import Quality
from keypose.tracker.space.result import SpaceResult
from keypose.tracker.storage.fingerprints import Span, segment_keys
from keypose.tracker.storage.stretches import SegmentRun, stretches
from keypose.tracker.tracking.result import SegmentResult

CARE = {"preview": 0, "full": 1}
"""Of two results with one key, the one found with more care stays."""

MOST_SEGMENTS = 400
MOST_STRETCHES = 50
MOST_FRAMES = 60_000
"""Kept at most, about 100 MB for a person's body; the oldest goes first."""

State: TypeAlias = Literal["good", "check", "lost", "outdated", "none"]


@dataclass(frozen=True, eq=False)
class Results:
    """Results by key, the oldest first: of segments as tracked, and of stretches in space.
    Immutable."""

    by_key: Mapping[str, SegmentResult] = field(default_factory=dict)
    in_space: Mapping[str, SpaceResult] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("by_key", "in_space"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    def __len__(self) -> int:
        return len(self.by_key)

    def with_result(self, segment_result: SegmentResult, keep: Collection[str] = ()) -> Results:
        """These and one more, unless a better one of its key is here; then these themselves.

        keep: keys that are never forgotten to make room, such as those of the present segments.
        """
        present = self.by_key.get(segment_result.key)
        if present is not None and not _supersedes(segment_result, present):
            return self
        others = {key: old for key, old in self.by_key.items() if key != segment_result.key}
        kept = _drop_oldest(
            {**others, segment_result.key: segment_result}, {*keep, segment_result.key}
        )
        return Results(kept, self.in_space)

    def beside(self, results: Results) -> Results:
        """These and those of another body."""
        by_key = {**results.by_key, **self.by_key}
        return Results(by_key, {**results.in_space, **self.in_space})

    def with_space(self, space_result: SpaceResult) -> Results:
        """These and a stretch's motion in space."""
        others = {key: old for key, old in self.in_space.items() if key != space_result.key}
        kept = list({**others, space_result.key: space_result}.items())[-MOST_STRETCHES:]
        return Results(self.by_key, dict(kept))

    def fitting(self, session: Session) -> dict[Span, SegmentResult]:
        """The results that are those of the session's present segments, finished or not; in space
        where that was solved for."""
        segment_results = self._as_tracked(session)
        for stretch in self._stretches(session):
            solved = self.in_space.get(stretch.key)
            if solved is not None:
                placed = (segment.in_space(solved.motion) for segment in stretch.segments)
                segment_results |= {segment.span: segment for segment in placed}
        return segment_results

    def unsolved(self, session: Session) -> list[SegmentRun]:
        """The stretches whose motion in space is not known yet."""
        return [run for run in self._stretches(session) if run.key not in self.in_space]

    def space(self, session: Session) -> list[SpaceResult]:
        """What is known of the session's motion in space."""
        return [
            self.in_space[run.key] for run in self._stretches(session) if run.key in self.in_space
        ]

    def _stretches(self, session: Session) -> list[SegmentRun]:
        """What there is to solve of the body that is posed, beside those that bonds join it to."""
        beside = {each: self._as_tracked(session.about(each)) for each in session.bonded}
        return stretches(session, self._as_tracked(session), beside)

    def _as_tracked(self, session: Session) -> dict[Span, SegmentResult]:
        keys = segment_keys(session)
        return {span: self.by_key[key] for span, key in keys.items() if key in self.by_key}

    def wanted(
        self, session: Session, quality: Quality | None = None
    ) -> list[tuple[int, int, str]]:
        """(first, last, key) of the segments without a whole result of at least this quality.

        quality: the session's own when left out.
        """
        least = CARE[quality or session.settings.quality]
        return [
            (*span, key)
            for span, key in segment_keys(session).items()
            if not self._holds(key, least)
        ]

    def states(self, session: Session) -> dict[Span, State]:
        """The state of every segment: its verdict, "outdated", or "none"."""
        keys = segment_keys(session)
        own = [each.span for each in self.by_key.values() if each.body in ("", session.subject.id)]
        return {span: self._state(span, key, own) for span, key in keys.items()}

    def _holds(self, key: str, least: int) -> bool:
        segment_result = self.by_key.get(key)
        if segment_result is None or not segment_result.finished or segment_result.missing:
            return False
        return CARE[segment_result.quality] >= least

    def _state(self, span: Span, key: str, tracked: Sequence[Span]) -> State:
        """tracked: what was tracked of the body, also what fits no more."""
        segment_result = self.by_key.get(key)
        if segment_result is not None and segment_result.kind is not None:
            return segment_result.kind
        first, last = span
        touched = any(start < last and end > first for start, end in tracked)
        return "outdated" if touched else "none"


def _supersedes(segment_result: SegmentResult, present: SegmentResult) -> bool:
    """Whether a result replaces another of the same key.

    A finished result is replaced only by a finished one that lacks no more of the work and has no
    lower quality.
    """
    mine, its = ((r.finished, -r.missing, CARE[r.quality]) for r in (segment_result, present))
    return mine >= its


def _drop_oldest(by_key: dict[str, SegmentResult], keep: set[str]) -> dict[str, SegmentResult]:
    """Without the oldest where there are too many."""
    frames = sum(len(result.trajectory) for result in by_key.values())
    for key, result in list(by_key.items()):
        if len(by_key) <= MOST_SEGMENTS and frames <= MOST_FRAMES:
            break
        if key not in keep:
            del by_key[key]
            frames -= len(result.trajectory)
    return by_key
