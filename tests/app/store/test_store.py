"""The store loses nothing: opening, closing, saving and tracking may come in any order."""

from __future__ import annotations

import asyncio
import os
import shutil
from collections.abc import AsyncIterator, Sequence
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.jobs.job import Finished, Progress
from keypose.app.jobs.progress import Wanted
from keypose.app.jobs.track import Track
from keypose.app.state.app_state import Saved
from keypose.app.store import saving
from keypose.app.store.saving import Saver
from keypose.app.store.store import Store
from keypose.app.working import queue
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import interpolate
from keypose.tracker.errors import SessionError
from keypose.tracker.session import Session
from keypose.tracker.session.verdict import GOOD, Verdict
from keypose.tracker.storage.files import load_session
from keypose.tracker.tracking.result import Diagnostics, SegmentResult
from tests.app import surface_cases
from tests.app.jobs.job_cases import segment_done
from tests.scenes import IdleWorker, opened_store, sample

DRAG = {"do": "angles", "part": "left_forearm", "x": -30, "stroke": "drag"}
EDIT = {"do": "angles", "part": "left_forearm", "x": -30}


class _Tracking(IdleWorker):
    """Takes orders and says nothing by itself."""

    @property
    def orders(self) -> list[tuple[Session, Sequence[Wanted]]]:
        """What is to be tracked, and of which session."""
        return [(Session.model_validate_json(job.session), job.wanted) for job in self.of(Track)]

    def finish(self, number: int) -> None:
        """Report a segment of the first order."""
        doc, wanted = self.orders[0]
        self.report(segment_done(1, _track(doc, *wanted[number])))


def _track(doc: Session, first: int, last: int, key: str) -> SegmentResult:
    skeleton, at = Skeleton.of(doc.subject.body), {k.frame: k for k in doc.subject.keyframes}
    path = interpolate(at[first].pose(skeleton), at[last].pose(skeleton), first, last)
    n, parts, dofs = last - first, skeleton.part_count, skeleton.dof_count
    return SegmentResult(path, GOOD, _measured(n, parts, dofs), (1.0,), ("pass",), key=key)


def _measured(n: int, parts: int, dofs: int) -> Diagnostics:
    return Diagnostics(
        np.full(n, dofs), np.ones((n, dofs)), np.ones((n, parts)), np.ones((n, parts))
    )


def _stopped(doc: Session, first: int, last: int, key: str) -> SegmentResult:
    """The steps up to the middle; the pose there holds on."""
    skeleton = Skeleton.of(doc.subject.body)
    held, n, parts, dofs = last - 2, last - first, skeleton.part_count, skeleton.dof_count
    pose = doc.subject.keyframes[0].pose(skeleton)
    return SegmentResult(
        interpolate(pose, pose, first, last), Verdict.check("not_fitted", (held + 1, last)),
        _measured(n, parts, dofs), (1.0,), ("fit",), key=key, missing=2,
    )  # fmt: skip


@pytest.fixture
async def desk(path: Path) -> AsyncIterator[Store]:
    async with opened_store(path) as made:
        yield made


@pytest.fixture(autouse=True)
def _no_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "JobRunner", _Tracking)


def _forearm(session: Session) -> float:
    return session.subject.keyframes[0].rotations_wxyz["left_forearm"][0]


async def test_a_session_that_is_opened_again_in_the_middle_of_a_drag_keeps_the_drag(
    path: Path,
) -> None:
    async with opened_store(path) as desk:
        tab = desk.join()
        desk.receive(tab, DRAG)
        await desk.open(path)
        await desk.open(path.parent)
        desk.receive(tab, {"do": "go", "frame": 3})
    assert _forearm(load_session(path)) == pytest.approx(np.cos(np.radians(15)))


