"""A tracker that needs no pixels, and what every refusal of the command line has in common."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from app.cli import main
from tests.tracker import session_cases as cases
from tracker.session import Session
from tracker.track import (
    PassFinished,
    SegmentFinished,
    SegmentStarted,
    TrackFinished,
    TrackResult,
    never,
)
from tracker.video import Video

Fake = Callable[..., Iterator[Any]]


def tracker(
    kinds: tuple[cases.Kind, ...] = ("good", "good"),
    stop_after: int | None = None,
    stops: int = 1,
    error: Exception | None = None,
) -> Fake:
    """A tracker that finds a bent interpolation.

    After `stop_after` segments it meets the error or, when there is none, Ctrl+C that many times.
    """

    def track(
        session: Session,
        video: Video,
        *,
        workers: int = 1,
        cancelled: Callable[[], bool] = never,
    ) -> Iterator[Any]:
        assert video.info.frame_count == session.video.frame_count
        found = []
        for i, (kind, first) in enumerate(zip(kinds, (0, 4), strict=True)):
            if i == stop_after and error is not None:
                raise error
            if i == stop_after:
                for _ in range(stops):
                    signal.raise_signal(signal.SIGINT)
                assert cancelled()
                break
            segment = cases.segment(first, first + 4, kind)
            yield SegmentStarted(i, 2, first, first + 4)
            yield PassFinished(i, 1, 2, 3.5, segment.trajectory)
            yield SegmentFinished(i, 2, segment)
            found.append(segment)
        result = TrackResult(cases.SKELETON, session.settings, tuple(found))
        yield TrackFinished(result, cancelled=cancelled())

    return track


def everything_in(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
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
