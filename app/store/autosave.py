"""Saving by itself: each change soon, the newest state always, one write at a time."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

from keypose.app.jobs.failure import failure_message
from keypose.app.store.state import Saved

SECONDS_BETWEEN_TRIES = 3.0
"""To write what could not be written: the disk may have room again, or the folder be back."""

Write = Callable[[], None]
"""Writes one state to disk; runs in a thread."""


class Saver:
    """Writes what it was given last. `report` receives the state of saving, on the loop.

    What could not be written is tried again every few seconds until it could.
    """

    def __init__(self, report: Callable[[Saved], None]) -> None:
        self._report = report
        self._next: Write | None = None
        self._failed: tuple[Write, str] | None = None
        self._task: asyncio.Task[None] | None = None
        self._later: asyncio.TimerHandle | None = None
        self._at_s = 0.0

    def save(self, write: Write) -> None:
        """Write this soon; what still waits to be written is replaced."""
        failing = self._failed is not None
        self._begin(write)
        if not failing:  # otherwise it stays reported as unsaved until it is written
            self._report(Saved("saving", self._at_s))

    def retry(self) -> None:
        """Try once more what could not be written."""
        if self._try_again():
            self._report(Saved("saving", self._at_s))

    def _try_again(self) -> bool:
        """Whether there was something to try, and nothing newer is being written."""
        if self._failed is None or self._next is not None or not self.is_idle:
            return False
        self._begin(self._failed[0])
        return True

    def _begin(self, write: Write) -> None:
        self._next = write
        self._stop_waiting()
        if self.is_idle:
            self._task = asyncio.ensure_future(self._work())

    def _stop_waiting(self) -> None:
        if self._later is not None:
            self._later.cancel()
            self._later = None

    @property
    def problem(self) -> str | None:
        """Why the newest state is not on disk, in one sentence; None unless writing it failed."""
        return None if self._failed is None else self._failed[1]

    def give_up(self) -> None:
        """What could not be written is not to be tried again."""
        self._failed = None
        self._stop_waiting()

    @property
    def is_idle(self) -> bool:
        """Whether nothing is being written."""
        return self._task is None or self._task.done()

    async def wait(self) -> None:
        """Wait until nothing is left to write."""
        while self._task is not None and not self.is_idle:
            await asyncio.shield(self._task)

    async def _work(self) -> None:
        while self._next is not None:
            write, self._next = self._next, None
            try:
                await asyncio.to_thread(write)
            except Exception as error:  # noqa: BLE001 — whatever it is, a person must know
                if self._next is None:
                    self._fail(write, error)
                    return
            else:
                self._at_s, self._failed = time.time(), None
        self._report(Saved("saved", self._at_s))

    def _fail(self, write: Write, error: Exception) -> None:
        words = failure_message(error)
        self._failed = write, words
        self._later = asyncio.get_running_loop().call_later(SECONDS_BETWEEN_TRIES, self._try_again)
        self._report(Saved("failed", self._at_s, words))
