"""The motion in space follows by itself: after tracking, after opening, and is saved."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from keypose.app.document.library import Library
from keypose.app.jobs import JobFailed, JobFinished, Report, SegmentFinished, SpaceSolved, Wanted
from keypose.app.store import runner
from keypose.app.store.store import Store
from keypose.tracker.session import Session
from keypose.tracker.session.pins import Pin
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.stretches import SegmentRun
from keypose.tracker.storage.tracks import load_tracks
from tests.app.store.test_store import _copy, _track
from tests.tracker.storage.space_cases import solution

PIN = Pin(part="left_foot", landmarks=("left_heel", "left_toe"), first_frame=2, last_frame=9)
TRACK = {"do": "track", "what": "all"}


class _Tracking:
    """Takes orders and says nothing by itself."""

    newest: _Tracking

    def __init__(self, report: Callable[[Report], None], _: object) -> None:
        self.report = report
        self.jobs = 0
        self.orders: list[tuple[Session, Sequence[Wanted]]] = []
        self.solved: list[Sequence[SegmentRun]] = []
        _Tracking.newest = self

    def start(self, doc: Session, _: Path, wanted: Sequence[Wanted], *__: object) -> int:
        self.orders.append((doc, wanted))
        return self._job()

    def solve_space(self, _: Session, stretches: Sequence[SegmentRun]) -> int:
        self.solved.append(stretches)
        return self._job()

    def _job(self) -> int:
        self.jobs += 1
        return self.jobs

    def track(self) -> None:
        """All that was ordered first is tracked."""
        doc, wanted = self.orders[0]
        for one in wanted:
            self.report(SegmentFinished(1, _track(doc, *one)))
        self.report(JobFinished(1, cancelled=False))

    def solve(self) -> None:
        """What was ordered last is solved."""
        for stretch in self.solved[-1]:
            self.report(SpaceSolved(self.jobs, solution(stretch)))
        self.report(JobFinished(self.jobs, cancelled=False))

    def cancel(self) -> None: ...

    def pause(self, on: bool) -> None: ...

    def close(self) -> None: ...


@pytest.fixture(autouse=True)
def _no_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runner, "Tracking", _Tracking)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Somebody whose foot is pinned."""
    found = _copy("person", tmp_path)
    save_session(load_session(found).model_copy(update={"pins": (PIN,), "results": None}), found)
    return found


def _store(path: Path) -> Store:
    folder = path.parent.parent
    return Store(asyncio.get_running_loop(), lambda *_: None, Library(folder / "work", [folder]))


def _with_store(path: Path, work: Callable[[Store], Awaitable[None]]) -> None:
    async def whole() -> None:
        desk = _store(path)
        await desk.open(path)
        await work(desk)
        await desk.stop()

    asyncio.run(whole())


def _pinned(desk: Store) -> list[Any]:
    edit = desk.app_state.edit
    assert edit is not None
    return edit.results.space(edit.doc)


def test_what_was_tracked_is_solved_at_once_and_saved(path: Path) -> None:
    async def work(desk: Store) -> None:
        desk.receive(desk.join(), TRACK)
        assert _Tracking.newest.solved == []
        _Tracking.newest.track()
        assert len(_Tracking.newest.solved) == 1
        assert desk.app_state.job.title.startswith("Smoothing")
        _Tracking.newest.solve()
        assert len(_pinned(desk)) == 1
        assert (desk.app_state.job.state, desk.app_state.job.title[:7]) == ("done", "Tracked")
        assert len(_Tracking.newest.solved) == 1

    _with_store(path, work)
    again = load_session(path)
    assert again.results is not None
    assert len(again.results.space) == 1
    assert load_tracks(again, path).before_space is not None


def test_a_session_that_is_opened_tracked_but_not_solved_is_solved_then(path: Path) -> None:
    async def tracked(desk: Store) -> None:
        desk.receive(desk.join(), TRACK)
        _Tracking.newest.track()

    _with_store(path, tracked)
    results = load_session(path).results
    assert results is not None
    assert results.space == ()

    async def opened(desk: Store) -> None:
        assert len(_Tracking.newest.solved) == 1
        _Tracking.newest.solve()

    _with_store(path, opened)
    results = load_session(path).results
    assert results is not None
    assert len(results.space) == 1

    async def once_more(desk: Store) -> None:
        assert _Tracking.newest.solved == []
        assert len(_pinned(desk)) == 1

    _with_store(path, once_more)


def test_what_may_not_be_saved_is_not_solved(path: Path) -> None:
    async def tracked(desk: Store) -> None:
        desk.receive(desk.join(), TRACK)
        _Tracking.newest.track()

    _with_store(path, tracked)

    async def second(desk: Store) -> None:
        other = _store(path)
        await other.open(path)
        assert other.app_state.saved.state == "readonly"
        assert _Tracking.newest.solved == []
        await other.stop()

    _with_store(path, second)


def test_a_failing_solve_is_reported_once_and_the_tracked_motion_is_saved(path: Path) -> None:
    async def work(desk: Store) -> None:
        desk.receive(desk.join(), TRACK)
        _Tracking.newest.track()
        words = "Smoothing stopped unexpectedly; the motion is as it was tracked."
        _Tracking.newest.report(JobFailed(2, words))
        job = desk.app_state.job
        assert (job.state, job.title, job.words) == ("failed", "Smoothing failed", words)
        assert len(_Tracking.newest.solved) == 1

    _with_store(path, work)
    again = load_session(path)
    assert again.results is not None
    assert again.results.space == ()
    assert load_tracks(again, path).before_space is None


def test_an_undone_keyframe_finds_the_motion_in_space_again(path: Path) -> None:
    async def work(desk: Store) -> None:
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

    _with_store(path, work)
