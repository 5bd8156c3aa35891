"""Which job is at work, and who is asked for the next one."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any, TypeAlias

from keypose.app.jobs.job import Ended, Failed, Finished, Job, Progress, Report, Warming
from keypose.app.jobs.job_runner import JobRunner
from keypose.app.state.job_state import JobState

Client: TypeAlias = Callable[[], None]
"""Begins what waits of its own, if anything does."""


class Priority(IntEnum):
    """Who waits for it. What is at work is left for whatever has a higher one."""

    FOLLOWS = 0
    """Nobody: it follows from what was done, and begins where nothing is at work."""
    HAND = 1
    """A hand that drags: the motion beside it, for its newest pose."""
    PERSON = 2
    """Whoever pressed a button, or edits with Live: the newest goes before the one at work."""


def _take_nothing(_: Any) -> bool:
    return False


def _end_as_before(_: Ended) -> None:
    """Nobody waits for the end."""


def _ignore() -> None:
    """It is no loss."""


@dataclass(frozen=True, eq=False)
class Item:
    """A job, and who is told of it.

    words: shown until it reports some.  is_shown: whether the page shows that it is at work.
    is_held: whether it stays at work, once it has ended, until it is released.
    take: receives what there is by now; whether that is to be saved.
    end: receives its end, unless it was left; what is shown then, None as before it.
    left: it was left for something else before its end.
    """

    job: Job
    priority: Priority
    words: str = ""
    is_shown: bool = True
    is_held: bool = False
    take: Callable[[Any], bool] = _take_nothing
    end: Callable[[Ended], JobState | None] = _end_as_before
    left: Callable[[], None] = _ignore


class WorkQueue:
    """One item at a time. `notify` is called after each report of what is shown, and whenever
    another item is at work; its flag: something is to be saved.

    What waits is kept by whoever it is of, and is made a job when its turn comes, of the state as
    it is then: where nothing is at work, the clients are asked in order until one begins something.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, notify: Callable[[bool], None]) -> None:
        self._notify = notify
        self._jobs = JobRunner(self._on_report, loop)
        self._items: dict[int, Item] = {}
        """Those of this session whose jobs have not ended, by the numbers of these."""
        self._number = 0
        self._before = JobState()
        self._clients: tuple[Client, ...] = ()
        self.at_work: Item | None = None
        self.has_begun = False
        """Whether the worker has reported anything of what is at work."""
        self.state = JobState()
        """What the page shows of it."""

    def serve(self, *clients: Client) -> None:
        """Ask these, from now on, where nothing is at work."""
        self._clients = clients

    def is_free_for(self, priority: Priority) -> bool:
        """Whether work of a priority would begin."""
        if self.at_work is None or priority == Priority.PERSON:
            return True
        return priority > self.at_work.priority

    @property
    def is_held(self) -> bool:
        """Whether what is at work stays until it is released."""
        return self.at_work is not None and self.at_work.is_held

    def begin(self, item: Item) -> bool:
        """Begin, if it may be begun now; what is at work is left for it."""
        if not self.is_free_for(item.priority):
            return False
        if self.at_work is not None:
            self.at_work.left()
        else:
            self._before = self.state
        self._number, self.at_work, self.has_begun = self._jobs.start(item.job), item, False
        self._items[self._number] = item
        if item.is_shown:
            self.state = JobState("running", item.job.title, item.words, kind=item.job.kind)
            self._notify(False)
        elif self.state.state == "running":
            self._show(self._before)
        return True

    def release(self) -> None:
        """What is at work has been taken over, or is dropped: something else may begin."""
        if self._number in self._items:
            self._jobs.cancel()
        self._number, self.at_work = 0, None
        self._show(JobState())
        self.go_on()

    def go_on(self) -> None:
        """Begin what waits, where nothing is at work."""
        for client in self._clients:
            if self.at_work is not None:
                return
            client()

    def show_waiting(self) -> None:
        """What waits for what is at work is something else now, or nothing."""
        self._notify(False)

    def pause(self, on: bool) -> None:
        """Pause while something is dragged."""
        self._jobs.pause(on)

    def cancel(self) -> None:
        """Stop within a pass; what is finished stays."""
        self._jobs.cancel()

    def closed(self) -> None:
        """No session is open any more; what a job still reports does not count."""
        self._jobs.cancel()
        self._items, self._number, self.at_work, self.state = {}, 0, None, JobState()

    def stop(self) -> None:
        """End the worker."""
        self._jobs.close()

    # --- reports of the worker

    def _on_report(self, report: Report) -> None:
        """What is there by now counts whichever item of this session it is of; the rest of what is
        at work alone."""
        if report.job is None:
            self._notify(False)
            return
        item = self._items.get(report.job)
        if item is None:
            return
        is_own = report.job == self._number
        if isinstance(report, Finished | Failed):
            del self._items[report.job]
            if is_own:
                self._on_end(report, item)
            return
        is_to_be_saved = isinstance(report, Progress) and item.take(report.partial)
        if is_own:
            self._on_way(report, item)
        if item.is_shown:
            self._notify(is_to_be_saved)

    def _on_way(self, report: Progress | Warming, item: Item) -> None:
        self.has_begun = self.has_begun or isinstance(report, Progress)
        if not item.is_shown:
            return
        if isinstance(report, Progress):
            self.state = replace(
                self.state,
                words=report.words or self.state.words,
                percent=100 * report.share,
                seconds_left=report.seconds_left,
            )
        elif report.words or item.job.kind != "track":
            self.state = replace(self.state, words=report.words)

    def _on_end(self, end: Ended, item: Item) -> None:
        if item.is_held:
            item.end(end)
            return
        self._number, self.at_work = 0, None
        self._show(item.end(end) or self._before)
        self.go_on()

    def _show(self, state: JobState) -> None:
        self.state = state
        self._notify(False)
