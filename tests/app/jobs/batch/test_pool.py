"""Processes of this computer: one that is killed costs its session's time, and nothing else."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from threading import Event

import pytest

from keypose.app.jobs.batch.pool import LocalPool
from keypose.app.jobs.batch.run_one import run_task
from keypose.app.jobs.batch.scheduler import (
    TaskEvent,
    TaskFinished,
    TaskProgressed,
    TaskStarted,
    run,
)
from keypose.app.jobs.batch.task import Summary, Task
from tests.app.jobs.batch.batch_cases import bytes_of, write_sessions


@pytest.fixture
def pool() -> Iterator[LocalPool]:
    hired = LocalPool(2)
    yield hired
    hired.close()


def kill(pool: LocalPool, number: int) -> None:
    os.kill(pool.pids[number], signal.SIGKILL)


def test_of_several_processes_one_is_killed_and_all_is_as_one_alone_would_do_it(
    tmp_path: Path, pool: LocalPool
) -> None:
    names = ("a", "b", "c", "d")
    paths, alone = (write_sessions(tmp_path / where, *names) for where in ("many", "alone"))
    reported: list[TaskEvent] = []
    for event in run([Task(path) for path in paths], pool, Event()):
        reported.append(event)
        if event == TaskStarted(1, again=False):
            kill(pool, 1)
    again = [event.number for event in reported if isinstance(event, TaskStarted) and event.again]
    assert again == [1]
    states = {
        event.number: event.summary.state for event in reported if isinstance(event, TaskFinished)
    }
    assert states == dict.fromkeys(range(4), "tracked")
    assert any(isinstance(event, TaskProgressed) for event in reported)
    for path in alone:
        run_task(Task(path), lambda step: None, Event())
    assert bytes_of(paths) == bytes_of(alone)


def test_a_session_that_is_killed_every_time_fails_by_itself(
    tmp_path: Path, pool: LocalPool
) -> None:
    paths = write_sessions(tmp_path, "a", "b")
    ended: dict[int, Summary] = {}
    for event in run([Task(path) for path in paths], pool, Event()):
        if isinstance(event, TaskStarted) and event.number == 0:
            kill(pool, 0)
        if isinstance(event, TaskFinished):
            ended[event.number] = event.summary
    assert ended[0].words == "Its worker process was killed by signal 9, twice."
    assert ended[1].state == "tracked"


def test_closed_it_leaves_no_process_behind(tmp_path: Path, pool: LocalPool) -> None:
    pool.submit(0, Task(write_sessions(tmp_path, "a")[0]))
    pid = pool.pids[0]
    pool.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
