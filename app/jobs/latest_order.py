"""Where a worker's orders lie: one is at work, one may wait, and the newest counts."""

from __future__ import annotations

from threading import Condition, Event

from keypose.app.jobs.messages import AnyOrder


class LatestOrder:
    """For one thread that puts orders down and one that takes them up."""

    def __init__(self) -> None:
        self._changed = Condition()
        self._waiting: AnyOrder | None = None
        self._at_work: tuple[int, Event] | None = None

    def put(self, order: AnyOrder) -> AnyOrder | None:
        """Put down a new order, which cancels the one at work; the order it takes the place of."""
        with self._changed:
            replaced, self._waiting = self._waiting, order
            if self._at_work is not None:
                self._at_work[1].set()
            self._changed.notify()
            return replaced

    def cancel(self, job: int) -> AnyOrder | None:
        """Cancel a job, if it is here; its order, where work on it had not begun."""
        with self._changed:
            waiting = self._waiting
            if waiting is not None and waiting.job == job:
                self._waiting = None
                return waiting
            if self._at_work is not None and self._at_work[0] == job:
                self._at_work[1].set()
            return None

    def take(self) -> tuple[AnyOrder, Event]:
        """Wait for an order and take it up; the event is set when it is to be left."""
        with self._changed:
            self._at_work = None
            self._changed.wait_for(lambda: self._waiting is not None)
            assert self._waiting is not None
            order, self._waiting = self._waiting, None
            self._at_work = (order.job, Event())
            return order, self._at_work[1]
