"""The schedule of a batch: every session goes to a worker, and to another one if that dies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event
from typing import TypeAlias

from keypose.app.jobs.batch.pool import News, WorkerDied, WorkerPool
from keypose.app.jobs.batch.task import Step, Summary, Task

TRIES = 2
LOOK_S = 0.2
"""Between two looks at whether to stop."""


@dataclass(frozen=True)
class TaskStarted:
    """Work on a session begins, maybe once more."""

    number: int
    again: bool


@dataclass(frozen=True)
class TaskProgressed:
    """A session is so far."""

    number: int
    step: Step


@dataclass(frozen=True)
class TaskFinished:
    """All is known of a session."""

    number: int
    summary: Summary


TaskEvent: TypeAlias = TaskStarted | TaskProgressed | TaskFinished


def run(tasks: Sequence[Task], pool: WorkerPool, stop: Event) -> Iterator[TaskEvent]:
    """Do all tasks and report how it goes. `stop` set: nothing new is begun, and what is at work
    ends soon. The caller closes the pool."""
    scheduler = _Scheduler(tasks)
    asked_to_stop = False
    while scheduler.at_work or (scheduler.waiting and not stop.is_set()):
        if stop.is_set() and not asked_to_stop:
            asked_to_stop = True
            pool.stop()
        while not stop.is_set() and pool.free_slots() > 0 and (begun := scheduler.next()):
            pool.submit(begun.number, tasks[begun.number])
            yield begun
        for news in pool.wait(LOOK_S):
            yield from scheduler.receive(news, stop)


@dataclass(eq=False)
class _Scheduler:
    """What waits, what is at work, and how often each has been tried.

    Two sessions of one folder are never at work together: the lock is the folder's.
    """

    tasks: Sequence[Task]
    waiting: list[int] = field(init=False)
    at_work: dict[int, Path] = field(default_factory=dict)
    tries: dict[int, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.waiting = list(range(len(self.tasks)))

    def next(self) -> TaskStarted | None:
        """The next that can be begun, if one can."""
        busy = set(self.at_work.values())
        for number in self.waiting:
            folder = self.tasks[number].session.parent.resolve()
            if folder not in busy:
                self.waiting.remove(number)
                self.at_work[number] = folder
                self.tries[number] = self.tries.get(number, 0) + 1
                return TaskStarted(number, again=self.tries[number] > 1)
        return None

    def receive(self, news: News, stop: Event) -> Iterator[TaskEvent]:
        number, content = news
        if isinstance(content, Step):
            yield TaskProgressed(number, content)
            return
        self.at_work.pop(number, None)
        if isinstance(content, Summary):
            yield TaskFinished(number, content)
        elif self.tries[number] < TRIES and not stop.is_set():
            self.waiting.insert(0, number)
        else:
            yield TaskFinished(number, self._ended_summary(number, content, stop))

    def _ended_summary(self, number: int, died: WorkerDied, stop: Event) -> Summary:
        name = str(self.tasks[number].session)
        if stop.is_set():  # its worker was ended with the rest
            return Summary(name, "interrupted")
        twice = ", twice" if self.tries[number] > 1 else ""
        return Summary(name, "failed", f"{died.words}{twice}.")
