"""Look for people in a picture on which a box is about to be drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from keypose.app.document.open import OpenSession
from keypose.app.jobs.find_people import FindPeople
from keypose.app.jobs.job import Ended, Failed, Finished
from keypose.app.state.outcomes import Boxes
from keypose.app.working.owner import StateOwner
from keypose.app.working.queue import Item, Priority, WorkQueue


class PeopleLooker:
    """Looks for people in a picture on which a box is about to be drawn, once a picture; `show`
    receives the boxes by frame, None of a picture that could not be looked at to the end."""

    def __init__(
        self,
        queue: WorkQueue,
        host: StateOwner,
        show: Callable[[Mapping[int, Boxes | None]], None],
    ) -> None:
        self._queue, self._host, self._show = queue, host, show

    def look(self, frame: int) -> None:
        """Begin, unless it is known, or something else is at work: then it may be asked again."""
        opened, edit = self._host.opened, self._host.app_state.edit
        if opened is None or edit is None or not 0 <= frame < edit.frame_count:
            return
        if frame not in self._host.app_state.people:
            job = FindPeople.of(opened, edit, frame)
            end = partial(self._on_end, frame, opened)
            self._queue.begin(Item(job, Priority.FOLLOWS, is_shown=False, end=end))

    def _on_end(self, frame: int, opened: OpenSession, end: Ended) -> None:
        if self._host.opened is not opened:
            return
        boxes = end.result if isinstance(end, Finished) and not end.cancelled else None
        self._show({**self._host.app_state.people, frame: boxes})
        if isinstance(end, Failed):
            self._host.note("check", end.words)
