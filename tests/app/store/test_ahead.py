"""Tracking ahead at the page's server: shown as it grows, kept once; what is found stays."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.jobs.ahead import FollowAhead
from keypose.app.jobs.job import Failed, Finished, Progress
from keypose.app.state.outcomes import Following
from keypose.app.store.store import Store
from keypose.app.working import queue
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.session import Session
from keypose.tracker.session.annotations import Stop
from keypose.tracker.tracking.ahead.follow import FoundAhead
from tests.scenes import IdleWorker, StoreDesk, opened_store

AHEAD = {"do": "track_ahead", "direction": "forward"}
HIDDEN = Stop(cause="not_seen", part="right_forearm", behind="chest")


class Worker(IdleWorker):
    """Takes orders and reports what the test says."""

    @property
    def order(self) -> FollowAhead:
        return self.of(FollowAhead)[-1]

    def motion(self, steps: int) -> Trajectory:
        """The keyframe's pose, held for so many frames more."""
        doc = Session.model_validate_json(self.order.session)
        keyframe = next(k for k in doc.subject.keyframes if k.frame == self.order.frame)
        pose = keyframe.pose(Skeleton.of(doc.subject.body))
        Rs, ps = pose.Rs_parent_part[None], pose.p_camera_root[None]
        return Trajectory(
            self.order.frame, np.repeat(Rs, steps + 1, axis=0), np.repeat(ps, steps + 1, axis=0)
        )

    def come(self, steps: int) -> None:
        """It has come so far."""
        so_far = Following(self.order.frame, self.motion(steps))
        self.report(Progress(len(self.jobs), steps / 64, partial=so_far))

    def end(self, steps: int, stop: Stop = HIDDEN) -> None:
        order = self.order
        found = FoundAhead(order.frame, order.direction, self.motion(steps), stop)
        self.report(Finished(len(self.jobs), found))


class Desk(StoreDesk):
    """A store with a tab, and one keyframe alone, at 24."""

    def __init__(self, store: Store) -> None:
        super().__init__(store)
        for frame in (0, 48, 72):
            self.do({"do": "delete_key", "frame": frame})

    @property
    def worker(self) -> Worker:
        return Worker.newest

    @property
    def shown(self) -> list[int]:
        """Frames of the drafts that are seen."""
        edit = self.store.app_state.displayed.edit
        assert edit is not None
        return [draft.frame for draft in edit.doc.subject.drafts]

    @property
    def drafts(self) -> list[int]:
        return [draft.frame for draft in self.doc.subject.drafts]

    @property
    def job(self) -> Any:
        return self.store.app_state.job


@pytest.fixture(autouse=True)
def _no_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(queue, "JobRunner", Worker)


@pytest.fixture
async def desk(path: Path) -> AsyncIterator[Desk]:
    async with opened_store(path) as store:
        yield Desk(store)


async def test_it_grows_before_ones_eyes_and_becomes_one_step(desk: Desk) -> None:
    desk.do(AHEAD)
    order = desk.worker.order
    assert (order.frame, order.direction) == (24, "forward")
    assert (desk.job.kind, desk.job.title) == ("ahead", "Tracking ahead from 24")
    desk.worker.come(8)
    desk.store._take_progress()
    assert desk.shown == list(range(25, 33))
    assert desk.drafts == []  # nothing is edited yet
    assert desk.job.percent == pytest.approx(12.5)
    desk.worker.end(12)
    assert desk.drafts == list(range(25, 37)) == desk.shown
    assert desk.doc.subject.ahead[0].stop == HIDDEN
    assert desk.job.state == "idle"
    desk.do({"do": "undo"})
    assert desk.drafts == []


async def test_cancelled_it_keeps_what_was_found(desk: Desk) -> None:
    desk.do(AHEAD)
    before = desk.worker.cancelled
    desk.do({"do": "cancel"})
    assert desk.worker.cancelled == before + 1
    desk.worker.end(5, Stop(cause="cancelled"))
    assert desk.drafts == list(range(25, 30))


async def test_cancelled_before_it_began_all_is_as_it_was(desk: Desk) -> None:
    desk.do(AHEAD, {"do": "cancel"})
    desk.worker.report(Finished(1, cancelled=True))
    assert desk.drafts == []
    assert desk.job.state == "idle"
    desk.do(AHEAD)
    assert len(desk.worker.jobs) == 2


async def test_the_keyframe_changed_meanwhile_and_nothing_is_kept(desk: Desk) -> None:
    turn = {"do": "angles", "part": "left_shin", "x": 20}
    desk.do(AHEAD, {"do": "go", "frame": 24}, turn)
    assert desk.job.state == "idle"
    desk.worker.end(12)
    assert desk.drafts == []


@pytest.mark.parametrize("end", ["nothing", "failed"])
async def test_where_nothing_leads_on_nothing_changes(desk: Desk, end: str) -> None:
    doc = desk.doc
    desk.do(AHEAD)
    if end == "failed":
        desk.worker.report(Failed(1, "The video cannot be read."))
    else:
        desk.worker.end(0)
    assert desk.doc is doc
    assert desk.job.state == "idle"
