"""Saving by itself: each change soon, the newest state always, one write at a time."""

from __future__ import annotations

import asyncio
import time
import traceback
from collections.abc import Callable

from app.outlook import Saved
from tracker.errors import KeyposeError

Write = Callable[[], None]
"""Writes one state to disk; runs in a thread."""


class Saver:
    """Writes what it was given last. `report` is told how that goes, on the loop."""

    def __init__(self, report: Callable[[Saved], None]) -> None:
        self._report = report
        self._next: Write | None = None
        self._failed: tuple[Write, str] | None = None
        self._task: asyncio.Task[None] | None = None
        self._at_s = 0.0

    def save(self, write: Write) -> None:
        """Write this soon; what still waits to be written is replaced."""
        self._next, self._failed = write, None
        if self.is_settled:
            self._report(Saved("saving", self._at_s))
            self._task = asyncio.ensure_future(self._work())

    def again(self) -> None:
        """Try once more what could not be written."""
        if self._failed is not None:
            self.save(self._failed[0])

    @property
    def problem(self) -> str | None:
        """Why the newest state is not on disk, in one sentence; None unless writing it failed."""
        return None if self._failed is None else self._failed[1]

    def give_up(self) -> None:
        """What could not be written is not to be tried again."""
        self._failed = None

    @property
    def is_settled(self) -> bool:
        """Whether nothing is being written."""
        return self._task is None or self._task.done()

    async def settled(self) -> None:
        """Wait until nothing is left to write."""
        while self._task is not None and not self.is_settled:
            await asyncio.shield(self._task)

    async def _work(self) -> None:
        while self._next is not None:
            write, self._next = self._next, None
            try:
                await asyncio.to_thread(write)
            except Exception as error:  # noqa: BLE001 — whatever it is, a person must know
                if self._next is None:
                    self._failed = write, _words(error)
                    self._report(Saved("failed", self._at_s, _words(error)))
                    return
            else:
                self._at_s = time.time()
        self._report(Saved("saved", self._at_s))


def _words(error: Exception) -> str:
    """One sentence for the person; of a fault of Keypose itself, all of it for the log."""
    if isinstance(error, KeyposeError):
        return str(error)
    traceback.print_exception(error)
    return f"Saving met a fault of Keypose itself ({type(error).__name__}): try again."
