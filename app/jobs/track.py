"""Track segments, all at the first quality, then all at the next."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Self, TypeAlias

from keypose.app.jobs.job import Context, Job, Progress, Report
from keypose.app.jobs.progress import Shares, Wanted, words_of
from keypose.app.state.job_state import JobState
from keypose.app.words.jobs import Ending, bodies_words, closing_words, spans_text
from keypose.tracker.errors import SessionError
from keypose.tracker.session import Session
from keypose.tracker.session.settings import Quality, TrackSettings
from keypose.tracker.session.verdict import worst_of
from keypose.tracker.tracking.pool import (
    Cancelled,
    PassFinished,
    SegmentEvent,
    SegmentFailed,
    SegmentFinished,
    Task,
    run_tasks,
)

if TYPE_CHECKING:
    from keypose.tracker.storage.results import Results, Span
    from keypose.tracker.tracking.result import SegmentResult

Found: TypeAlias = PassFinished | SegmentFinished


@dataclass(frozen=True, eq=False)
class Tracked:
    """What there is of a segment by now: a trajectory on the way, or all of it, also of a job that
    has been cancelled since. share: of its work, all stages together."""

    found: Found
    share: float


def found_in(report: Report) -> Found | None:
    """What a report of tracking tells of a segment."""
    if isinstance(report, Progress) and isinstance(report.partial, Tracked):
        return report.partial.found
    return None


@dataclass(frozen=True)
class Track(Job):
    """session: JSON of a session that holds at least the keyframes of these segments.

    folder: of the session's file, where its imported motion lies.
    verbs: what is done, and has been: "Tracking", "Tracked".
    name: of the body, where there are several.
    body: the id of the body whose segments these are.
    """

    session: bytes
    video_path: str
    wanted: tuple[Wanted, ...]
    stages: tuple[Quality, ...]
    folder: str = ""
    verbs: tuple[str, str] = ("Tracking", "Tracked")
    name: str = ""
    body: str = ""

    kind = "track"
    fault = "Tracking failed with an internal error ({}). Finished work is kept; try again."
    died = "Tracking stopped unexpectedly; what was finished is kept, track again."

    @classmethod
    def of(
        cls,
        session: Session,
        video_path: Path,
        wanted: Sequence[Wanted],
        stages: Sequence[Quality] = ("full",),
        folder: Path | None = None,
        name: str = "",
    ) -> Self:
        """The published method knows no qualities: once is enough."""
        words, paper = session.evidence.words, session.settings.method == "paper"
        return cls(
            _only_needed(session, wanted).model_dump_json().encode(),
            str(video_path),
            tuple(wanted),
            tuple(stages)[-1:] if paper else tuple(stages),
            "" if folder is None else str(folder),
            (words.doing.capitalize(), words.done.capitalize()),
            name,
            session.subject.id,
        )

    @property
    def spans(self) -> list[Span]:
        return [(first, last) for first, last, _ in self.wanted]

    @property
    def keys(self) -> set[str]:
        return {key for *_, key in self.wanted}

    @property
    def failed(self) -> str:
        return f"{self.verbs[0]} failed"

    @property
    def title(self) -> str:
        return self._titled(self.verbs[0])

    def _titled(self, verb: str) -> str:
        return f"{verb} {spans_text(self.spans)}{f' of {self.name}' if self.name else ''}"

    def run(self, context: Context) -> None:
        """The first error is raised last: it does not stop the other segments."""
        session = Session.model_validate_json(self.session)
        reporter = TrackReporter(context, Shares.of(self.wanted, self.stages, time.monotonic()))
        context.report(0.0)
        tasks = [
            Task(index, (first, last), _settings(session.settings, stage), key)
            for stage in self.stages
            for index, (first, last, key) in enumerate(self.wanted)
        ]
        if not tasks:
            return
        tracker = context.cache.tracker(session, self.video_path, Path(self.folder))
        complete = run_tasks(tracker, tasks, context.threads, reporter.report, context.cancelled)
        if reporter.error is not None:
            raise reporter.error
        if not complete:
            raise Cancelled

    def closing(self, cancelled: bool, results: Results, before: Sequence[Track] = ()) -> JobState:
        """What is shown at its end: what there is of the segments that were to be tracked. before:
        what was tracked of other bodies since somebody asked for all of them."""
        state: Ending = "cancelled" if cancelled else "done"
        results_of_body = {order.name: order.results_in(results) for order in (*before, self)}
        segment_results = [result for own in results_of_body.values() for result in own]
        worst = worst_of(track.kind for track in segment_results if track is not None)
        if before and not cancelled:
            title = self.verbs[1]
            words = bodies_words(results_of_body)
        else:
            title = "Cancelled" if cancelled else self._titled(self.verbs[1])
            words = closing_words(state, segment_results)
        return JobState(state, title, words, 100, worst=worst)

    def results_in(self, results: Results) -> list[SegmentResult | None]:
        """What there is of its segments by now."""
        return [results.by_key.get(key) for *_, key in self.wanted]


class TrackReporter:
    """Reports segments from the threads that work on them."""

    def __init__(self, context: Context, shares: Shares) -> None:
        self._context, self._shares = context, shares
        self._lock = Lock()
        self.error: Exception | None = None
        """The first that was met, as it was raised; SessionError where memory ran out."""

    def report(self, event: SegmentEvent) -> None:
        match event:
            case SegmentFailed():
                self.error = self.error or _as_session_error(event)
            case SegmentFinished():
                self._send(event)
            case PassFinished() if event.result.quality != "preview":
                # of a preview the next pass would be there before this one is drawn
                self._context.hold()
                self._send(event, words_of(event))

    def _send(self, event: Found, words: str = "") -> None:
        with self._lock:
            shares = self._shares = self._shares.after(event)
            left = shares.seconds_left(time.monotonic())
            step = Tracked(event, shares.share_of(event.result.span))
            self._context.report(shares.share, words, step, left)


def _settings(settings: TrackSettings, stage: Quality) -> TrackSettings:
    """The session's settings at one quality; a preview keeps to its own number of passes."""
    passes = None if stage == "preview" and settings.method == "keypose" else settings.passes
    return settings.model_copy(update={"quality": stage, "passes": passes})


def _as_session_error(failed: SegmentFailed) -> Exception:
    first, last = failed.span
    words = (
        f"There is not enough memory to track {first}–{last}: set a keyframe between, "
        "or close other programs."
    )
    return SessionError(words) if isinstance(failed.error, MemoryError) else failed.error


def _only_needed(session: Session, wanted: Sequence[Wanted]) -> Session:
    """The session without what these segments do not need: it is read anew for every job."""
    frames = {frame for first, last, _ in wanted for frame in (first, last)}
    if session.model_keyframe is not None:  # its surface moves with the body, everywhere
        frames.add(session.model_keyframe.frame)
    keyframes = tuple(k for k in session.subject.keyframes if k.frame in frames)
    return session.changed({"keyframes": keyframes, "drafts": (), "results": None})
