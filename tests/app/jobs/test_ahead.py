"""An order to track ahead, at work: it tells how far it is, and cancelled keeps what it found."""

from __future__ import annotations

from threading import Event

import pytest

from keypose.app.jobs.ahead import FollowAhead
from keypose.app.jobs.job import Failed, Finished, Progress, Report
from keypose.app.jobs.worker_cache import WorkerCache
from keypose.app.state.outcomes import Following
from keypose.tracker.session import Session
from keypose.tracker.session.annotations import Direction
from keypose.tracker.storage.files import load_session
from tests.app import surface_cases
from tests.app.jobs.job_cases import reported
from tests.app.serving import ROOT

BOX = ROOT / "sample_videos" / "box" / "session.json"


@pytest.fixture(scope="module")
def cache() -> WorkerCache:
    return WorkerCache()


def worked(cache: WorkerCache, session: Session, frame: int, *, cancel: bool) -> list[Report]:
    """All that is reported of an order from this frame."""
    cancelled = Event()
    way: Direction = "forward" if frame == 0 else "backward"
    if cancel:
        cancelled.set()
    video, folder = BOX.with_name("box.mp4"), str(BOX.parent)
    job = FollowAhead(session.model_dump_json().encode(), str(video), folder, frame, way)
    return reported(job, cache, cancelled)


def one_key(frame: int) -> Session:
    session = load_session(BOX)
    keys = tuple(k for k in session.subject.keyframes if k.frame == frame)
    return session.changed({"keyframes": keys, "results": None})


def test_it_shows_how_far_it_is_and_what_it_found(cache: WorkerCache) -> None:
    *on_the_way, end = worked(cache, one_key(40), 40, cancel=False)
    assert on_the_way
    for report in on_the_way:
        assert isinstance(report, Progress)
        assert isinstance(report.partial, Following)
        assert report.words
    assert isinstance(end, Finished)
    assert (end.result.to_frame, end.result.stop.cause) == (0, "clip_end")


def test_cancelled_it_keeps_what_it_found(cache: WorkerCache) -> None:
    (end,) = worked(cache, one_key(40), 40, cancel=True)
    assert isinstance(end, Finished)
    assert end.result.stop.cause == "cancelled"
    assert end.result.to_frame < 40


def test_of_surfaces_it_is_refused(cache: WorkerCache) -> None:
    (end,) = worked(cache, surface_cases.session(), 0, cancel=False)
    assert isinstance(end, Failed)
    assert end.words == "Surfaces are fitted from one keyframe on: press Fit."
