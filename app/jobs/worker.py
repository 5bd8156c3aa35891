"""The worker process: takes orders, the newest only, and keeps everything ready between them."""

from __future__ import annotations

import os
import signal
import traceback
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from threading import Condition, Lock, Thread
from typing import TYPE_CHECKING

from app.jobs.reports import Cancel, JobFinished, Order, Ready, Report, Warming
from app.jobs.wire import receive, send

if TYPE_CHECKING:
    from app.jobs.work import Job

THREADS = 2
"""Segments side by side. More would gain little and take the page's share of a small computer."""


def work(connection: Connection, niceness: int) -> None:
    """The life of the process. It ends with the process at the other end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C is for the server, which then ends us
    if hasattr(os, "nice"):
        os.nice(niceness)
    Worker(connection).serve()


class Worker:
    """Receives on the main thread, works on another, and on THREADS more beneath that one."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._sending = Lock()
        self._changed = Condition()
        self._next: Order | None = None
        self._job: Job | None = None

    def serve(self) -> None:
        """Until there is nobody left to serve."""
        Thread(target=self._work, daemon=True).start()
        try:
            while True:
                self._heed(receive(self._connection))
        except (EOFError, OSError):
            os._exit(0)  # whatever is at work is of no use to anyone now

    def _heed(self, message: Order | Cancel) -> None:
        """A new order replaces the one that waits and ends the one at work."""
        with self._changed:
            waiting = self._next
            if isinstance(message, Order):
                self._next = message
            elif waiting is not None and waiting.job == message.job:
                self._next = None
            else:
                waiting = None
            if self._job is not None and (
                isinstance(message, Order) or self._job.order.job == message.job
            ):
                self._job.cancel()
            self._changed.notify()
        if waiting is not None:
            self._tell(JobFinished(waiting.job, cancelled=True))

    def _work(self) -> None:
        try:
            self._warm()
            from app.jobs.bench import Bench

            bench = Bench()
            with ThreadPoolExecutor(THREADS) as threads:
                while True:
                    self._take().run(bench, threads)
                    with self._changed:
                        self._job = None
        except BaseException:  # noqa: BLE001 — the other end notices that nobody is here
            traceback.print_exc()
            os._exit(1)

    def _warm(self) -> None:
        """The loops are compiled, or loaded, before anybody waits for them."""
        from tracker.warm import is_warm, warm

        once = "Preparing the tracker for this computer, once: about a minute."
        self._tell(Warming("Getting the tracker ready." if is_warm() else once))
        warm()
        self._tell(Ready())

    def _take(self) -> Job:
        from app.jobs.work import Job

        with self._changed:
            self._changed.wait_for(lambda: self._next is not None)
            assert self._next is not None
            self._job, self._next = Job(self._next, self._tell), None
            return self._job

    def _tell(self, report: Report) -> None:
        with self._sending:
            send(self._connection, report)
