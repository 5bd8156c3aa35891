"""Drafts near a keyframe learn from it, behind all else."""

from __future__ import annotations

from contextlib import suppress

from keypose.app.editor.drafted import newly_posed
from keypose.app.editor.state import EditorState
from keypose.app.jobs.job import Ended, Finished
from keypose.app.jobs.learn import LearnDrafts, Learned
from keypose.app.working.owner import StateOwner
from keypose.app.working.queue import Item, Priority, WorkQueue
from keypose.tracker.errors import KeyposeError


class DraftLearner:
    """Waits while something else is at work or dragged. What a person posed is never changed, and
    what they undo is not learned from."""

    def __init__(self, queue: WorkQueue, host: StateOwner) -> None:
        self._queue = queue
        self._host = host
        self._waiting: frozenset[int] = frozenset()
        self._found: tuple[LearnDrafts, EditorState, Learned] | None = None
        self._announced = False

    def closed(self) -> None:
        """No session is open any more."""
        self._waiting, self._found, self._announced = frozenset(), None, False

    def edited(self, before: EditorState, after: EditorState) -> None:
        """An edit is done; keyframes may be new."""
        self._waiting |= newly_posed(before, after)

    def go_on(self) -> None:
        """Take over what was found, or begin, unless somebody drags."""
        opened, edit = self._host.opened, self._host.app_state.edit
        if opened is None or edit is None or edit.stroke is not None:
            return
        around = self._waiting.intersection(edit.keys)
        if self._found is not None:
            self._take(*self._found)
        elif around and self._queue.is_free_for(Priority.FOLLOWS):
            job = LearnDrafts.of(opened, edit, around)
            item = Item(job, Priority.FOLLOWS, end=lambda end: self._on_end(job, edit, end))
            self._queue.begin(item)

    def _on_end(self, job: LearnDrafts, began: EditorState, end: Ended) -> None:
        self._waiting -= {*job.around}
        if isinstance(end, Finished) and not end.cancelled:
            self._found = job, began, end.result

    def _take(self, job: LearnDrafts, began: EditorState, poses: Learned) -> None:
        self._found = None
        with suppress(KeyposeError):  # drafts that cannot be stay as they are
            after, words = job.taken(poses, began, self._host.app_state)
            self._host.take(after)
            if words and not self._announced:
                self._announced = True
                self._host.note("info", words)
