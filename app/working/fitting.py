"""What a person waits for: from when it is asked for until what was found is in the state."""

from __future__ import annotations

from typing import Any

from keypose.app.document.open import OpenSession
from keypose.app.editor import actions
from keypose.app.editor.state import EditorState
from keypose.app.jobs.asked import JOBS
from keypose.app.jobs.fit import Fit
from keypose.app.jobs.job import Ended, Failed
from keypose.app.state.outcomes import Following
from keypose.app.working.owner import StateOwner
from keypose.app.working.queue import Item, Priority, WorkQueue
from keypose.app.working.segments import SegmentTracker
from keypose.tracker.errors import KeyposeError
from keypose.tracker.storage.fingerprints import Span


class Fitter:
    """One fit at a time. What it finds is taken over once, and only where it began from still
    stands; while a hand drags something else, it waits until that is let go."""

    def __init__(self, queue: WorkQueue, host: StateOwner, segments: SegmentTracker) -> None:
        self._queue, self._host, self._segments = queue, host, segments
        self.following: Following | None = None
        """How far the body is tracked ahead."""
        self._request: tuple[Fit, EditorState] | None = None
        """The fit under way, and the state when it was asked for."""
        self._found: tuple[Any] | None = None

    def ask(self, action: actions.Running | actions.FilmToAdd) -> Fit:
        """Begin; a fit that is asked for twice is done once. Refused with the reason where it
        cannot be had."""
        opened, edit = self._current()
        job = JOBS[action.do].of(opened, edit, action)
        if self._request is None or self._request[0] != job:
            self._begin(job)
            self._request, self._found = (job, edit), None
        return job

    def _begin(self, job: Fit) -> None:
        """What is being tracked, or was asked for since, waits for it."""
        at_work = self._queue.at_work
        interrupts = at_work is not None and at_work.job.kind == "track" and at_work.is_shown
        words = "tracking continues after it" if interrupts or self._segments.has_waiting else ""
        self.following = None
        item = Item(
            job,
            Priority.PERSON,
            words,
            is_held=True,
            take=lambda partial: self._take(partial, job),
            end=lambda end: self._on_end(end, job),
        )
        self._queue.begin(item)

    def changed(self) -> None:
        """The state is another one."""
        if self._request is None:
            return
        (job, began), (_, edit) = self._request, self._current()
        if not job.stands(began, edit):
            self._host.note("info", job.why_cancelled)
            self._leave(job)
        elif self._found is not None and edit.stroke is None:
            self._apply(job, *self._found)

    def cancel(self) -> bool:
        """Leave the fit that is under way; whether there was one."""
        if self._request is None:
            return False
        if self._request[0].keeps_found:
            self._queue.cancel()
        else:
            self._leave(self._request[0])
        return True

    def closed(self) -> None:
        """No session is open any more."""
        self._request = self._found = self.following = None

    def _leave(self, job: Fit) -> None:
        self._request = self._found = self.following = None
        self._host.take(job.left(self._host.app_state))
        self._queue.release()

    def _take(self, partial: Any, job: Fit) -> bool:
        if isinstance(partial, Following) and self._request is not None and self._request[0] is job:
            self.following = partial
        return False

    def _on_end(self, end: Ended, job: Fit) -> None:
        if self._request is None or self._request[0] is not job:
            return
        if isinstance(end, Failed):
            self._host.note("lost", end.words)
        if isinstance(end, Failed) or end.cancelled:
            self._leave(job)
        else:
            self._found = (end.result,)
            self.changed()

    def _apply(self, job: Fit, result: Any) -> None:
        self._request = self._found = self.following = None
        tracked = self._tracked()
        try:
            after, words = job.apply(result, self._host.app_state)
            if words:
                self._host.note("info", words)
            self._host.take(after)
        except KeyposeError as error:
            self._host.note("check", str(error))
        finally:
            self._queue.release()
        if job.tracks_after and not tracked <= self._tracked():
            self._segments.track("changed")

    def _tracked(self) -> set[Span]:
        """The segments whose motion is as the session asks for it."""
        _, edit = self._current()
        return set(edit.finished)

    def _current(self) -> tuple[OpenSession, EditorState]:
        opened, edit = self._host.opened, self._host.app_state.edit
        assert opened is not None
        assert edit is not None
        return opened, edit
