"""A worker process of a batch: sessions come in one by one, steps and summaries go out.

The loops are loaded once and stay. It ends with the process at the other end.
"""

from __future__ import annotations

import os
import signal
from dataclasses import dataclass
from multiprocessing.connection import Connection
from threading import Event, Lock, Thread
from typing import TypeAlias

from keypose.app.jobs.batch.task import Step, Summary, Task

Message: TypeAlias = Task | None
"""None: leave what is at work within one pass."""
Answer: TypeAlias = Step | Summary


def serve(connection: Connection) -> None:
    """The life of the process: the main thread listens and so notices a closed connection."""
    for number in (signal.SIGINT, signal.SIGTERM):  # for the process that gives orders
        signal.signal(number, signal.SIG_IGN)
    runner = _TaskRunner(connection)
    try:
        while True:
            runner.handle(connection.recv())
    except (EOFError, OSError):
        os._exit(0)  # what is at work is started again by the next worker


@dataclass(eq=False)
class _TaskRunner:
    """The thread that works. Every session has an event of its own that stops it."""

    connection: Connection
    _stop: Event | None = None

    def __post_init__(self) -> None:
        self._sending = Lock()

    def handle(self, message: Message) -> None:
        if message is None:
            if self._stop is not None:
                self._stop.set()
            return
        self._stop = Event()
        Thread(target=self._work, args=(message, self._stop), daemon=True).start()

    def _work(self, task: Task, stop: Event) -> None:
        from keypose.app.jobs.batch.run_one import (
            run_task,  # heavy: the process answers before it is loaded
        )

        self._send(run_task(task, self._send, stop))

    def _send(self, answer: Answer) -> None:
        with self._sending:
            self.connection.send(answer)
