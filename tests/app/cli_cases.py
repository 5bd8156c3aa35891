"""A tracker that needs no pixels, and what every refusal of the command line has in common."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from threading import Event
from typing import Any

import pytest

from keypose.app.cli.main import main
from keypose.app.document.folder_lock import NAME
from keypose.app.jobs.job import Finished, Progress
from keypose.app.jobs.progress import Wanted
from keypose.app.jobs.track import Tracked
from keypose.tracker.body.trajectory import Pass
from keypose.tracker.session import Session
from keypose.tracker.tracking.pool import PassFinished
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video import Video
from tests.app.jobs.job_cases import segment_done
from tests.tracker import session_cases as cases

Fake = Callable[..., Iterator[Any]]


def tracker(
    kinds: tuple[cases.Kind, ...] = ("good", "good"),
    stop_after: int | None = None,
    stops: int = 1,
    error: Exception | None = None,
    number: signal.Signals = signal.SIGINT,
) -> Fake:
    """A tracker that finds a bent interpolation.

    After `stop_after` segments it meets the error or, when there is none, a signal that many times.
    """

    def rerun(
        session: Session,
        session_path: Path,
        video: Video,
        wanted: Sequence[Wanted],
        *,
        workers: int,
        stop: Event,
    ) -> Iterator[Any]:
        assert video.info.frame_count == session.view.video.frame_count
        quality = session.settings.quality
        for i, (kind, (first, last, key)) in enumerate(zip(kinds, wanted, strict=True)):
            if i == stop_after and error is not None:
                raise error
            if i == stop_after:
                for _ in range(stops):
                    signal.raise_signal(number)
                assert stop.is_set()
                break
            found = replace(cases.segment(first, last, kind), key=key, quality=quality)
            step = Pass("pass", found.trajectory, 3.5)
            on_the_way = PassFinished(i, 1, 2, SegmentResult.on_the_way(step, key, quality))
            yield Progress(1, 0.5, partial=Tracked(on_the_way, 0.5))
            yield segment_done(1, found)
        yield Finished(1, cancelled=stop.is_set())

    return rerun


def everything_in(folder: Path) -> dict[str, bytes]:
    """Of every file its bytes; the lock's file counts for nothing, and stays wherever it was."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.name != NAME
    }


def refused(capsys: pytest.CaptureFixture[str], folder: Path, arguments: list[str | Path]) -> str:
    """The sentence with which a command refuses; nothing is written, nothing else is said."""
    before = everything_in(folder)
    try:
        code: object = main([str(a) for a in arguments])
    except SystemExit as stop:
        code = stop.code
    assert code == 2
    assert everything_in(folder) == before
    out, sentence = capsys.readouterr()
    assert out == ""
    assert sentence.count("\n") == 1
    assert sentence.endswith(".\n")
    assert "Traceback" not in sentence
    return sentence
