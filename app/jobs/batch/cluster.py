"""The same work on a Dask cluster: one task for each session, a small summary back.

The workers read and write the sessions themselves, so all computers see the files under the same
paths. A session whose worker dies is given to another one by the scheduler.
"""

from __future__ import annotations

import asyncio
import time
from contextlib import suppress
from threading import Event
from typing import TYPE_CHECKING, Any

from keypose.app.jobs.batch.pool import News, WorkerDied
from keypose.app.jobs.batch.task import Step, Summary, Task
from keypose.tracker.errors import KeyposeError

if TYPE_CHECKING:
    from distributed import Client, Future

CONNECT_S = 5.0
"""Seconds until a scheduler that does not answer is given up."""
LOOK_FOR_WORKERS_S = 2.0
"""Seconds between counts of the workers."""
LONGEST_REASON = 200
"""Characters of a reason that somebody else gives."""


def do_remotely(task: Task) -> Summary:
    """What a worker of the cluster runs."""
    from keypose.app.jobs.batch.run_one import run_task

    return run_task(task, _ignore_step, Event())


def _ignore_step(step: Step) -> None:
    """Steps stay where they are: only the summary travels."""


class ClusterPool:
    """The workers of a cluster, however many there are just now."""

    def __init__(self, address: str) -> None:
        self._client = _client(address)
        self._address = address
        self._futures: dict[int, Future[Any]] = {}
        self._threads = 0
        self._counted = float("-inf")

    def free_slots(self) -> int:
        """One task for each thread of the cluster, so that what is not begun can be left."""
        if time.monotonic() - self._counted > LOOK_FOR_WORKERS_S:
            self._counted = time.monotonic()
            self._threads = sum(self._ask("nthreads").values())
        return self._threads - len(self._futures)

    def submit(self, number: int, task: Task) -> None:
        self._futures[number] = self._ask("submit", do_remotely, task, pure=False)

    def wait(self, seconds: float) -> list[News]:
        """Looks every so often: what happens may also be that the scheduler is gone."""
        until = time.monotonic() + seconds
        while True:
            done = [n for n, future in self._futures.items() if future.status != "pending"]
            if done or time.monotonic() >= until:
                return [(number, self._ended(self._futures.pop(number))) for number in done]
            self._require_scheduler()
            time.sleep(0.02)

    def stop(self) -> None:
        """Nothing can be said to a task that runs: it is waited for."""

    def close(self) -> None:
        with suppress(Exception):
            self._client.cancel(list(self._futures.values()))
        with suppress(Exception):
            self._client.close(timeout=2)

    def _ended(self, future: Future[Any]) -> Summary | WorkerDied:
        if future.status == "finished":
            summary: Summary = future.result()
            return summary
        if future.status == "error":
            return WorkerDied(_failure_message(future.exception()))
        self._require_scheduler()
        return WorkerDied("The cluster lost it")

    def _ask(self, method: str, *arguments: Any, **more: Any) -> Any:
        self._require_scheduler()
        try:
            return getattr(self._client, method)(*arguments, **more)
        except (OSError, RuntimeError, ValueError) as error:
            raise self._scheduler_gone() from error

    def _require_scheduler(self) -> None:
        if self._client.status != "running":
            raise self._scheduler_gone()

    def _scheduler_gone(self) -> KeyposeError:
        return KeyposeError(
            f"The scheduler at {self._address} is gone; what is finished is kept, and the same "
            "command goes on from there."
        )


def _failure_message(error: BaseException) -> str:
    """Why a task was not done: its workers died, or it could not even be begun."""
    if type(error).__name__ == "KilledWorker":
        return "Every worker that took it up was killed"
    first = next(iter(str(error).splitlines()), "")
    return f"The cluster could not do it ({type(error).__name__}: {first[:LONGEST_REASON]})"


def _client(address: str) -> Client:
    """A client of the scheduler; KeyposeError in one sentence when there is none."""
    try:
        from distributed import Client
    except ImportError:
        raise KeyposeError(
            "A cluster needs Dask: pip install 'keypose[cluster]', here and where the workers are."
        ) from None
    try:
        asyncio.run(asyncio.wait_for(_look_at(address), CONNECT_S))
        return Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError, TypeError, KeyError, EOFError) as error:
        why = str(error).splitlines()[0].rstrip(".") if str(error) else "nobody answers"
        raise KeyposeError(f"The scheduler {address!r} cannot be reached: {why}.") from None


async def _look_at(address: str) -> None:
    """Check that a scheduler answers there: a client that never reached one is slow to end."""
    from distributed.core import rpc

    async with rpc(address, timeout=CONNECT_S) as scheduler:
        identity = await scheduler.identity()
    if not str(identity["type"]).endswith("Scheduler"):
        raise ValueError(f"a {identity['type']} of Dask answers there")
