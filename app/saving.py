"""Saving by itself: each change soon, the newest state always, one write at a time."""

from __future__ import annotations

import asyncio
import time
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
        self._failed: Write | None = None
        self._task: asyncio.Task[None] | None = None
        self._at_s = 0.0

    def save(self, write: Write) -> None:
        """Write this soon; what still waits to be written is replaced."""
        self._next = write
        if self._task is None or self._task.done():
            self._report(Saved("saving", self._at_s))
            self._task = asyncio.ensure_future(self._work())

    def again(self) -> None:
        """Try once more what could not be written."""
        if self._failed is not None:
            self.save(self._failed)

    async def settled(self) -> None:
        """Wait until nothing is left to write."""
        while self._task is not None and not self._task.done():
            await asyncio.shield(self._task)

    async def _work(self) -> None:
        while self._next is not None:
            write, self._next = self._next, None
            try:
                await asyncio.to_thread(write)
            except KeyposeError as error:
                if self._next is None:
                    self._failed = write
                    self._report(Saved("failed", self._at_s, str(error)))
                    return
            else:
                self._failed = None
                self._at_s = time.time()
        self._report(Saved("saved", self._at_s))
