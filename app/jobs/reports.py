"""What is told about tracking, and what is asked of it: all that passes between the processes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from app.results import SegmentTrack, Span
from tracker.settings import Quality
from tracker.trajectory import Trajectory

Wanted: TypeAlias = tuple[int, int, str]
"""First frame, last frame and key of a segment to track."""


@dataclass(frozen=True)
class Order:
    """Track these segments, all at the first quality, then all at the next.

    session: JSON of a session that holds at least their keyframes.
    folder: of the session's file, where its imported motion lies.
    """

    job: int
    session: bytes
    video_path: str
    wanted: tuple[Wanted, ...]
    stages: tuple[Quality, ...]
    folder: str = ""


@dataclass(frozen=True)
class Cancel:
    """Leave a job within one pass."""

    job: int


@dataclass(frozen=True)
class Hold:
    """Stand back while a hand drags (`on`), or go on: each pass waits, though not for long."""

    on: bool


@dataclass(frozen=True)
class Warming:
    """The worker is getting ready; the job, if there is one, waits for it."""

    words: str
    job: int | None = None


@dataclass(frozen=True)
class Ready:
    """The worker can track."""

    job: int | None = None


@dataclass(frozen=True)
class Started:
    """Work on a job has begun. stages: those that there will be."""

    job: int
    wanted: tuple[Wanted, ...]
    stages: tuple[Quality, ...]


@dataclass(frozen=True, eq=False)
class PassFinished:
    """One more trajectory of a segment, the `number`th (from 0) of about `of`. Not of previews."""

    job: int
    first: int
    last: int
    key: str
    quality: Quality
    number: int
    of: int
    score: float
    trajectory: Trajectory

    @property
    def span(self) -> Span:
        return self.first, self.last

    @property
    def track(self) -> SegmentTrack:
        """The trajectory as a result that is not finished."""
        words = f"Pass {self.number + 1} of {max(self.of, self.number + 1)}"
        return SegmentTrack.on_the_way(self.key, self.quality, self.trajectory, self.score, words)


@dataclass(frozen=True, eq=False)
class SegmentFinished:
    """A segment is done at one quality; also told of a job that has been cancelled since."""

    job: int
    track: SegmentTrack


@dataclass(frozen=True)
class JobFinished:
    """Nothing more will come of a job: all is done, or it was cancelled or replaced by a newer."""

    job: int
    cancelled: bool


@dataclass(frozen=True)
class JobFailed:
    """A job ended by something a person should know: one sentence. What was finished is told
    before and stays good."""

    job: int
    words: str


Report: TypeAlias = (
    Warming | Ready | Started | PassFinished | SegmentFinished | JobFinished | JobFailed
)
