"""A job: what is asked for, what is done in the worker process, what becomes of the state."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

from pydantic import ValidationError

from keypose.app.jobs.wire import failure_message
from keypose.app.state.job_state import Kind
from keypose.tracker.errors import one_sentence
from keypose.tracker.tracking.pool import Cancelled, never

if TYPE_CHECKING:
    from keypose.app.jobs.worker_cache import WorkerCache


@dataclass(frozen=True, eq=False)
class Progress:
    """How far a job is, 0 to 1. words: empty where nothing new is to be said. partial: what is
    there by now, as the job understands it. seconds_left: None while nobody can know."""

    job: int
    share: float
    words: str = ""
    partial: Any = None
    seconds_left: float | None = None


@dataclass(frozen=True)
class Finished:
    """Nothing more will come of a job: all is done, or it was cancelled or replaced by a newer."""

    job: int
    result: Any = None
    cancelled: bool = False


@dataclass(frozen=True)
class Failed:
    """A job ended by something a person should know: one sentence. What was finished is reported
    before and stays good."""

    job: int
    words: str


@dataclass(frozen=True)
class Warming:
    """The worker is getting ready, or is ready, without words; the job, if any, waits for it."""

    words: str
    job: int | None = None


Ended: TypeAlias = Finished | Failed
Report: TypeAlias = Progress | Ended | Warming


@dataclass(frozen=True)
class Context:
    """What a job works with: opened files, threads, whether somebody cancelled it, the receiver of
    its reports. hold: waits, though not for long, while a hand drags."""

    number: int
    cache: WorkerCache
    threads: Executor
    cancelled: Callable[[], bool]
    send: Callable[[Report], None]
    hold: Callable[[], object] = never

    def report(
        self, share: float, words: str = "", partial: Any = None, seconds_left: float | None = None
    ) -> None:
        self.send(Progress(self.number, share, words, partial, seconds_left))

    def leave_when_cancelled(self) -> None:
        """Raise Cancelled once somebody has cancelled."""
        if self.cancelled():
            raise Cancelled


class Job:
    """Made in the server, sent to the worker, done there.

    fault: said of an internal error, with its kind.  died: said when the worker died.
    needs_loops: whether it waits until the compiled loops are ready.
    """

    kind: ClassVar[Kind]
    needs_loops: ClassVar[bool] = True
    fault: ClassVar[str]
    died: ClassVar[str]

    @property
    def title(self) -> str:
        raise NotImplementedError

    @property
    def failed(self) -> str:
        """The title of its failure; empty where that is for whoever asked for it."""
        return ""

    def run(self, context: Context) -> Any:
        """Do it; Cancelled where it was left, KeyposeError in one sentence where it cannot be."""
        raise NotImplementedError


def do(job: Job, context: Context) -> None:
    """Do it and report how it ended."""
    end: Ended
    try:
        end = Finished(context.number, job.run(context))
    except Cancelled:
        end = Finished(context.number, cancelled=True)
    except ValidationError as error:
        end = Failed(context.number, one_sentence(error))
    except Exception as error:  # noqa: BLE001 — a fault, reported as such
        end = Failed(context.number, failure_message(error, job.fault))
    context.send(end)
