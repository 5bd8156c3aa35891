"""On a new computer the loops are compiled first, and only jobs that need them wait."""

from __future__ import annotations

from collections.abc import Iterator
from threading import Event, Thread

import pytest

from keypose.app.jobs import worker
from keypose.app.jobs.draft import DraftClip
from keypose.app.jobs.find_up import FindUp
from keypose.app.jobs.job import Finished, Job, Report
from keypose.app.jobs.track import Track
from keypose.app.jobs.worker import Cancel, Order, Worker


def job(kind: type[Job], monkeypatch: pytest.MonkeyPatch) -> Job:
    """One of a kind that has nothing to do."""
    monkeypatch.setattr(kind, "run", lambda *_: "done")
    return object.__new__(kind)


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


@pytest.mark.parametrize("kind", [DraftClip, FindUp])
def test_drafting_and_the_search_for_up_begin_while_loops_are_compiled_and_tracking_waits(
    desk: Desk, monkeypatch: pytest.MonkeyPatch, kind: type[Job]
) -> None:
    desk._handle(Order(1, job(kind, monkeypatch)))
    assert desk.next_report() == Finished(1, "done")
    desk._handle(Order(2, job(Track, monkeypatch)))
    assert not desk.said.wait(0.05)
    desk.compiled.set()
    assert desk.next_report() == Finished(2, "done")


def test_a_job_that_waits_for_them_can_be_cancelled(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk._handle(Order(1, job(Track, monkeypatch)))
    assert not desk.said.wait(0.05)
    desk._handle(Cancel(1))
    assert desk.next_report() == Finished(1, cancelled=True)
    desk._handle(Order(2, job(FindUp, monkeypatch)))
    assert desk.next_report() == Finished(2, "done")
