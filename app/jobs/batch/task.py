"""What a worker is asked for and what it answers: small, plain, fit for any line."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, TypeAlias

from keypose.app.orders.motion import AS_TRACKED, MotionOrder
from keypose.app.orders.tracking import AS_SET, TrackOrder
from keypose.tracker.session.settings import Quality

State: TypeAlias = Literal["tracked", "kept", "failed", "open", "interrupted"]
"""kept: nothing was missing.  open: another Keypose has it, so it was left alone."""


@dataclass(frozen=True)
class Export:
    """Files of the motion to write: `<folder>/<prefix><name>` in each format."""

    formats: tuple[str, ...]
    folder: Path
    prefix: str = ""
    order: MotionOrder = AS_TRACKED


@dataclass(frozen=True)
class Task:
    """Track one session.

    order: how.  missing_only: leave the segments alone that have
    a result which fits.  threads: segments side by side.
    """

    session: Path
    order: TrackOrder = AS_SET
    missing_only: bool = False
    export: Export | None = None
    threads: int = 1


@dataclass(frozen=True)
class SegmentSummary:
    """One segment as it stands on disk after the work; `fresh` when it was tracked now."""

    first: int
    last: int
    verdict: str
    words: str
    quality: Quality
    fresh: bool


@dataclass(frozen=True)
class Summary:
    """What became of one session. words: a sentence where something is worth one."""

    session: str
    state: State
    words: str = ""
    seconds: float = 0.0
    tracks: str | None = None
    segments: tuple[SegmentSummary, ...] = ()
    exported: tuple[str, ...] = ()

    @property
    def is_done(self) -> bool:
        """Return whether nothing of it is left to do."""
        return self.state in ("tracked", "kept")

    def count(self, verdict: str) -> int:
        return sum(segment.verdict == verdict for segment in self.segments)

    def after(self, seconds: float) -> Summary:
        return replace(self, seconds=round(seconds, 2))


@dataclass(frozen=True)
class Step:
    """How far a session is; the segment that has just been finished, if one has."""

    percent: int
    segment: dict[str, Any] | None = None
