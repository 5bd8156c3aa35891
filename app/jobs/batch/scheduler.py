"""The course of a batch: every session is given to somebody, and once more if that one dies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event
from typing import TypeAlias

from app.jobs.batch.pool import Died, News, WorkerPool
from app.jobs.batch.task import Step, Summary, Task

TRIES = 2
LOOK_S = 0.2
"""Between two looks at whether to stop."""


@dataclass(frozen=True)
class Begun:
    """Work on a session begins, maybe once more."""

    number: int
    again: bool


@dataclass(frozen=True)
class Stepped:
    """A session is so far."""

    number: int
    step: Step


@dataclass(frozen=True)
class Ended:
    """All is known of a session."""

    number: int
    summary: Summary


Told: TypeAlias = Begun | Stepped | Ended


def run(tasks: Sequence[Task], pool: WorkerPool, stop: Event) -> Iterator[Told]:
    """Do all tasks and tell how it goes. `stop` set: nothing new is begun, and what is at work
    ends soon. The crew is the caller's to close."""
    course = _Scheduler(tasks)
    asked_to_stop = False
    while course.at_work or (course.waiting and not stop.is_set()):
        if stop.is_set() and not asked_to_stop:
            asked_to_stop = True
            pool.stop()
        while not stop.is_set() and pool.room() > 0 and (begun := course.next()) is not None:
            pool.give(begun.number, tasks[begun.number])
            yield begun
        for news in pool.wait(LOOK_S):
            yield from course.receive(news, stop)


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

    def next(self) -> Begun | None:
        """The next that can be begun, if one can."""
        busy = set(self.at_work.values())
        for number in self.waiting:
            folder = self.tasks[number].session.parent.resolve()
            if folder not in busy:
                self.waiting.remove(number)
                self.at_work[number] = folder
                self.tries[number] = self.tries.get(number, 0) + 1
                return Begun(number, again=self.tries[number] > 1)
        return None

    def receive(self, news: News, stop: Event) -> Iterator[Told]:
        number, what = news
        if isinstance(what, Step):
            yield Stepped(number, what)
            return
        self.at_work.pop(number, None)
        if isinstance(what, Summary):
            yield Ended(number, what)
        elif self.tries[number] < TRIES and not stop.is_set():
            self.waiting.insert(0, number)
        else:
            yield Ended(number, self._failed_summary(number, what))

    def _failed_summary(self, number: int, died: Died) -> Summary:
        twice = ", twice" if self.tries[number] > 1 else ""
        return Summary(str(self.tasks[number].session), "failed", f"{died.words}{twice}.")
