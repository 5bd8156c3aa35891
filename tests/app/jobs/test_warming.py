"""On a new computer the loops are compiled first, and only jobs that need them wait."""

from __future__ import annotations

from collections.abc import Iterator
from threading import Event, Thread
from typing import Any, ClassVar

import pytest

from keypose.app.jobs import worker
from keypose.app.jobs.draft import DraftClip
from keypose.app.jobs.find_up import FindUp
from keypose.app.jobs.job import Finished, Job, Report
from keypose.app.jobs.track import Track
from keypose.app.jobs.worker import Cancel, Order, Worker


class Tracks(Job):
    fault: ClassVar[str] = "Failed ({})."

    def run(self, context: Any) -> str:
        return "done"


class Looks(Tracks):
    needs_loops = False


class Desk(Worker):
    """Its reports, and what its jobs wait for."""

    def __init__(self) -> None:
        super().__init__(None)  # type: ignore[arg-type]
        self.compiled, self.reports, self.said = Event(), list[Report](), Event()

    def _warm(self) -> None:
        self.compiled.wait()
        self._warmed.set()

    def _send(self, report: Report) -> None:
        self.reports.append(report)
        self.said.set()

    def next_report(self) -> Report:
        assert self.said.wait(60)
        self.said.clear()
        return self.reports[-1]


@pytest.fixture
def desk(monkeypatch: pytest.MonkeyPatch) -> Iterator[Desk]:
    monkeypatch.setattr(worker, "POLL_S", 0.001)
    made = Desk()
    for work in (made._warm, made._take_orders):
        Thread(target=work, daemon=True).start()
    yield made
    made.compiled.set()


def test_a_job_that_needs_no_loops_is_done_while_they_are_compiled(desk: Desk) -> None:
    desk._handle(Order(1, Looks()))
    assert desk.next_report() == Finished(1, "done")
    desk._handle(Order(2, Tracks()))
    assert not desk.said.wait(0.05)
    desk.compiled.set()
    assert desk.next_report() == Finished(2, "done")


def test_a_job_that_waits_for_them_can_be_cancelled(desk: Desk) -> None:
    desk._handle(Order(1, Tracks()))
    assert not desk.said.wait(0.05)
    desk._handle(Cancel(1))
    assert desk.next_report() == Finished(1, cancelled=True)
    desk._handle(Order(2, Looks()))
    assert desk.next_report() == Finished(2, "done")


def test_drafting_and_the_search_for_up_begin_at_once_and_tracking_waits() -> None:
    assert [job.needs_loops for job in (DraftClip, FindUp, Track)] == [False, False, True]
