"""The motion in space follows by itself from what was tracked."""

from __future__ import annotations

from typing import Any

from keypose.app.jobs.job import Ended, Failed
from keypose.app.jobs.space import SolveSpace
from keypose.app.state.job_state import JobState
from keypose.app.working.owner import StateOwner
from keypose.app.working.queue import Item, Priority, WorkQueue
from keypose.tracker.space.result import SpaceResult


class SpaceSolving:
    """Every stretch is asked for once, whatever comes of it, until something is tracked anew."""

    def __init__(self, queue: WorkQueue, host: StateOwner) -> None:
        self._queue, self._host = queue, host
        self._asked: frozenset[str] = frozenset()

    def anew(self) -> None:
        """Ask again also for what could not be solved."""
        self._asked = frozenset()

    def go_on(self) -> None:
        """Solve wherever it is not known, where it may be saved and nothing is at work."""
        state = self._host.app_state
        edit = state.edit
        if edit is None or edit.stroke is not None or state.saved.state == "readonly":
            return
        if not self._queue.is_free_for(Priority.FOLLOWS):
            return
        posed = edit.doc.subject
        for body in (posed, *(body for body in edit.doc.bodies if body is not posed)):
            doc = edit.about(body.id).doc
            unsolved = edit.results.unsolved(doc)
            wanted = [stretch for stretch in unsolved if stretch.key not in self._asked]
            if wanted:
                self._asked |= {stretch.key for stretch in wanted}
                job = SolveSpace.of(doc, wanted)
                item = Item(job, Priority.FOLLOWS, take=self._take, end=_end, left=self.anew)
                self._queue.begin(item)
                return

    def _take(self, partial: Any) -> bool:
        edit = self._host.app_state.edit
        if not isinstance(partial, SpaceResult) or edit is None:
            return False
        self._host.know(edit.results.with_space(partial))
        return True


def _end(end: Ended) -> JobState | None:
    return (
        JobState("failed", SolveSpace.failed, end.words, 100) if isinstance(end, Failed) else None
    )
