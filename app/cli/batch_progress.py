"""The progress of a batch as JSON lines, bars or plain lines, and a table at the end."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

from keypose.app.cli.json_output import json_value, print_json
from keypose.app.jobs.batch.report import Entry
from keypose.app.jobs.batch.scheduler import TaskEvent, TaskFinished, TaskStarted
from keypose.app.jobs.batch.task import Stage, Step, Summary

WIDEST_NAME = 48
QUARTER = 25
"""Letters of a name, and percent from one word on a session to the next."""
WORDS = {
    "tracked": "tracked",
    "kept": "up to date",
    "failed": "failed",
    "open": "open elsewhere",
    "interrupted": "interrupted",
}
"""The label of every outcome."""

STAGES: Mapping[Stage, str] = {
    "person": "looking for the person",
    "draft": "drafting",
    "camera": "finding the camera's motion",
    "films": "laying the other film beside it",
    "track": "tracking",
    "stand": "standing on the floor",
    "export": "exporting",
}
MOST_PLACES = 5
"""Places to review that are listed of one session; the report has all."""


class BatchReporter(Protocol):
    """`start` before the first session, `event` for whatever happens, `finish` at the end."""

    def start(self, continued: int) -> None: ...

    def event(self, event: TaskEvent) -> None: ...

    def finish(
        self, entries: Sequence[Entry], report: Path | None, seconds: float, *, interrupted: bool
    ) -> None: ...


@contextmanager
def batch_reporter(
    names: Sequence[str], paths: Sequence[str], as_json: bool
) -> Iterator[BatchReporter]:
    """The reporter that is wanted; names for people and paths for programs, by session."""
    if as_json:
        yield _JsonReporter(paths)
    elif sys.stderr.isatty():
        bars = _BarReporter(names)
        try:
            yield bars
        finally:
            bars.close()
    else:
        yield _LineReporter(names)


class _JsonReporter:
    def __init__(self, paths: Sequence[str]) -> None:
        self._paths = paths

    def start(self, continued: int) -> None:
        print_json({"event": "batch_started", "sessions": self._paths, "done_before": continued})

    def event(self, event: TaskEvent) -> None:
        session = {"session": self._paths[event.number]}
        if isinstance(event, TaskStarted):
            print_json({"event": "session_started", **session, "again": event.again})
        elif isinstance(event, TaskFinished):
            print_json({"event": "session_finished", **json_value(event.summary)})
        else:
            segment = event.step.segment
            kind = "progress" if segment is None else "segment_finished"
            more = {} if segment is None else segment
            step = {"stage": event.step.stage, "percent": event.step.percent}
            print_json({"event": kind, **session, **step, **more})

    def finish(
        self, entries: Sequence[Entry], report: Path | None, seconds: float, *, interrupted: bool
    ) -> None:
        summaries = [entry.summary for entry in entries]
        print_json(
            {
                "event": "finished",
                "interrupted": interrupted,
                "sessions": summaries,
                "of": len(self._paths),
                "not_done": [s.session for s in summaries if not s.is_done],
                "lost": [s.session for s in summaries if s.count("lost")],
                "report": None if report is None else str(report),
                "seconds": round(seconds, 2),
            }
        )


class _TextReporter:
    def __init__(self, names: Sequence[str]) -> None:
        self._names = names

    def start(self, continued: int) -> None:
        if continued:
            of = len(self._names)
            print(
                f"Continuing the interrupted batch: {continued} of {of} are done.",
                file=sys.stderr,
            )

    def finish(
        self, entries: Sequence[Entry], report: Path | None, seconds: float, *, interrupted: bool
    ) -> None:
        for line in _table(entries):
            print(line)
        for entry in entries:
            for line in _found(entry):
                print(line)
        done = sum(entry.summary.is_done for entry in entries)
        print(f"{done} of {len(self._names)} sessions done in {seconds:.1f} s.")
        if report is not None:
            print(f"Written: {report}")
        if interrupted:
            print("Interrupted: run the same command to continue.", file=sys.stderr)


class _LineReporter(_TextReporter):
    """A line when a session begins, at every quarter of each stage, and when it ends, for logs."""

    def __init__(self, names: Sequence[str]) -> None:
        super().__init__(names)
        self._reached: dict[int, tuple[Stage | None, int]] = {}
        self._ended = 0

    def event(self, event: TaskEvent) -> None:
        name, number = self._names[event.number], event.number
        if isinstance(event, TaskStarted):
            self._reached[number] = (None, 0)
            self._print(f"{name}: begun{' again, its worker was gone' if event.again else ''}")
        elif isinstance(event, TaskFinished):
            self._ended += 1
            self._print(f"{name}: {_outcome(event.summary)} ({self._ended} of {len(self._names)})")
        else:
            self._step(number, event.step)

    def _step(self, number: int, step: Step) -> None:
        stage, quarter = self._reached[number]
        reached = step.stage, step.percent // QUARTER
        if reached[0] == stage and (reached[1] == quarter or step.percent == 100):
            return
        self._reached[number] = reached
        percent = f", {step.percent} %" if step.percent else ""
        self._print(f"{self._names[number]}: {STAGES[step.stage]}{percent}")

    def _print(self, words: str) -> None:
        print(words, file=sys.stderr, flush=True)


class _BarReporter(_TextReporter):
    """A bar for the whole, and below it one for each session at work."""

    def __init__(self, names: Sequence[str]) -> None:
        from tqdm import tqdm

        super().__init__(names)
        self._tqdm = tqdm
        self._whole: Any = None
        self._bars: dict[int, Any] = {}

    def start(self, continued: int) -> None:
        super().start(continued)
        self._whole = self._tqdm(
            total=len(self._names), unit="session", file=sys.stderr, dynamic_ncols=True
        )

    def event(self, event: TaskEvent) -> None:
        number = event.number
        if isinstance(event, TaskStarted):
            self._bars[number] = self._tqdm(
                total=100,
                desc=_short(self._names[number]),
                bar_format="{desc}: {percentage:3.0f} % {bar}",
                file=sys.stderr,
                dynamic_ncols=True,
                leave=False,
            )
        elif isinstance(event, TaskFinished):
            self._bars.pop(number).close()
            words = f"{self._names[number]}: {_outcome(event.summary)}"
            self._tqdm.write(words, file=sys.stderr)
            self._whole.update(1)
        else:
            bar, step = self._bars[number], event.step
            bar.set_description(
                f"{_short(self._names[number])}, {STAGES[step.stage]}", refresh=False
            )
            bar.n = step.percent
            bar.refresh()

    def close(self) -> None:
        for bar in (*self._bars.values(), self._whole):
            if bar is not None:
                bar.close()


def _outcome(summary: Summary) -> str:
    """ "tracked, 3 good, 1 check", or why not."""
    kinds = [f"{n} {kind}" for kind in ("good", "check", "lost") if (n := summary.count(kind))]
    words = ", ".join([WORDS[summary.state], *kinds])
    return f"{words}. {summary.words}" if summary.words else words


def _table(entries: Sequence[Entry]) -> Iterator[str]:
    """The outcome in columns."""
    if not entries:
        return
    width = max(len("session"), *(len(_short(entry.name)) for entry in entries))
    outcomes = max(len("outcome"), *(len(WORDS[entry.summary.state]) for entry in entries))
    figures = ("good", "check", "lost")
    head = "".join(f"{word:>7}" for word in (*figures, "s"))
    yield f"{'session':<{width}}  {'outcome':<{outcomes}}{head}"
    for entry in entries:
        summary = entry.summary
        cells = "".join(f"{summary.count(kind):>7}" for kind in figures)
        line = f"{_short(entry.name):<{width}}  {WORDS[summary.state]:<{outcomes}}{cells}"
        yield f"{line}{summary.seconds:>7.1f}  {summary.words}".rstrip()


def _found(entry: Entry) -> Iterator[str]:
    """What was decided of a film that nobody looked at, and where to look first."""
    summary = entry.summary
    if not summary.notes:
        return
    yield ""
    yield f"{_short(entry.name)}:"
    for words in summary.notes:
        yield f"  {words}"
    if summary.places:
        yield "  Look here first:"
    for place in summary.places[:MOST_PLACES]:
        of_body = "" if place.body is None else f" of {place.body}"
        yield f"    frame {place.frame}{of_body}: {place.part}, {place.size}, {place.reason}"
    if len(summary.places) > MOST_PLACES:
        yield f"    and {len(summary.places) - MOST_PLACES} more: keypose review {summary.session}"


def _short(name: str) -> str:
    """The end of a long name says more than its beginning."""
    shown = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in name)
    return shown if len(shown) <= WIDEST_NAME else f"…{shown[1 - WIDEST_NAME :]}"
