"""The whole road: a loop, a worker process, reports. Nothing here depends on how long it takes."""

from __future__ import annotations

import asyncio
import os
import signal
import threading
from collections.abc import AsyncIterator, Callable
from itertools import groupby
from pathlib import Path
from typing import Any

import pytest

from keypose.app.jobs.job import Failed, Finished, Progress, Report, Warming
from keypose.app.jobs.job_runner import JobRunner
from keypose.app.jobs.track import Track
from keypose.tracker.operations.track import track_session
from keypose.tracker.session import Session
from keypose.tracker.storage.results import Results, segment_keys
from keypose.tracker.tracking.pool import TrackFinished
from keypose.tracker.video import Video
from tests.app.jobs.job_cases import passes, segments
from tests.tracker import session_cases as cases

PATIENCE_S = 300.0
"""The loops may have to be compiled first."""


@pytest.fixture
def place(tmp_path: Path) -> tuple[Session, Path]:
    return cases.session(), cases.write_frames(tmp_path / "frames")


def wanted(of: Session) -> list[tuple[int, int, str]]:
    return [(*span, key) for span, key in segment_keys(of).items()]


class Office:
    """Tracking and all it has reported."""

    def __init__(self) -> None:
        self.reported: list[Report] = []
        self.threads: set[int] = set()
        self._more = asyncio.Event()
        self.tracking = JobRunner(self._report, asyncio.get_running_loop())

    def _report(self, report: Report) -> None:
        self.reported.append(report)
        self.threads.add(threading.get_ident())
        self._more.set()

    async def until(self, seen: Callable[[Report], bool]) -> Report:
        """The first report like this, of those told or to come."""
        while True:
            for report in self.reported:
                if seen(report):
                    return report
            self._more.clear()
            await asyncio.wait_for(self._more.wait(), PATIENCE_S)

    async def ended(self, job: int) -> Report:
        return await self.until(
            lambda report: isinstance(report, Finished | Failed) and report.job == job
        )

    def of(self, job: int, kind: Any) -> list[Any]:
        return [r for r in self.reported if isinstance(r, kind) and r.job == job]


@pytest.fixture
async def office() -> AsyncIterator[Office]:
    """One whose worker is ended afterwards."""
    made = Office()
    yield made
    made.tracking.close()


@pytest.fixture(scope="module")
async def lasting() -> AsyncIterator[Office]:
    """One whose worker is not ended between tests."""
    made = Office()
    yield made
    made.tracking.close()


async def test_a_job_is_told_from_warming_to_its_end_on_the_loops_own_thread(
    place: tuple[Session, Path], office: Office
) -> None:
    of, video = place

    job = office.tracking.start(Track.of(of, video, wanted(of), ("preview", "full")))
    assert office.tracking.job == job
    assert await office.ended(job) == Finished(job)
    assert office.tracking.job is None
    assert [kind for kind, _ in groupby(map(type, office.reported))][:2] == [Warming, Progress]
    found = [(one.span, one.quality) for one in segments(office.of(job, Progress))]
    assert sorted(found) == [
        *(((0, 4), "full"), ((0, 4), "preview"), ((4, 8), "full")),
        ((4, 8), "preview"),
    ]
    assert {one.result.quality for one in passes(office.of(job, Progress))} == {"full"}
    results = Results()
    for one in segments(office.of(job, Progress)):
        results = results.with_result(one)
    assert list(results.fitting(of)) == [(0, 4), (4, 8)]
    assert results.wanted(of, "full") == []
    assert office.threads == {threading.get_ident()}


async def test_the_result_is_the_one_the_tracker_finds_without_a_worker(
    place: tuple[Session, Path], lasting: Office
) -> None:
    of, path = place
    with Video.open(path) as video:
        *_, last = track_session(of, video)
    assert isinstance(last, TrackFinished)

    job = lasting.tracking.start(Track.of(of, path, wanted(of), (of.settings.quality,)))
    await lasting.ended(job)
    found = {one.first: one for one in segments(lasting.of(job, Progress))}
    for segment in last.result.segments:
        mine = found[segment.trajectory.first_frame]
        assert mine.trajectory.Rs_parent_part.tolist() == (
            segment.trajectory.Rs_parent_part.tolist()
        )
        assert mine.verdict == segment.verdict


async def test_of_several_jobs_the_newest_is_done_and_every_one_ends_once(
    place: tuple[Session, Path], lasting: Office
) -> None:
    of, video = place

    jobs = [lasting.tracking.start(Track.of(of, video, wanted(of))) for _ in range(4)]
    assert await lasting.ended(jobs[-1]) == Finished(jobs[-1])
    for job in jobs:
        assert len(lasting.of(job, Finished)) == 1
    assert len(segments(lasting.of(jobs[-1], Progress))) == 2


async def test_a_job_that_has_to_wait_for_the_worker_is_reported_so(
    place: tuple[Session, Path], office: Office
) -> None:
    of, video = place

    await office.until(lambda report: isinstance(report, Warming))
    assert office.reported[0].job is None
    job = office.tracking.start(Track.of(of, video, wanted(of)))
    await office.ended(job)
    said = [bool(report.words) for report in office.of(job, Warming)]
    assert said in ([*[True] * (len(said) - 1), False], [])  # or it was ready just then


async def test_a_cancelled_job_ends_and_the_next_one_works(
    place: tuple[Session, Path], lasting: Office
) -> None:
    of, video = place

    first = lasting.tracking.start(Track.of(of, video, wanted(of)))
    lasting.tracking.cancel()
    assert isinstance(await lasting.ended(first), Finished)
    lasting.tracking.cancel()  # there is nothing to cancel, which is no matter
    second = lasting.tracking.start(Track.of(of, video, wanted(of)[:1]))
    assert await lasting.ended(second) == Finished(second)


async def test_a_killed_worker_is_reported_and_replaced(
    place: tuple[Session, Path], office: Office
) -> None:
    of, video = place

    job = office.tracking.start(Track.of(of, video, wanted(of)))
    killed = office.tracking.pid
    assert killed is not None
    os.kill(killed, signal.SIGKILL)
    end = await office.ended(job)
    assert isinstance(end, Failed)
    assert end.words.startswith("Tracking stopped unexpectedly")
    again = office.tracking.start(Track.of(of, video, wanted(of)))
    assert office.tracking.pid not in (None, killed)
    assert await office.ended(again) == Finished(again)


async def test_a_video_that_is_not_there_is_reported_in_one_sentence(
    place: tuple[Session, Path], lasting: Office
) -> None:
    of, video = place

    job = lasting.tracking.start(Track.of(of, video / "nowhere.mp4", wanted(of)))
    end = await lasting.ended(job)
    assert isinstance(end, Failed)
    assert "nowhere.mp4" in end.words
    assert end.words.endswith(".")
    after = lasting.tracking.start(Track.of(of, video, wanted(of)))
    assert await lasting.ended(after) == Finished(after)


async def test_closing_ends_the_process_even_while_it_gets_ready() -> None:
    office = Office()
    office.tracking.start(Track.of(cases.session(), Path("x"), []))
    pid = office.tracking.pid
    assert pid is not None
    office.tracking.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    office.tracking.close()
    with pytest.raises(RuntimeError, match="closed"):
        office.tracking.start(Track.of(cases.session(), Path("x"), []))