async def test_a_drag_that_is_taken_back_is_not_on_disk_though_tracking_saved_meanwhile(
    path: Path,
) -> None:
    before = _forearm(load_session(path))
    async with opened_store(path) as desk:
        tab = desk.join()
        desk.receive(tab, {"do": "track", "what": "all"})
        desk.receive(tab, DRAG)
        _Tracking.newest.finish(0)
        _Tracking.newest.report(Finished(1, cancelled=False))
        desk.receive(tab, {"do": "cancel_stroke", "stroke": "drag"})
    assert load_session(path).subject.results is not None
    assert _forearm(load_session(path)) == before


async def test_a_segment_that_was_finished_just_before_the_end_is_saved(path: Path) -> None:
    async with opened_store(path) as desk:
        desk.receive(desk.join(), {"do": "track", "what": "all"})
        _Tracking.newest.finish(0)
    assert load_session(path).subject.results is not None


async def test_what_a_stopped_fit_of_surfaces_has_done_is_kept_saved_and_gone_on_with(
    tmp_path: Path,
) -> None:
    path = surface_cases.write_session(tmp_path / "job")
    async with opened_store(path) as desk:
        tab = desk.join()
        desk.receive(tab, {"do": "track", "what": "changed"})
        doc, wanted = _Tracking.newest.orders[0]
        _Tracking.newest.report(segment_done(1, _stopped(doc, *wanted[0])))
        _Tracking.newest.report(Finished(1, cancelled=True))
        assert desk.app_state.job.title == "Cancelled"
        assert desk.app_state.job.words == "finished frames are kept; Fit continues from there"
        desk.receive(tab, {"do": "track", "what": "changed"})
        assert len(_Tracking.newest.orders) == 2
    session = load_session(path)
    assert session.subject.results is not None
    assert [(s.verdict, s.missing) for s in session.subject.results.segments] == [
        (Verdict.check("not_fitted", (3, 4)), 2)
    ]


