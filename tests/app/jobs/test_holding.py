"""While a hand drags, tracking stands back at its next pass, and goes on when the hand lets go."""

from __future__ import annotations

from threading import Thread

import pytest

from keypose.app.jobs import PassFinished, Ready, worker
from keypose.app.jobs.messages import Cancel, Pause, Report
from keypose.app.jobs.worker import Worker


@pytest.fixture
def reported(monkeypatch: pytest.MonkeyPatch) -> list[Report]:
    received: list[Report] = []
    monkeypatch.setattr(worker, "send", lambda _, report: received.append(report))
    return received


def _pass() -> PassFinished:
    return PassFinished.__new__(PassFinished)


def _reporting(desk: Worker, report: Report) -> Thread:
    thread = Thread(target=desk._send, args=(report,), daemon=True)
    thread.start()
    thread.join(0.1)
    return thread


@pytest.mark.parametrize("release", [Pause(False), Cancel(1)])
def test_a_pass_waits_for_the_hand_and_nothing_else_does(
    reported: list[Report], monkeypatch: pytest.MonkeyPatch, release: Pause | Cancel
) -> None:
    monkeypatch.setattr(worker, "LONGEST_PAUSE_S", 60)
    desk = Worker(None)  # type: ignore[arg-type]
    desk._handle(Pause(True))
    waiting, ready = _reporting(desk, found := _pass()), Ready()
    _reporting(desk, ready)
    assert reported == [ready]
    assert waiting.is_alive()
    desk._handle(release)
    waiting.join()
    assert reported[1] is found


def test_a_hand_that_never_lets_go_slows_tracking_and_does_not_stop_it(
    reported: list[Report], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worker, "LONGEST_PAUSE_S", 0.01)
    desk = Worker(None)  # type: ignore[arg-type]
    desk._handle(Pause(True))
    for _ in range(3):
        desk._send(_pass())
    assert len(reported) == 3
