"""What a worker is asked for and what it answers: small, plain, fit for any line."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, TypeAlias

from keypose.app.orders.film import FilmToDraft
from keypose.app.orders.motion import AS_TRACKED, MotionOrder
from keypose.app.orders.tracking import AS_SET, TrackOrder
from keypose.tracker.session.settings import Quality

State: TypeAlias = Literal["tracked", "kept", "failed", "open", "interrupted"]
"""kept: nothing was missing.  open: another Keypose has it, so it was left alone."""
Stage: TypeAlias = Literal["person", "draft", "camera", "films", "track", "stand", "export"]
"""What is done of one session, one after the other."""


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
    a result which fits.  threads: segments side by side.  film: what the session is made of first,
    unless it is there.  anew: whether it is made anew where it is there.  stand: whether the motion
    of a film that was drafted is stood on the floor afterwards.
    """

    session: Path
    order: TrackOrder = AS_SET
    missing_only: bool = False
    export: Export | None = None
    threads: int = 1
    film: FilmToDraft | None = None
    anew: bool = False
    stand: bool = False


@dataclass(frozen=True)
class SegmentSummary:
    """One segment as it stands on disk after the work; `fresh` when it was tracked now.

    body: the id of the body, where the session has several.
    """

    first: int
    last: int
    verdict: str
    words: str
    quality: Quality
    fresh: bool
    body: str | None = None


@dataclass(frozen=True)
class PlaceToReview:
    """A place of the motion to look at, in words.

    body: the id of the body, where the session has several.
    """

    frame: int
    part: str
    size: str
    reason: str
    body: str | None = None


@dataclass(frozen=True)
class Summary:
    """What became of one session. words: a sentence where something is worth one.

    segments: of all bodies.  notes: what was decided without a person, a sentence each.
    places: to review, of all bodies, the worst first.
    person: the picture of the person that was found, a file beside the session.
    """

    session: str
    state: State
    words: str = ""
    seconds: float = 0.0
    tracks: str | None = None
    segments: tuple[SegmentSummary, ...] = ()
    exported: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    places: tuple[PlaceToReview, ...] = ()
    person: str | None = None

    @property
    def is_done(self) -> bool:
        """Whether nothing of it is left to do."""
        return self.state in ("tracked", "kept")

    def count(self, verdict: str) -> int:
        return sum(segment.verdict == verdict for segment in self.segments)

    def after(self, seconds: float) -> Summary:
        return replace(self, seconds=round(seconds, 2))


@dataclass(frozen=True)
class Step:
    """How far a stage of a session is; the segment that has just been finished, if one has."""

    percent: int
    segment: dict[str, Any] | None = None
    stage: Stage = "track"
