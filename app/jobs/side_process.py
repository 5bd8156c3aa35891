"""One piece of work in a process of its own, so that the page stays quick.

What is done there comes back as the newest state, as plain facts; a file of a stranger is read
within limits, so that one that is made to harm ends its own process and nothing else.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from threading import Event, Thread
from typing import Any, Literal, Protocol, TypeAlias

from keypose.app.jobs.process import end_process
from keypose.tracker.errors import KeyposeError
from keypose.tracker.plain import NotPlain, from_bytes, to_bytes

Progress: TypeAlias = Callable[[int, int], None]
"""Receives how many of how many are done."""

NICENESS = 3
"""After the page's server, before the tracker: somebody waits for it."""


class Work(Protocol):
    """What is to be done, as it is sent to the process."""

    @property
    def died(self) -> str:
        """What is said where the process ended without a word."""

    def do(self, progress: Progress) -> Any:
        """Do it; KeyposeError in one sentence where that is not possible."""


@dataclass(frozen=True)
class WorkState:
    """How far it is: `done` of `of`, 0 where that is not known yet. words: why it failed.
    result: what came of it."""

    state: Literal["running", "done", "failed", "cancelled"] = "running"
    done: int = 0
    of: int = 0
    words: str = ""
    result: Any = None


class SideProcess:
    """One work under way. `state` is the newest; it may be read from any thread."""

    def __init__(self, work: Work) -> None:
        self.state = WorkState()
        self._died = work.died
        self._over = Event()
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe(duplex=False)
        self._process = context.Process(
            target=_work, args=(work, theirs), name="keypose-side", daemon=True
        )
        self._process.start()
        theirs.close()  # so that its end is the end of the connection
        Thread(target=self._receive, args=(ours,), name="side", daemon=True).start()

    def wait(self) -> WorkState:
        """Until it is over; how it ended."""
        self._over.wait()
        return self.state

    def cancel(self) -> None:
        """End it, whatever it is doing; at most a second."""
        if self.state.state == "running":
            self.state = WorkState("cancelled")
        end_process(self._process)

    def _receive(self, reports: Connection) -> None:
        with reports, suppress(EOFError, OSError, NotPlain):
            while True:
                report = from_bytes(reports.recv_bytes())
                if not isinstance(report, WorkState):
                    break
                if self.state.state == "running":
                    self.state = report
        if self.state.state == "running":
            self.state = WorkState("failed", words=self._died)
        self._over.set()


def _end_with_parent() -> None:
    """End with the parent: what is made for somebody who is gone would fill the disk."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _work(work: Work, reports: Connection) -> None:
    """Run the work in the process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C is for the server, which then ends us
    Thread(target=_end_with_parent, name="parent", daemon=True).start()
    with suppress(OSError, AttributeError):
        os.nice(NICENESS)

    def send(state: WorkState) -> None:
        reports.send_bytes(to_bytes(state))

    def progress(done: int, of: int) -> None:
        send(WorkState("running", done, of))

    try:
        send(WorkState("done", result=work.do(progress)))
    except KeyposeError as error:
        send(WorkState("failed", words=str(error)))
    except OSError as error:
        send(WorkState("failed", words=f"{error.strerror or error}."))
    except MemoryError:
        send(WorkState("failed", words=work.died))
    except Exception:  # noqa: BLE001 — a fault of ours, which must be reported
        traceback.print_exc()
        send(WorkState("failed", words=work.died))