async def test_a_fit_that_is_under_way_when_the_server_ends_is_kept_as_far_as_it_came(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = surface_cases.write_session(tmp_path / "job")

    def cancel(tracking: _Tracking) -> None:
        if not tracking.orders:
            return
        doc, wanted = tracking.orders[0]
        tracking.jobs.clear()
        tracking.report(segment_done(1, _stopped(doc, *wanted[0])))
        tracking.report(Finished(1, cancelled=True))

    monkeypatch.setattr(_Tracking, "cancel", cancel)
    async with opened_store(path) as desk:
        desk.receive(desk.join(), {"do": "track", "what": "changed"})
        _Tracking.newest.report(Progress(1, 0.0))
    session = load_session(path)
    assert session.subject.results is not None
    assert session.subject.results.segments[0].missing == 2


async def test_tracks_that_no_session_speaks_of_go_when_it_is_closed_however_young(
    path: Path,
) -> None:
    async with opened_store(path) as store:
        (path.parent / "tracks-0123456789ab.npz").touch()
        await store.close_session()
    assert not list(path.parent.glob("tracks-*.npz"))


async def test_segments_that_come_in_quickly_do_not_put_off_saving_for_ever(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(saving, "SECONDS_BETWEEN_SAVES", 0.2)
    async with opened_store(path) as desk:
        desk.receive(desk.join(), {"do": "track", "what": "all"})
        async with asyncio.timeout(60):
            for number in count():
                _Tracking.newest.finish(number % 3)
                await asyncio.sleep(0.05)
                if load_session(path).subject.results is not None:
                    return


async def test_what_a_job_reports_after_its_session_was_closed_does_not_reach_the_next_one(
    path: Path, tmp_path: Path
) -> None:
    box = sample(tmp_path, "box")
    async with opened_store(path) as desk:
        desk.receive(desk.join(), {"do": "track", "what": "all"})
        await desk.open(box)
        assert desk.app_state.job.state == "idle"
        _Tracking.newest.finish(0)
        _Tracking.newest.report(Finished(1, cancelled=True))
        assert desk.app_state.edit is not None
        assert len(desk.app_state.edit.results) == 0
        assert desk.app_state.job.state == "idle"


async def test_a_tab_that_joins_takes_no_news_away_from_the_others(desk: Store) -> None:
    tab = desk.join()
    await tab.next()
    desk.receive(tab, {"do": "go", "frame": 7})
    other = desk.join()
    for one in (tab, other):
        reported = (await one.next())[-1]["set"]
        assert reported["view"]["frame"] == 7
        assert reported["tabs"] == 2


async def test_what_cannot_be_saved_is_not_closed_before_a_person_knows(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: Any) -> None:
        raise SessionError("The disk is full.")

    async def work() -> None:
        async with opened_store(path) as desk:
            desk.receive(desk.join(), EDIT)
            with pytest.raises(SessionError, match=r"The disk is full\. Repeat to continue"):
                await desk.close_session()
            assert desk.app_state.edit is not None
            await desk.close_session()
            assert desk.app_state.edit is None
            await desk.open(path)
            desk.receive(desk.join(), EDIT)

    monkeypatch.setattr("keypose.app.document.edit_log.save_session", full)
    with pytest.raises(SessionError, match="The last changes are in its journal"):
        await work()


async def test_what_could_not_be_saved_is_tried_once_more_at_the_end(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def odd(*_: Any) -> None:
        raise ValueError("odd")

    async with opened_store(path) as desk:
        with monkeypatch.context() as patch:
            patch.setattr("keypose.app.document.edit_log.save_session", odd)
            desk.receive(desk.join(), EDIT)
            await asyncio.sleep(0)
            while desk.app_state.saved.state == "saving":
                await asyncio.sleep(0.01)
        assert desk.app_state.saved.state == "failed"
        assert "ValueError" in desk.app_state.saved.words
    assert _forearm(load_session(path)) == pytest.approx(np.cos(np.radians(15)))


def test_trying_again_never_puts_an_older_state_over_a_newer_one() -> None:
    written: list[int] = []
    reported: list[Saved] = []

    def write(number: int) -> None:
        if not reported or reported[-1].state != "failed":
            raise SessionError("The disk is full.")
        written.append(number)

    async def work() -> None:
        saver = Saver(reported.append)
        saver.save(lambda: write(1))
        await saver.wait()
        reported.append(Saved("failed"))
        saver.save(lambda: written.append(2))
        saver.retry()
        await saver.wait()

    asyncio.run(work())
    assert written == [2]


async def test_pictures_of_two_videos_have_different_names(path: Path, tmp_path: Path) -> None:
    box = sample(tmp_path, "box")
    names = []
    async with opened_store(path) as desk:
        for one in (path, box):
            await desk.open(one)
            reported = (await desk.join().next())[-1]["set"]
            names.append(reported["camera"]["image_version"])
    assert names[0] != names[1]


async def test_an_upload_is_thrown_away_only_when_it_is_no_video(
    path: Path, tmp_path: Path
) -> None:
    uploads = tmp_path / "work" / "videos"
    async with opened_store(path) as desk:
        uploads.mkdir(parents=True)
        (uploads / "none.mp4").write_bytes(b"no video")
        shutil.copy(path.with_name("person.mp4"), uploads / "walk.mp4")
        (uploads / "walk.keypose").mkdir()
        (uploads / "walk.keypose" / "session.json").write_text("damaged")
        tab = desk.join()
        for name in ("none.mp4", "walk.mp4"):
            desk.receive(tab, {"do": "open", "kind": "upload", "id": name})
            notes: list[Any] = []
            while not notes:
                notes = [m for m in await tab.next() if m["t"] == "note"]
    assert [file.name for file in uploads.glob("*.mp4")] == ["walk.mp4"]


@pytest.mark.skipif(os.name != "posix", reason="names are text there")
async def test_a_video_whose_name_is_no_text_is_refused_in_words(
    path: Path, tmp_path: Path
) -> None:
    odd = tmp_path / os.fsdecode(b"caf\xe9.mp4")
    shutil.copy(path.with_name("person.mp4"), odd)
    async with opened_store(path) as desk:
        with pytest.raises(SessionError, match="rename"):
            await desk.open(odd)
