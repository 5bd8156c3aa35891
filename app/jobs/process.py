"""One worker process as the server sees it: messages go in, messages come out, and it may die."""

from __future__ import annotations

import multiprocessing
import queue
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.process import BaseProcess
from threading import Thread
from typing import Any

from keypose.app.jobs.wire import receive, send
from keypose.app.jobs.worker import work

NICENESS = 5
"""The page's server goes first, yet beside other busy programs a track still gets its share."""
PATIENCE_S = 0.3
"""For a process that was asked to end; then it is ended."""


def end_process(process: BaseProcess) -> None:
    """End it, whatever it is doing; at most a second."""
    for end in (process.terminate, process.kill):
        end()
        process.join(PATIENCE_S)
        if not process.is_alive():
            break


class WorkerProcess:
    """A worker that is being started. Nothing here waits for it.

    on_message: called with this and every message, on_end: called with this, once, when the process
        is gone; both on a thread of their own.
    """

    def __init__(
        self,
        on_message: Callable[[WorkerProcess, Any], None],
        on_end: Callable[[WorkerProcess], None],
    ) -> None:
        context = multiprocessing.get_context("spawn")
        self._ours, theirs = context.Pipe()
        self._process = context.Process(
            target=work, args=(theirs, NICENESS), name="keypose-tracking", daemon=True
        )
        self._process.start()
        theirs.close()  # so that its end is the end of the connection
        self._outbox: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._on_message, self._on_end = on_message, on_end
        Thread(target=self._send, name="orders", daemon=True).start()
        Thread(target=self._receive, name="reports", daemon=True).start()

    @property
    def pid(self) -> int | None:
        return self._process.pid

    def send(self, message: object) -> None:
        """Hand over a message; it is lost if the worker dies first."""
        self._outbox.put(message)

    def stop(self) -> None:
        """End the process, whatever it is doing; at most a second."""
        self._outbox.put(None)
        end_process(self._process)

    def _send(self) -> None:
        with suppress(OSError):
            while (message := self._outbox.get()) is not None:
                send(self._ours, message)

    def _receive(self) -> None:
        with suppress(EOFError, OSError):
            while True:
                self._on_message(self, receive(self._ours))
        self._on_end(self)
