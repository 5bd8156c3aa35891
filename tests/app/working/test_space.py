"""The motion in space follows by itself: after tracking, after opening, and is saved."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from keypose.app.jobs.job import Failed, Finished, Progress
from keypose.app.jobs.space import SolveSpace
from keypose.app.jobs.track import Track
from keypose.app.store.store import Store
from keypose.app.working import queue
from keypose.tracker.session import Session
from keypose.tracker.session.pins import Pin
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.stretches import SegmentRun
from keypose.tracker.storage.tracks import load_tracks
from tests.app.jobs.job_cases import segment_done
from tests.app.store.test_store import _track
from tests.scenes import IdleWorker, opened_store, sample
from tests.tracker.operations.space_cases import solution

PIN = Pin(part="left_foot", landmarks=("left_heel", "left_toe"), first_frame=2, last_frame=9)
TRACK = {"do": "track", "what": "all"}


class _Tracking(IdleWorker):
    """Takes orders and says nothing by itself."""

    @property
    def solved(self) -> list[Sequence[SegmentRun]]:
        return [job.stretches for job in self.of(SolveSpace)]

    def track(self) -> None:
        """All that was ordered first is tracked."""
        job = self.of(Track)[0]
        doc = Session.model_validate_json(job.session)
        for one in job.wanted:
            self.report(segment_done(1, _track(doc, *one)))
        self.report(Finished(1))

    def solve(self) -> None:
        """What was ordered last is solved."""
        for stretch in self.solved[-1]:
            self.report(Progress(len(self.jobs), 1.0, partial=solution(stretch)))
        self.report(Finished(len(self.jobs)))


@pytest.fixture
async def desk(path: Path) -> AsyncIterator[Store]:
    async with opened_store(path) as made:
        yield made


@pytest.fixture(autouse=True)
def _no_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "JobRunner", _Tracking)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Somebody whose foot is pinned."""
    found = sample(tmp_path)
    save_session(load_session(found).changed({"pins": (PIN,), "results": None}), found)
    return found


def _pinned(desk: Store) -> list[Any]:
    edit = desk.app_state.edit
    assert edit is not None
    return edit.results.space(edit.doc)


async def test_what_was_tracked_is_solved_at_once_and_saved(path: Path) -> None:
    async with opened_store(path) as desk:
        desk.receive(desk.join(), TRACK)
        assert _Tracking.newest.solved == []
        _Tracking.newest.track()
        assert len(_Tracking.newest.solved) == 1
        assert desk.app_state.job.title.startswith("Smoothing")
        _Tracking.newest.solve()
        assert len(_pinned(desk)) == 1
        assert (desk.app_state.job.state, desk.app_state.job.title[:7]) == ("done", "Tracked")
        assert len(_Tracking.newest.solved) == 1
    again = load_session(path)
    assert again.subject.results is not None
    assert len(again.subject.results.space) == 1
    assert load_tracks(again, path).before_space is not None


async def test_a_session_that_is_opened_tracked_but_not_solved_is_solved_then(path: Path) -> None:
    async with opened_store(path) as desk:
        desk.receive(desk.join(), TRACK)
        _Tracking.newest.track()
    results = load_session(path).subject.results
    assert results is not None
    assert results.space == ()
    async with opened_store(path) as desk:
        assert len(_Tracking.newest.solved) == 1
        _Tracking.newest.solve()
    results = load_session(path).subject.results
    assert results is not None
    assert len(results.space) == 1
    async with opened_store(path) as desk:
        assert _Tracking.newest.solved == []
        assert len(_pinned(desk)) == 1


async def test_what_may_not_be_saved_is_not_solved(path: Path) -> None:
    async with opened_store(path) as desk:
        desk.receive(desk.join(), TRACK)
        _Tracking.newest.track()
    async with opened_store(path), opened_store(path) as other:
        assert other.app_state.saved.state == "readonly"
        assert _Tracking.newest.solved == []


async def test_a_failing_solve_is_reported_once_and_the_tracked_motion_is_saved(path: Path) -> None:
    async with opened_store(path) as desk:
        desk.receive(desk.join(), TRACK)
        _Tracking.newest.track()
        words = "Smoothing stopped unexpectedly; the motion is as it was tracked."
        _Tracking.newest.report(Failed(2, words))
        job = desk.app_state.job
        assert (job.state, job.title, job.words) == ("failed", "Smoothing failed", words)
        assert len(_Tracking.newest.solved) == 1
    again = load_session(path)
    assert again.subject.results is not None
    assert again.subject.results.space == ()
    assert load_tracks(again, path).before_space is None


async def test_an_undone_keyframe_finds_the_motion_in_space_again(desk: Store) -> None:
    tab = desk.join()
    desk.receive(tab, TRACK)
    _Tracking.newest.track()
    _Tracking.newest.solve()
    (before,) = _pinned(desk)
    desk.receive(tab, {"do": "angles", "part": "left_forearm", "x": -30})
    desk.receive(tab, {"do": "undo"})
    (after,) = _pinned(desk)
    assert after is before
    assert len(_Tracking.newest.solved) == 1


async def test_a_gesture_that_is_cancelled_leaves_the_solve_it_interrupted_to_go_on(
    path: Path,
) -> None:
    async with opened_store(path) as desk:
        tab = desk.join()
        for message in (
            TRACK,
            {"do": "live", "on": True},
            {"do": "go", "frame": 24},
        ):
            desk.receive(tab, message)
        _Tracking.newest.track()
        assert len(_Tracking.newest.solved) == 1
        turn = {"do": "angles", "part": "head", "x": 20.0, "stroke": "drag"}
        desk.receive(tab, turn)
        assert isinstance(_Tracking.newest.jobs[-1], Track), "a hand goes first"
        _Tracking.newest.report(Finished(len(_Tracking.newest.jobs)))
        assert len(_Tracking.newest.solved) == 1, "while it moves the keyframe"
        desk.receive(tab, {"do": "cancel_stroke", "stroke": "drag"})
        assert len(_Tracking.newest.solved) == 2
        assert desk.app_state.job.title.startswith("Smoothing")
