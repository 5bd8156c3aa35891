"""While a hand drags, tracking stands back at its next pass, and goes on when the hand lets go."""

from __future__ import annotations

from threading import Thread

import pytest

from keypose.app.jobs import worker
from keypose.app.jobs.job import Context, Progress, Report, Warming
from keypose.app.jobs.progress import Shares
from keypose.app.jobs.track import TrackReporter
from keypose.app.jobs.worker import Cancel, Pause, Worker
from keypose.tracker.body.trajectory import Pass
from keypose.tracker.tracking.pool import PassFinished, never
from keypose.tracker.tracking.result import SegmentResult
from tests.tracker import session_cases as cases


@pytest.fixture
def reported(monkeypatch: pytest.MonkeyPatch) -> list[Report]:
    received: list[Report] = []
    monkeypatch.setattr(worker, "send", lambda _, report: received.append(report))
    return received


def _report_a_pass(desk: Worker) -> None:
    context = Context(1, None, None, never, desk._send, desk._hold)  # type: ignore[arg-type]
    found = SegmentResult.on_the_way(Pass("pass", cases.segment(0, 4).trajectory, 2.0))
    reporter = TrackReporter(context, Shares.of([(0, 4, "")], ["full"], 0.0))
    reporter.report(PassFinished(0, 0, 6, found))


@pytest.mark.parametrize("release", [Pause(False), Cancel(1)])
def test_a_pass_waits_for_the_hand_and_nothing_else_does(
    reported: list[Report], monkeypatch: pytest.MonkeyPatch, release: Pause | Cancel
) -> None:
    monkeypatch.setattr(worker, "LONGEST_PAUSE_S", 60)
    desk = Worker(None)  # type: ignore[arg-type]
    desk._handle(Pause(True))
    waiting = Thread(target=_report_a_pass, args=(desk,), daemon=True)
    waiting.start()
    waiting.join(0.1)
    desk._send(Warming(""))
    assert reported == [Warming("")]
    assert waiting.is_alive()
    desk._handle(release)
    waiting.join()
    assert isinstance(reported[1], Progress)


def test_a_hand_that_never_lets_go_slows_tracking_and_does_not_stop_it(
    reported: list[Report], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worker, "LONGEST_PAUSE_S", 0.01)
    desk = Worker(None)  # type: ignore[arg-type]
    desk._handle(Pause(True))
    for _ in range(3):
        _report_a_pass(desk)
    assert len(reported) == 3
