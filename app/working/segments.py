"""Segments are tracked: those asked for, those that follow an edit, and again after a fit; of
several bodies one after the other, the one that is posed first."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import replace
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
from keypose.app.words.bodies import name_among_several
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
        self._running: dict[Span, Running] = {}
        self._body = ""
        """The id of the body whose segments these are."""
        self._bodies_left: tuple[str, ...] = ()
        """The bodies that are tracked after it."""
        self._ended_orders: tuple[Track, ...] = ()
        """What was tracked before it of other bodies since somebody asked for all of them."""
        self._scope: Scope = "changed"
        self._frames: Span | None = None

    @property
    def running(self) -> dict[Span, Running]:
        """The segments of the body that is posed that are at work, or wait."""
        edit = self._host.app_state.edit
        return self._running if edit and edit.doc.subject.id == self._body else {}

    def closed(self) -> None:
        """No session is open any more."""
        self._waiting = self._interrupted = self._follows = frozenset()
        self._order, self._running, self._bodies_left = None, {}, ()
        self._ended_orders = ()

    def track(self, scope: Scope, frames: Span | None = None) -> None:
        """Track, between two frames where they are given: the body that is posed and, unless that
        is only about the present segment, all others. Refused with the reason where there is
        nothing to do."""
        edit = self._host.app_state.editing
        posed = edit.doc.subject.id
        others = [body.id for body in edit.doc.bodies if body.id != posed]
        bodies = (posed,) if scope == "this" else (posed, *others)
        if not any(edit.about(body_id).doc.spans for body_id in bodies):
            raise ActionRefused(why_nothing_to_do(edit.doc))
        self._scope, self._frames, self._bodies_left = scope, frames, bodies
        self._ended_orders = ()
        if not self._next_body():
            done = edit.doc.evidence.words.done
            there = "" if frames is None else f" within {frames[0]}–{frames[1]}"
            raise ActionRefused(f"All segments{there} are {done} and up to date.")

    def _next_body(self) -> bool:
        """Track the next of the bodies that are left of which there is something to do."""
        edit = self._host.app_state.editing
        while self._bodies_left:
            body_id, *left = self._bodies_left
            self._bodies_left = tuple(left)
            if body_id not in {body.id for body in edit.doc.bodies}:
                continue
            alone = edit.about(body_id)
            wanted = _spans_to_track(alone, self._scope, self._frames)
            if wanted:
                self._start(alone.doc, wanted, (edit.doc.settings.quality,))
                return True
        return False

    def changed(self, before: EditorState) -> None:
        """The document changed: what has no keyframes any more is tracked no further; with live on,
        what it made outdated is tracked at once."""
        doc = self._host.app_state.editing.doc
        if self._running and not self._queue.is_held and not {*self._running} & self._spans():
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
            self._ended_orders = ()
            self._start(doc, wanted, (*stages, doc.settings.quality))
            self._follows = frozenset((first, last) for first, last, _ in wanted)

    def _spans(self) -> set[Span]:
        """The segments that the body at work has by now; none where it is not there any more."""
        edit = self._host.app_state.editing
        if self._body not in {body.id for body in edit.doc.bodies}:
            return set()
        return {*edit.about(self._body).doc.spans}

    def dragged(self) -> None:
        """A hand moved keyframes, with live on: what followed the last gesture, and this one
        outdates, is tracked no further."""
        previewed = previewed_spans(self._host.app_state.editing)
        if self._is_at_work() and self._follows and self._follows <= {*previewed}:
            self._running, self._follows = {}, frozenset()
            self._queue.release()

    def go_on(self) -> None:
        """Track what waited for a fit, and again what that made outdated of the same order."""
        edit = self._host.app_state.edit
        if edit is None or not (self._waiting or self._interrupted):
            if edit is not None:
                self._next_body()
            return
        waiting, interrupted = self._waiting, self._interrupted
        self._waiting = self._interrupted = frozenset()
        self._running = {}
        wanted: list[Wanted] = []
        if self._spans():
            alone = edit.about(self._body).settled
            outdated = {(first, last) for first, last, _ in edit.results.wanted(alone)}
            waiting |= interrupted & outdated
            keys = segment_keys(alone)
            wanted = [(*span, key) for span, key in keys.items() if span in waiting]
        if wanted:
            self._start(alone, wanted, self._stages)
        elif not self._next_body():
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
        """doc: about the body whose segments are wanted."""
        if self._body != doc.subject.id:
            if self._waiting or self._is_at_work():
                self._bodies_left = (self._body, *self._bodies_left)
            self._waiting = self._interrupted = frozenset()
        self._stages, self._body = tuple(stages), doc.subject.id
        if self._queue.is_held:
            self._waiting |= {(first, last) for first, last, _ in wanted}
            self._running = dict.fromkeys(self._waiting, Running())
            self._queue.show_waiting()
            return
        opened = self._host.opened
        assert opened is not None
        place, folder = opened.video.info.path, opened.session_path.parent
        whole = self._host.app_state.editing.settled
        name = name_among_several(whole, doc.subject.id)
        order = Track.of(doc, place, wanted, stages, folder, name)
        self._begins()
        self._order, self._follows = None, frozenset()
        self._keep = tuple(
            key
            for body in whole.bodies
            for key in segment_keys(self._host.app_state.editing.about(body.id).settled).values()
        )
        self._running = dict.fromkeys(order.spans, Running())
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
            self._waiting, self._interrupted = frozenset(self._running), frozenset(order.spans)
            self._running = dict.fromkeys(self._waiting, Running())

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
        result = replace(partial.found.result, body=order.body)
        self._host.know(edit.results.with_result(result, self._keep))
        if order is self._order and self._is_at_work():
            self._on_tracked(partial)
        return isinstance(partial.found, SegmentFinished)

    def _on_tracked(self, step: Tracked) -> None:
        event, span = step.found, step.found.result.span
        if not isinstance(event, SegmentFinished):
            running = self._running.get(span, Running())
            scores = (*(running.scores if event.number else ()), event.score)
            number, of = event.number + 1, max(event.of, event.number + 1)
            at_work = Running("tracking", number, of, int(100 * step.share), scores)
            self._running = {**self._running, span: at_work}
        elif step.share >= 1:
            self._running = {key: run for key, run in self._running.items() if key != span}

    def _ended(self, end: Ended, order: Track) -> JobState:
        self._running = {}
        if isinstance(end, Failed) or end.cancelled:
            self._bodies_left = ()
        if isinstance(end, Failed):
            return JobState("failed", order.failed, end.words, 100)
        before = [each for each in self._ended_orders if each.body != order.body]
        self._ended_orders = (*before, order)
        return order.closing(end.cancelled, self._host.app_state.editing.results, before)


def _spans_to_track(edit: EditorState, scope: Scope, frames: Span | None) -> list[Wanted]:
    if scope == "changed":
        return reaching(edit.results.wanted(edit.doc), frames)
    every = [(*span, key) for span, key in segment_keys(edit.doc).items()]
    return reaching(every, frames) if scope == "all" else _touching(edit, every)


def _touching(edit: EditorState, wanted: Sequence[Wanted]) -> list[Wanted]:
    """Keep what touches the present frame; all of it where nothing does."""
    near = [w for w in wanted if w[0] <= edit.frame <= w[1]]
    return near or list(wanted)
