"""The motion beside a keyframe follows the hand that moves it, with Live on."""

from __future__ import annotations

from typing import Any

from keypose.app.editor.live import previewed_spans
from keypose.app.jobs.track import Track, Tracked
from keypose.app.working.owner import StateOwner
from keypose.app.working.queue import Item, Priority, WorkQueue
from keypose.tracker.storage.fingerprints import keys_of_spans
from keypose.tracker.tracking.pool import SegmentFinished


class HandPreviews:
    """Previews of the segments beside it follow one another, each for the newest poses once the one
    before is done. They are no jobs that are shown."""

    def __init__(self, queue: WorkQueue, host: StateOwner) -> None:
        self._queue, self._host = queue, host
        self._is_newer = False
        """Whether no preview was asked for of the newest poses yet."""

    def dragged(self) -> None:
        """A hand moved keyframes."""
        self._is_newer = True
        self.go_on()

    def let_go(self) -> None:
        """No hand moves a keyframe any more."""
        self._is_newer = False
        edit = self._host.app_state.edit
        if edit is not None:
            self._host.show_motion(edit.motion.without_previews())

    def go_on(self) -> None:
        """Preview the newest poses, where nothing goes before."""
        edit, opened = self._host.app_state.edit, self._host.opened
        if not self._is_newer or edit is None or edit.stroke is None or opened is None:
            return
        keys = keys_of_spans(edit.doc, previewed_spans(edit))
        wanted = [(*span, key) for span, key in keys.items()]
        if not wanted or not self._queue.is_free_for(Priority.HAND):
            return
        self._is_newer, gesture = False, edit.stroke.name
        place, folder = opened.video.info.path, opened.session_path.parent
        job = Track.of(edit.doc, place, wanted, ("preview",), folder)
        self._queue.begin(
            Item(
                job,
                Priority.HAND,
                is_shown=False,
                take=lambda partial: self._take(partial, gesture),
            )
        )

    def _take(self, partial: Any, gesture: str) -> bool:
        edit = self._host.app_state.edit
        if edit is None or edit.stroke is None or edit.stroke.name != gesture:
            return False
        if isinstance(partial, Tracked) and isinstance(partial.found, SegmentFinished):
            self._host.show_motion(edit.motion.with_preview(gesture, partial.found.result))
        return False
