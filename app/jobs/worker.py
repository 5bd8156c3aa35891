"""Run orders in the worker process: the newest only, until it is told to end."""

from __future__ import annotations

import os
import signal
import traceback
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from threading import Condition, Event, Lock, Thread

from keypose.app.jobs.job import Context, Finished, Job, Report, Warming, do
from keypose.app.jobs.wire import receive, send
from keypose.tracker.errors import KeyposeError


@dataclass(frozen=True)
class Order:
    """A job, which is called by its number from then on."""

    job: int
    asked: Job


@dataclass(frozen=True)
class Cancel:
    """Leave a job within one pass."""

    job: int


@dataclass(frozen=True)
class Pause:
    """Pause during a drag (`on`), or continue: each pass waits, though not for long."""

    on: bool


class LatestOrder:
    """For one thread that puts orders down and one that takes them up."""

    def __init__(self) -> None:
        self._changed = Condition()
        self._waiting: Order | None = None
        self._at_work: tuple[int, Event] | None = None

    def put(self, order: Order) -> Order | None:
        """Put down a new order, which cancels the one at work; the order it takes the place of."""
        with self._changed:
            replaced, self._waiting = self._waiting, order
            if self._at_work is not None:
                self._at_work[1].set()
            self._changed.notify()
            return replaced

    def cancel(self, job: int) -> Order | None:
        """Cancel a job, if it is here; its order, where work on it had not begun."""
        with self._changed:
            waiting = self._waiting
            if waiting is not None and waiting.job == job:
                self._waiting = None
                return waiting
            if self._at_work is not None and self._at_work[0] == job:
                self._at_work[1].set()
            return None

    def take(self) -> tuple[Order, Event]:
        """Wait for an order and take it up; the event is set when it is to be left."""
        with self._changed:
            self._at_work = None
            self._changed.wait_for(lambda: self._waiting is not None)
            assert self._waiting is not None
            order, self._waiting = self._waiting, None
            self._at_work = (order.job, Event())
            return order, self._at_work[1]


THREADS = 2
"""Segments side by side. More would gain little and take the page's share of a small computer."""

POLL_S = 0.05
LONGEST_PAUSE_S = 1.0
"""A pass waits no longer than this for a drag: tracking slows down, it does not stop."""


def work(connection: Connection, niceness: int) -> None:
    """The life of the process. It ends with the process at the other end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C is for the server, which then ends us
    if hasattr(os, "nice"):
        os.nice(niceness)
    Worker(connection).serve()


class Worker:
    """Receives on the main thread, works on another, and on THREADS more beneath that one; gets the
    compiled loops ready beside, for which only some jobs wait."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._sending = Lock()
        self._latest = LatestOrder()
        self._may_go_on = Event()
        self._may_go_on.set()
        self._warmed = Event()

    def serve(self) -> None:
        """Until there is nobody left to serve."""
        for work in (self._warm, self._take_orders):
            Thread(target=self._do_or_end, args=(work,), daemon=True).start()
        try:
            while True:
                self._handle(receive(self._connection))
        except (EOFError, OSError):
            os._exit(0)  # whatever is at work is of no use to anyone now

    def _handle(self, message: Order | Cancel | Pause) -> None:
        if isinstance(message, Pause):
            (self._may_go_on.clear if message.on else self._may_go_on.set)()
            return
        self._may_go_on.set()
        if isinstance(message, Order):
            dropped = self._latest.put(message)
        else:
            dropped = self._latest.cancel(message.job)
        if dropped is not None:
            self._send(Finished(dropped.job, cancelled=True))

    def _do_or_end(self, work: Callable[[], None]) -> None:
        try:
            work()
        except BaseException:  # noqa: BLE001 — the other end notices that nobody is here
            traceback.print_exc()
            os._exit(1)

    def _warm(self) -> None:
        """The loops are compiled, or loaded, before anybody waits for them."""
        from keypose.tracker.warm import is_warm, preparing_words, warm_tracking

        _measure_drafting()
        self._send(Warming("Getting the tracker ready." if is_warm() else preparing_words()))
        warm_tracking(lambda percent: self._send(Warming(preparing_words(percent))))
        self._warmed.set()
        self._send(Warming(""))

    def _take_orders(self) -> None:
        from keypose.app.jobs import fit_pose  # noqa: F401 — loads what every fit stands on
        from keypose.app.jobs.worker_cache import WorkerCache

        worker_cache = WorkerCache()
        with ThreadPoolExecutor(THREADS) as threads:
            while True:
                order, cancelled = self._latest.take()
                if self._is_ready_for(order.asked, cancelled):
                    do(
                        order.asked,
                        Context(
                            order.job,
                            worker_cache,
                            threads,
                            cancelled.is_set,
                            self._send,
                            self._hold,
                        ),
                    )
                else:
                    self._send(Finished(order.job, cancelled=True))

    def _is_ready_for(self, job: Job, cancelled: Event) -> bool:
        """Wait until a job can be done; whether nobody cancelled it meanwhile."""
        while job.needs_loops and not cancelled.is_set():
            if self._warmed.wait(POLL_S):
                break
        return not cancelled.is_set()

    def _hold(self) -> None:
        self._may_go_on.wait(LONGEST_PAUSE_S)

    def _send(self, report: Report) -> None:
        with self._sending:
            send(self._connection, report)


def _measure_drafting() -> None:
    """Know how long a draft takes before one is asked for, by the network of new sessions."""
    from keypose.app.document.defaults import read_defaults
    from keypose.tracker.storage.pace import known_or_measured

    with suppress(KeyposeError):  # a draft will say what is wrong
        known_or_measured(read_defaults().track_settings.network_used)
