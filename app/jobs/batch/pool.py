"""Run the workers of a batch: a pool of processes on this computer.

The loops are loaded once and stay. It ends with the process at the other end.

A pool takes tasks by number and reports their outcomes; it never raises when a single task fails
or a single worker dies.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import connection as connections
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from threading import Event, Lock, Thread
from typing import Protocol, TypeAlias

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


PATIENCE_S = 2.0
"""For a process that was asked to end; then it is killed."""


@dataclass(frozen=True)
class WorkerDied:
    """The worker of a task is gone before the task was done."""

    words: str


News: TypeAlias = tuple[int, Step | Summary | WorkerDied]
"""The number of a task and what became of it."""


class WorkerPool(Protocol):
    """Workers. `free_slots`: how many more tasks can be begun now."""

    def free_slots(self) -> int: ...

    def submit(self, number: int, task: Task) -> None: ...

    def wait(self, seconds: float) -> Sequence[News]:
        """What has happened, as soon as something has, at most so long."""

    def stop(self) -> None:
        """Let what is at work end soon; a summary still comes of each."""

    def close(self) -> None:
        """End all, whatever they are doing."""


class _Worker:
    """One process, started when it is first needed; `number` is that of its task."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self.line, theirs = context.Pipe()
        self.process: BaseProcess = context.Process(
            target=serve, args=(theirs,), name="keypose-batch", daemon=True
        )
        with _without_ctrl_c():  # until the child ignores it by itself
            self.process.start()
        theirs.close()  # so that its end is the end of the line
        self.number: int | None = None

    def end(self) -> None:
        self.line.close()
        self.process.join(PATIENCE_S)
        if self.process.is_alive():
            self.process.kill()
            self.process.join()


@contextmanager
def _without_ctrl_c() -> Iterator[None]:
    """Within, Ctrl+C waits, and reaches no process that is started; where the system knows that."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class LocalPool:
    """Up to so many processes of this computer."""

    def __init__(self, processes: int) -> None:
        self._most = processes
        self._workers: list[_Worker] = []

    @property
    def pids(self) -> dict[int, int]:
        """The process of every task at work."""
        return {
            worker.number: worker.process.pid
            for worker in self._workers
            if worker.number is not None and worker.process.pid is not None
        }

    def free_slots(self) -> int:
        return self._most - sum(worker.number is not None for worker in self._workers)

    def submit(self, number: int, task: Task) -> None:
        worker = next((w for w in self._workers if w.number is None), None)
        if worker is None:
            worker = _Worker()
            self._workers.append(worker)
        worker.number = number
        with suppress(OSError):  # it has just died, which the next wait reports
            worker.line.send(task)

    def wait(self, seconds: float) -> list[News]:
        lines = {worker.line: worker for worker in self._workers}
        news = []
        for line in connections.wait(list(lines), seconds):
            assert isinstance(line, Connection)
            news += self._receive(lines[line])
        return news

    def stop(self) -> None:
        for worker in self._workers:
            with suppress(OSError):
                worker.line.send(None)

    def close(self) -> None:
        workers, self._workers = self._workers, []
        for worker in workers:
            worker.end()

    def _receive(self, worker: _Worker) -> list[News]:
        number = worker.number
        try:
            answer = worker.line.recv()
        except (EOFError, OSError):
            self._workers.remove(worker)
            worker.end()
            return [] if number is None else [(number, WorkerDied(_death_message(worker.process)))]
        if isinstance(answer, Summary):
            worker.number = None
        return [] if number is None else [(number, answer)]


def _death_message(process: BaseProcess) -> str:
    code = process.exitcode or 0
    ended = f"killed by signal {-code}" if code < 0 else f"ended with code {code}"
    return f"Its worker process was {ended}" if code < 0 else f"Its worker process {ended}"
