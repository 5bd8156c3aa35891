"""Segments are tracked: those asked for, those that follow an edit, and again after a fit."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from typing import Any, Literal, TypeAlias

from keypose.app.editor.advice import why_nothing_to_do
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.live import let_go, previewed_spans
from keypose.app.editor.state import EditorState
from keypose.app.jobs.job import Ended, Failed
from keypose.app.jobs.progress import Wanted, reaching
from keypose.app.jobs.track import Track, Tracked
from keypose.app.state.app_state import Running
from keypose.app.state.job_state import JobState
from keypose.app.working.owner import StateOwner
from keypose.app.working.queue import Item, Priority, WorkQueue
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import Quality
from keypose.tracker.storage.results import Span, segment_keys
from keypose.tracker.tracking.pool import SegmentFinished

Scope: TypeAlias = Literal["this", "changed", "all"]

SECONDS_TO_LEAVE = 3.0
"""A pass, or a step of time, takes less."""


class SegmentTracker:
    """One order at a time; what a fit interrupts is tracked after it, as it is posed then."""

    def __init__(self, queue: WorkQueue, host: StateOwner, begins: Callable[[], None]) -> None:
        """begins: called whenever an order is given to the worker."""
        self._queue, self._host, self._begins = queue, host, begins
        self._order: Track | None = None
        self._keep: tuple[str, ...] = ()
        """Keys of results that stay, whatever else is tracked."""
        self._stages: tuple[Quality, ...] = ()
        self._waiting: frozenset[Span] = frozenset()
        self._interrupted: frozenset[Span] = frozenset()
        """All that was ordered together with what waits."""
        self._follows: frozenset[Span] = frozenset()
        """What is tracked since a gesture with live on ended."""
        self.running: dict[Span, Running] = {}

    def closed(self) -> None:
        """No session is open any more."""
        self._waiting = self._interrupted = self._follows = frozenset()
        self._order, self.running = None, {}

    def track(self, scope: Scope, frames: Span | None = None) -> None:
        """Track, between two frames where they are given; refused with the reason where there is
        nothing to do."""
        edit = self._host.app_state.editing
        if not edit.doc.spans:
            raise ActionRefused(why_nothing_to_do(edit.doc))
        wanted = _spans_to_track(edit, scope, frames)
        if not wanted:
            done = edit.doc.evidence.words.done
            there = "" if frames is None else f" within {frames[0]}–{frames[1]}"
            raise ActionRefused(f"All segments{there} are {done} and up to date.")
        self._start(edit.doc, wanted, (edit.doc.settings.quality,))

    def changed(self, before: EditorState) -> None:
        """The document changed: what has no keyframes any more is tracked no further; with live on,
        what it made outdated is tracked at once."""
        doc = self._host.app_state.editing.doc
        if self.running and not self._queue.is_held and not {*self.running} & {*doc.spans}:
            self._queue.cancel()
        if before.doc is doc and previewed_spans(before):
            self._host.know(let_go(before))
        edit = self._host.app_state.editing
        if not edit.display.live or self._host.opened is None or not doc.spans:
            return
        wanted = _touching(edit, edit.results.wanted(doc))
        if wanted and not self._is_tracking(wanted):
            is_previewed = set(wanted).isdisjoint(edit.results.wanted(doc, "preview"))
            stages: tuple[Quality, ...] = () if is_previewed else ("preview",)
            self._start(doc, wanted, (*stages, doc.settings.quality))
            self._follows = frozenset((first, last) for first, last, _ in wanted)

    def dragged(self) -> None:
        """A hand moved keyframes, with live on: what followed the last gesture, and this one
        outdates, is tracked no further."""
        previewed = previewed_spans(self._host.app_state.editing)
        if self._is_at_work() and self._follows and self._follows <= {*previewed}:
            self.running, self._follows = {}, frozenset()
            self._queue.release()

    def go_on(self) -> None:
        """Track what waited for a fit, and again what that made outdated of the same order."""
        edit = self._host.app_state.edit
        if edit is None or not (self._waiting or self._interrupted):
            return
        outdated = {(first, last) for first, last, _ in edit.results.wanted(edit.settled)}
        waiting = self._waiting | (self._interrupted & outdated)
        self._waiting = self._interrupted = frozenset()
        self.running = {}
        keys = segment_keys(edit.settled)
        wanted = [(*span, key) for span, key in keys.items() if span in waiting]
        if wanted:
            self._start(edit.settled, wanted, self._stages)
        else:
            self._queue.show_waiting()

    @property
    def has_waiting(self) -> bool:
        """Whether segments are tracked after what is at work."""
        return bool(self._waiting)

    async def leave(self) -> None:
        """Stop what is being tracked, and wait a moment for what was done until then."""
        if not self._is_at_work() or not self._queue.has_begun:
            return
        self._queue.cancel()
        clock = asyncio.get_running_loop().time
        end = clock() + SECONDS_TO_LEAVE
        while self._is_at_work() and clock() < end:
            await asyncio.sleep(0.02)

    def _start(self, doc: Session, wanted: Sequence[Wanted], stages: Sequence[Quality]) -> None:
        self._stages = tuple(stages)
        if self._queue.is_held:
            self._waiting |= {(first, last) for first, last, _ in wanted}
            self.running = dict.fromkeys(self._waiting, Running())
            self._queue.show_waiting()
            return
        opened = self._host.opened
        assert opened is not None
        place, folder = opened.video.info.path, opened.session_path.parent
        order = Track.of(doc, place, wanted, stages, folder)
        self._begins()
        self._order, self._follows = None, frozenset()
        self._keep = tuple(segment_keys(doc).values())
        self.running = dict.fromkeys(order.spans, Running())
        item = Item(
            order,
            Priority.PERSON,
            "starting",
            take=lambda partial: self._take(partial, order),
            end=lambda end: self._ended(end, order),
            left=lambda: self._left(order),
        )
        self._queue.begin(item)
        self._order = order

    def _left(self, order: Track) -> None:
        """Something else is at work: another order, or a fit, for which this waits."""
        if order is self._order:
            self._waiting, self._interrupted = frozenset(self.running), frozenset(order.spans)
            self.running = dict.fromkeys(self._waiting, Running())

    def _is_at_work(self) -> bool:
        at_work = self._queue.at_work
        return self._order is not None and at_work is not None and at_work.job is self._order

    def _is_tracking(self, wanted: Sequence[Wanted]) -> bool:
        """Whether this is what is being tracked already."""
        is_same = self._order is not None and self._order.keys == {key for *_, key in wanted}
        return is_same and self._is_at_work()

    # --- reports

    def _take(self, partial: Any, order: Track) -> bool:
        edit = self._host.app_state.edit
        if not isinstance(partial, Tracked) or edit is None:
            return False
        self._host.know(edit.results.with_result(partial.found.result, self._keep))
        if order is self._order and self._is_at_work():
            self._on_tracked(partial)
        return isinstance(partial.found, SegmentFinished)

    def _on_tracked(self, step: Tracked) -> None:
        event, span = step.found, step.found.result.span
        if not isinstance(event, SegmentFinished):
            running = self.running.get(span, Running())
            scores = (*(running.scores if event.number else ()), event.score)
            number, of = event.number + 1, max(event.of, event.number + 1)
            at_work = Running("tracking", number, of, int(100 * step.share), scores)
            self.running = {**self.running, span: at_work}
        elif step.share >= 1:
            self.running = {key: run for key, run in self.running.items() if key != span}

    def _ended(self, end: Ended, order: Track) -> JobState:
        self.running = {}
        if isinstance(end, Failed):
            return JobState("failed", order.failed, end.words, 100)
        return order.closing(end.cancelled, self._host.app_state.editing.results)


def _spans_to_track(edit: EditorState, scope: Scope, frames: Span | None) -> list[Wanted]:
    if scope == "changed":
        return reaching(edit.results.wanted(edit.doc), frames)
    every = [(*span, key) for span, key in segment_keys(edit.doc).items()]
    return reaching(every, frames) if scope == "all" else _touching(edit, every)


def _touching(edit: EditorState, wanted: Sequence[Wanted]) -> list[Wanted]:
    """Keep what touches the present frame; all of it where nothing does."""
    near = [w for w in wanted if w[0] <= edit.frame <= w[1]]
    return near or list(wanted)
