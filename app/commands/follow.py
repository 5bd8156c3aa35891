"""Following a track run: what it tells on the way, and what is left of it after Ctrl+C."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from app.commands.json_output import print_json
from tracker.errors import KeyposeError
from tracker.session.tracking import track_session
from tracker.track import (
    PassFinished,
    Progress,
    SegmentFinished,
    SegmentResult,
    SegmentStarted,
    TrackFinished,
    TrackResult,
)

if TYPE_CHECKING:
    from tracker.session import Session
    from tracker.video import Video

Report: TypeAlias = Callable[[Progress], None]


@dataclass(frozen=True, eq=False)
class Run:
    """The finished segments; `interrupted` when the person stopped before all were, and `error`
    what else ended the run early."""

    result: TrackResult
    interrupted: bool = False
    error: KeyposeError | None = None


def follow(session: Session, video: Video, workers: int, as_json: bool) -> Run:
    """Track, and tell on the way: JSON lines, a bar at a terminal, or a line per segment.

    However the run ends, the segments finished by then are in it. The first Ctrl+C lets the
    tracker come to rest and say all it has finished; a second one breaks off even that.
    """
    stop = threading.Event()
    events = track_session(session, video, workers=workers, cancelled=stop.is_set)
    finished: dict[int, SegmentResult] = {}
    with _set_by_ctrl_c(stop), _reporter(session, as_json) as report:
        try:
            for event in events:
                if isinstance(event, TrackFinished):
                    return Run(event.result, interrupted=event.cancelled)
                if isinstance(event, SegmentFinished):
                    finished[event.index] = event.result
                _tell(report, event, stop)
        except KeyboardInterrupt:
            return Run(_result(session, finished), interrupted=True)
        except KeyposeError as error:
            return Run(_result(session, finished), error=error)
    raise AssertionError("a run ends with TrackFinished")


def _tell(report: Report, event: Progress, stop: threading.Event) -> None:
    try:
        report(event)
    except OSError:  # nobody listens any more
        stop.set()


def _result(session: Session, finished: dict[int, SegmentResult]) -> TrackResult:
    """What a run that broke off has found."""
    from tracker.skeleton import Skeleton

    segments = tuple(finished[index] for index in sorted(finished))
    return TrackResult(Skeleton.of(session.body), session.settings, segments)


@contextmanager
def _set_by_ctrl_c(stop: threading.Event) -> Iterator[None]:
    """Within, the first Ctrl+C sets the event and the next one raises KeyboardInterrupt."""
    before = signal.getsignal(signal.SIGINT)
    on_main = threading.current_thread() is threading.main_thread()
    if before in (signal.SIG_IGN, None) or not on_main:  # whoever ignores Ctrl+C goes on doing so
        yield
        return

    def handle(*_: object) -> None:
        if stop.is_set():
            raise KeyboardInterrupt
        stop.set()

    signal.signal(signal.SIGINT, handle)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _reporter(session: Session, as_json: bool) -> Iterator[Report]:
    if as_json:
        yield lambda event: print_json(_as_json(event))
    elif sys.stderr.isatty():
        with _bar(session) as report:
            yield report
    else:
        yield _line


def _line(event: Progress) -> None:
    """One quiet line for each finished segment, for logs."""
    if isinstance(event, SegmentFinished):
        frames = event.result.trajectory
        print(
            f"segment {event.index + 1} of {event.count}, frames "
            f"{frames.first_frame}–{frames.last_frame}: {event.result.verdict.kind}",
            file=sys.stderr,
            flush=True,
        )


@contextmanager
def _bar(session: Session) -> Iterator[Report]:
    """A bar that counts frames: a segment's share of passes done is that share of its frames."""
    from tqdm import tqdm

    total = session.keyframes[-1].frame - session.keyframes[0].frame
    done: dict[int, float] = {}
    with tqdm(total=total, unit="frame", file=sys.stderr, dynamic_ncols=True) as bar:

        def report(event: Progress) -> None:
            if isinstance(event, PassFinished):
                share = min((event.number + 1) / max(event.of, 1), 1.0)  # numbers start at 0
                done[event.index] = (len(event.trajectory) - 1) * share
            elif isinstance(event, SegmentFinished):
                done[event.index] = len(event.result.trajectory) - 1
            bar.n = min(round(sum(done.values())), total)
            bar.refresh()

        yield report


def _as_json(event: Progress) -> dict[str, Any]:
    """The event without its arrays."""
    if isinstance(event, SegmentStarted):
        return {
            "event": "segment_started",
            "segment": event.index,
            "of": event.count,
            "first_frame": event.first_frame,
            "last_frame": event.last_frame,
        }
    if isinstance(event, PassFinished):
        return {
            "event": "pass_finished",
            "segment": event.index,
            "pass": event.number,
            "of": event.of,
            "score": event.score,
        }
    assert isinstance(event, SegmentFinished)
    result = event.result
    return {
        "event": "segment_finished",
        "segment": event.index,
        "of": event.count,
        "verdict": result.verdict.kind,
        "words": result.verdict.words,
        "frames": result.verdict.frames,
        "best_pass": result.best_pass,
        "closing_error": result.closing_error,
    }
