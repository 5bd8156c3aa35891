"""One order to draft a clip: its progress, its end, and how it is left."""

from __future__ import annotations

from pathlib import Path
from threading import Event

import pytest

from keypose.app.document.new import new_session
from keypose.app.jobs.fits import FitJob
from keypose.app.jobs.messages import Drafted, Drafting, DraftOrder, JobFailed, JobFinished, Report
from keypose.app.jobs.work import WorkerCache
from keypose.tracker.video import Video
from tests.tracker.keypoints.keypoint_cases import BALANCE, BOX

VIDEO = BALANCE / "balance.mp4"


@pytest.fixture(scope="module")
def content() -> bytes:
    """A session of the film, as an order holds it."""
    with Video.open(VIDEO) as video:
        return new_session(video, Path("session.json").absolute()).model_dump_json().encode()


def reported(order: DraftOrder, cancelled: Event | None = None, leave_at: int = -1) -> list[Report]:
    """All reports of an order, which is cancelled after so many."""
    reports: list[Report] = []
    left = cancelled or Event()

    def send(report: Report) -> None:
        reports.append(report)
        if len(reports) == leave_at:
            left.set()

    cache = WorkerCache()
    try:
        FitJob(order, left, send).run(cache)
    finally:
        cache.close()
    return reports


def order(content: bytes, box: tuple[float, float, float, float] = BOX) -> DraftOrder:
    return DraftOrder(content, str(VIDEO), 0, box, (0, 4), proportions=True, job=7)


def test_a_clip_is_drafted_and_its_progress_rises(content: bytes) -> None:
    *progress, end = reported(order(content))
    assert isinstance(end, Drafted)
    assert (end.job, sorted(end.poses)) == (7, list(range(5)))
    assert end.network
    shares = [
        (report.stage, report.done / report.expected)
        for report in progress
        if isinstance(report, Drafting)
    ]
    assert len(shares) == len(progress)
    assert shares == sorted(shares)


def test_a_cancelled_draft_reports_nothing_it_found(content: bytes) -> None:
    *progress, end = reported(order(content), leave_at=2)
    assert end == JobFinished(7, cancelled=True)
    assert len(progress) == 2


def test_a_box_with_nobody_in_it_is_one_sentence(content: bytes) -> None:
    end = reported(order(content, (0.0, 0.0, 60.0, 60.0)))[-1]
    assert isinstance(end, JobFailed)
    assert end.words.startswith("No person was found at frame 0:")
