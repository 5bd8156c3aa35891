"""Handing out a batch: what befalls one session stays with that session."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from threading import Event

from keypose.app.jobs.batch.pool import News, WorkerDied
from keypose.app.jobs.batch.scheduler import (
    TaskEvent,
    TaskFinished,
    TaskProgressed,
    TaskStarted,
    run,
)
from keypose.app.jobs.batch.task import Step, Summary, Task


class Script:
    """A pool whose every task meets what the script says, one thing after the other."""

    def __init__(
        self, processes: int, script: dict[int, list[Step | Summary | WorkerDied]]
    ) -> None:
        self._processes = processes
        self._script = script
        self.at_work: list[int] = []
        self.most_together: set[frozenset[int]] = set()
        self.stopped = False

    def free_slots(self) -> int:
        return self._processes - len(self.at_work)

    def submit(self, number: int, task: Task) -> None:
        self.at_work.append(number)
        self.most_together.add(frozenset(self.at_work))

    def wait(self, seconds: float) -> Sequence[News]:
        number = self.at_work[0]
        what = self._script[number].pop(0)
        if not isinstance(what, Step):
            self.at_work.remove(number)
        return [(number, what)]

    def stop(self) -> None:
        self.stopped = True

    def close(self) -> None:
        pass


def tasks(*folders: str) -> list[Task]:
    return [Task(Path(f"/{folder}/{i}.json")) for i, folder in enumerate(folders)]


def done(number: int) -> Summary:
    return Summary(f"{number}", "tracked")


def ended(reported: list[TaskEvent]) -> dict[int, Summary]:
    return {event.number: event.summary for event in reported if isinstance(event, TaskFinished)}


def test_a_session_whose_worker_dies_is_tried_once_more() -> None:
    script = Script(2, {0: [Step(50), WorkerDied("Gone"), done(0)], 1: [done(1)]})
    reported = list(run(tasks("a", "b"), script, Event()))
    assert [e.again for e in reported if isinstance(e, TaskStarted) and e.number == 0] == [
        False,
        True,
    ]
    assert [e.step.percent for e in reported if isinstance(e, TaskProgressed)] == [50]
    assert ended(reported) == {0: done(0), 1: done(1)}


def test_a_session_that_takes_two_workers_with_it_fails_and_the_others_are_done() -> None:
    script = Script(1, {0: [WorkerDied("Gone"), WorkerDied("Gone")], 1: [done(1)]})
    found = ended(list(run(tasks("a", "b"), script, Event())))
    assert (found[0].state, found[0].words) == ("failed", "Gone, twice.")
    assert found[1].state == "tracked"


def test_two_sessions_of_one_folder_are_never_at_work_together() -> None:
    script = Script(3, {i: [done(i)] for i in range(5)})
    reported = list(run(tasks("a", "a", "b", "a", "c"), script, Event()))
    assert len(ended(reported)) == 5
    assert max(len(together) for together in script.most_together) == 3
    assert not any(len(together & {0, 1, 3}) > 1 for together in script.most_together)


def test_once_stopped_nothing_is_begun_and_what_is_at_work_may_end() -> None:
    stop = Event()
    halfway = Summary("0", "interrupted")
    script = Script(1, {0: [Step(10), halfway], 1: [done(1)]})
    reported = []
    for event in run(tasks("a", "b"), script, stop):
        reported.append(event)
        if isinstance(event, TaskProgressed):
            stop.set()
    assert script.stopped
    assert ended(reported) == {0: halfway}


def test_a_worker_that_dies_while_all_is_stopped_is_not_replaced_and_no_failure() -> None:
    stop = Event()
    script = Script(1, {0: [Step(10), WorkerDied("Gone")]})
    reported = []
    for event in run(tasks("a"), script, stop):
        reported.append(event)
        if isinstance(event, TaskProgressed):
            stop.set()
    assert ended(reported)[0].state == "interrupted"
