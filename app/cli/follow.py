"""Following a track run: its progress, and what is left of it when interrupted."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from keypose.app.cli.json_output import print_json, verdict_fields
from keypose.app.cli.long_work import set_when_interrupted
from keypose.app.jobs.job import Finished
from keypose.app.jobs.progress import Wanted
from keypose.app.jobs.rerun import rerun
from keypose.app.jobs.track import Found, found_in
from keypose.tracker.errors import KeyposeError
from keypose.tracker.session import Session
from keypose.tracker.storage.results import Span
from keypose.tracker.tracking.pool import PassFinished, SegmentFinished
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video import Video

Send: TypeAlias = Callable[[Found], None]
Places: TypeAlias = Mapping[Span, int]
"""Of every segment to track, its number among them."""


@dataclass(frozen=True, eq=False)
class Run:
    """The finished segments; `interrupted` when the person stopped before all were, and `error`
    what else ended the run early."""

    found: tuple[SegmentResult, ...]
    interrupted: bool = False
    error: KeyposeError | None = None


def follow(
    session: Session,
    session_path: Path,
    video: Video,
    wanted: Sequence[Wanted],
    workers: int,
    as_json: bool,
) -> Run:
    """Track segments and report the progress: JSON lines, a bar at a terminal, or a line per
    segment.

    However the run ends, the segments finished by then are in it. The first Ctrl+C or SIGTERM
    lets the tracker come to rest and say all it has finished; a second one breaks off even that.
    """
    stop = threading.Event()
    finished: dict[Span, SegmentResult] = {}
    cancelled = False
    with set_when_interrupted(stop), _reporter(wanted, as_json) as send:
        try:
            for report in rerun(session, session_path, video, wanted, workers=workers, stop=stop):
                event = found_in(report)
                if isinstance(report, Finished):
                    cancelled = report.cancelled
                if isinstance(event, SegmentFinished):
                    finished[event.result.span] = event.result
                if event is not None:
                    _send_or_stop(send, event, stop)
        except KeyboardInterrupt:
            return Run(_in_order(finished), interrupted=True)
        except KeyposeError as error:
            return Run(_in_order(finished), error=error)
    return Run(_in_order(finished), interrupted=cancelled)


def _send_or_stop(send: Send, report: Found, stop: threading.Event) -> None:
    try:
        send(report)
    except OSError:  # nobody listens any more
        stop.set()


def _in_order(finished: Mapping[Span, SegmentResult]) -> tuple[SegmentResult, ...]:
    return tuple(finished[span] for span in sorted(finished))


@contextmanager
def _reporter(wanted: Sequence[Wanted], as_json: bool) -> Iterator[Send]:
    places = {(first, last): index for index, (first, last, _) in enumerate(wanted)}
    if as_json:
        yield _JsonReporter(places).send
    elif sys.stderr.isatty():
        with _bar(places) as send:
            yield send
    else:
        yield lambda report: _line(report, places)


def _line(report: Found, places: Places) -> None:
    """One quiet line for each finished segment, for logs."""
    if isinstance(report, SegmentFinished):
        track = report.result
        print(
            f"segment {places[track.span] + 1} of {len(places)}, frames "
            f"{track.first}–{track.last}: {track.kind}",
            file=sys.stderr,
            flush=True,
        )


@contextmanager
def _bar(places: Places) -> Iterator[Send]:
    """A bar that counts frames: a segment's share of passes done is that share of its frames."""
    from tqdm import tqdm

    total = sum(last - first for first, last in places)
    done: dict[Span, float] = {}
    with tqdm(total=total, unit="frame", file=sys.stderr, dynamic_ncols=True) as bar:

        def send(report: Found) -> None:
            if isinstance(report, PassFinished):
                share = min((report.number + 1) / max(report.of, 1), 1.0)  # numbers start at 0
                done[report.result.span] = (report.result.last - report.result.first) * share
            elif not report.result.missing:
                done[report.result.span] = report.result.last - report.result.first
            bar.n = min(round(sum(done.values())), total)
            bar.refresh()

        yield send


class _JsonReporter:
    """Reports without their arrays, a line each; a segment's first is preceded by its beginning."""

    def __init__(self, places: Places) -> None:
        self._places = places
        self._begun: set[Span] = set()

    def send(self, report: Found) -> None:
        if isinstance(report, PassFinished):
            self._begin(report.result.span)
            print_json(self._passed(report))
        else:
            self._begin(report.result.span)
            print_json(self._finished(report.result))

    def _begin(self, span: Span) -> None:
        if span not in self._begun:
            self._begun.add(span)
            first, last = span
            event = {**self._head("segment_started", span), "of": len(self._places)}
            print_json({**event, "first_frame": first, "last_frame": last})

    def _passed(self, report: PassFinished) -> dict[str, Any]:
        return {
            **self._head("pass_finished", report.result.span),
            "pass": report.number,
            "of": report.of,
            "score": report.result.scores[-1],
        }

    def _finished(self, track: SegmentResult) -> dict[str, Any]:
        return {
            **self._head("segment_finished", track.span),
            "of": len(self._places),
            **verdict_fields(track.verdict),
            "notes": list(track.notes),
            "missing": track.missing,
            "best_pass": track.best_pass,
            "closing_error": track.closing_error,
        }

    def _head(self, event: str, span: Span) -> dict[str, Any]:
        return {"event": event, "segment": self._places[span]}
