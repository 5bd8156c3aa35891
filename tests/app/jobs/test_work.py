"""One job, with a tracker that does as the test says."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest

from keypose.app.jobs.job import Failed, Finished, Report
from keypose.app.jobs.track import Track
from keypose.tracker.body.trajectory import Pass
from keypose.tracker.errors import SessionError, VideoError
from keypose.tracker.session import Session
from keypose.tracker.session.settings import Quality, TrackSettings
from keypose.tracker.storage.results import Span, segment_keys
from keypose.tracker.tracking.method import expected_steps
from tests.app.jobs.job_cases import passes, reported, segments
from tests.tracker import session_cases as cases

Work = Callable[[int, int, TrackSettings, Callable[[Pass, int], None]], None]


class FakeBench:
    """Its tracker calls `work` with first and last frame, and then has found a segment."""

    def __init__(self, work: Work) -> None:
        self.work = work
        self.refused: set[tuple[int, int]] = set()

    def tracker(self, session: Session, video_path: str, folder: Path) -> Any:
        bench = self

        class FakeTracker:
            def expected_steps(self, span: Span, settings: TrackSettings) -> int:
                return expected_steps(settings)

            def run_segment(self, span: Span, settings: TrackSettings, emit: Any) -> Any:
                first, last = span
                if span in bench.refused:
                    raise SessionError(f"Keyframes {first} and {last} lie too far apart.")
                bench.work(first, last, settings, emit)
                return cases.segment(first, last)

        return FakeTracker()


def at_ease(first: int, last: int, settings: TrackSettings, emit: Any) -> None:
    emit(Pass("both ways", cases.segment(first, last).trajectory, 3.0), 0)
    emit(Pass("pass", cases.segment(first, last).trajectory, None), 1)


def done(
    bench: FakeBench, *stages: Quality, cancelled: Event | None = None, threads: int = 1,
    settings: TrackSettings | None = None,
) -> list[Report]:  # fmt: skip
    """All reports of a job over both segments."""
    session = cases.session().changed({"settings": settings or TrackSettings()})
    wanted = tuple((*span, key) for span, key in segment_keys(session).items())
    job = Track.of(session, Path("video"), wanted, stages or ("full",))
    return reported(job, bench, cancelled, threads)


def finished(reports: list[Report]) -> list[tuple[int, str]]:
    return [(found.first, found.quality) for found in segments(reports)]


def test_all_segments_are_done_at_one_quality_before_the_next() -> None:
    reports = done(FakeBench(at_ease), "preview", "full")
    assert finished(reports) == [(0, "preview"), (4, "preview"), (0, "full"), (4, "full")]
    assert reports[-1] == Finished(7, cancelled=False)


def test_passes_are_reported_but_not_those_of_a_preview() -> None:
    reports = passes(done(FakeBench(at_ease), "preview", "full"))
    assert [(r.result.first, r.result.quality, r.number) for r in reports] == [
        *((0, "full", 0), (0, "full", 1), (4, "full", 0)),
        (4, "full", 1),
    ]
    assert {r.of for r in reports} == {expected_steps(TrackSettings())}
    assert reports[0].result.scores == (3.0,)
    assert np.isnan(reports[1].result.scores).all()  # not judged


def test_results_carry_the_key_they_were_ordered_with() -> None:
    keys = segment_keys(cases.session().changed({"settings": TrackSettings()}))
    for found in segments(done(FakeBench(at_ease))):
        assert keys[found.span] == found.key


def test_a_preview_keeps_to_its_own_number_of_passes() -> None:
    seen: list[tuple[str, int | None]] = []

    def work(first: int, last: int, settings: TrackSettings, emit: Any) -> None:
        seen.append((settings.quality, settings.passes))

    done(FakeBench(work), "preview", "full", settings=TrackSettings(passes=9))
    assert seen == [("preview", None)] * 2 + [("full", 9)] * 2


def test_the_published_method_is_worked_through_once() -> None:
    seen: list[tuple[str, int | None]] = []

    def work(first: int, last: int, settings: TrackSettings, emit: Any) -> None:
        seen.append((settings.method, settings.passes))

    done(FakeBench(work), "preview", "full", settings=TrackSettings(method="paper", passes=9))
    assert seen == [("paper", 9)] * 2


def test_a_cancelled_job_is_left_at_its_next_pass_and_keeps_what_is_finished() -> None:
    cancelled = Event()

    def work(first: int, last: int, settings: TrackSettings, emit: Any) -> None:
        if first == 4:
            emit(Pass("both ways", cases.segment(first, last).trajectory, 3.0), 0)
            cancelled.set()
            emit(Pass("pass", cases.segment(first, last).trajectory, 3.0), 1)
            raise AssertionError("it went on")

    reports = done(FakeBench(work), cancelled=cancelled)
    assert finished(reports) == [(0, "full")]
    assert reports[-1] == Finished(7, cancelled=True)


def test_a_job_cancelled_before_it_began_does_nothing() -> None:
    cancelled = Event()
    cancelled.set()
    reports = done(FakeBench(at_ease), cancelled=cancelled)
    assert finished(reports) == []
    assert reports[-1] == Finished(7, cancelled=True)


def test_a_job_that_was_done_when_it_was_cancelled_is_done() -> None:
    cancelled = Event()

    def work(first: int, last: int, settings: TrackSettings, emit: Any) -> None:
        if first == 4:
            cancelled.set()

    assert done(FakeBench(work), cancelled=cancelled)[-1] == Finished(7, cancelled=False)


@pytest.mark.parametrize("threads", [1, 2])
def test_what_goes_wrong_in_one_segment_leaves_the_others(threads: int) -> None:
    def work(first: int, last: int, settings: TrackSettings, emit: Any) -> None:
        if first == 0:
            raise VideoError("The video has no frame 3.")

    reports = done(FakeBench(work), "preview", "full", threads=threads)
    assert sorted(finished(reports)) == [(4, "full"), (4, "preview")]  # side by side, in any order
    assert reports[-1] == Failed(7, "The video has no frame 3.")


def test_a_segment_that_cannot_be_begun_leaves_the_others() -> None:
    bench = FakeBench(at_ease)
    bench.refused.add((4, 8))
    reports = done(bench)
    assert finished(reports) == [(0, "full")]
    assert reports[-1] == Failed(7, "Keyframes 4 and 8 lie too far apart.")


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (MemoryError(), "There is not enough memory to track 0–4: set a keyframe between"),
        (ZeroDivisionError(), "an internal error (ZeroDivisionError)"),
    ],
)
def test_faults_are_one_sentence_too(
    error: Exception, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    def work(first: int, last: int, settings: TrackSettings, emit: Any) -> None:
        raise error

    last = done(FakeBench(work))[-1]
    assert isinstance(last, Failed)
    assert words in last.words
    assert last.words.endswith(".")
    assert ("Traceback" in capsys.readouterr().err) == isinstance(error, ZeroDivisionError)


def test_a_session_that_does_not_fit_together_is_reported_in_one_sentence() -> None:
    job = Track(b'{"schema_version": 1}', "video", (), ("full",))
    (last,) = reported(job, FakeBench(at_ease))
    assert isinstance(last, Failed)
    assert "field required" in last.words
