"""Tracking as the page sees it: orders, progress and results."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Literal, TypeAlias

from keypose.app.document.open import OpenSession
from keypose.app.editor.advice import why_nothing_to_do
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.state import EditorState
from keypose.app.jobs import (
    AheadOrder,
    Drafted,
    Drafting,
    DraftOrder,
    FitOrder,
    Fitted,
    FollowedAhead,
    FollowingAhead,
    JobFailed,
    JobFinished,
    Learned,
    LearnOrder,
    PassFinished,
    PoseFitted,
    Progress,
    Ready,
    Reduced,
    ReduceOrder,
    Reducing,
    Report,
    SegmentFinished,
    SizesFitted,
    SpaceSolved,
    Started,
    Tracking,
    Wanted,
    Warming,
    seconds_left,
)
from keypose.app.store.state import Job, Running
from keypose.app.words.jobs import (
    Ending,
    closing_words,
    drafting_progress,
    following_progress,
    spans_text,
)
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import Quality
from keypose.tracker.session.verdict import worst_of
from keypose.tracker.storage.results import Results, Span, segment_keys
from keypose.tracker.tracking.result import SegmentResult

What: TypeAlias = Literal["this", "changed", "all"]
OnFitEnd: TypeAlias = Callable[[Fitted | JobFailed | JobFinished], None]
FitKind: TypeAlias = Literal["fit", "draft", "ahead", "reduce"]

_FIT_KINDS: Mapping[type[FitOrder], FitKind] = {
    DraftOrder: "draft", AheadOrder: "ahead", ReduceOrder: "reduce",
}  # fmt: skip
"""Those that know how far they are."""
SECONDS_TO_LEAVE = 3.0
"""A pass, or a step of time, takes less."""


class Runner:
    """One job at a time. `notify` is called after each report; its flag: a segment is done.

    A fit goes before tracking: what is at work, and what is asked for meanwhile, waits for it and
    is resumed, as it is posed then, by `resume`.
    """

    def __init__(
        self, loop: asyncio.AbstractEventLoop, notify: Callable[[Runner, bool], None]
    ) -> None:
        self._notify = notify
        self._tracking = Tracking(self._on_report, loop)
        self._number = self._newest = 0
        self._past = 0
        self._began = 0.0
        self._wanted: dict[Span, str] = {}
        self._keep: tuple[str, ...] = ()
        self._stages: tuple[Quality, ...] = ()
        self._verbs = ("", "")
        self._fit_done: OnFitEnd | None = None
        self._waiting: frozenset[Span] = frozenset()
        self._interrupted: frozenset[Span] = frozenset()
        self._unsolvable: frozenset[str] = frozenset()
        self._ended = Job()
        self._learned: Callable[[Learned | None], None] = lambda found: None
        self._progress: Progress | None = None
        self.results: Results | None = None
        self.running: dict[Span, Running] = {}
        self.following: FollowingAhead | None = None
        self.job = Job()

    # --- called by the store

    def opened(self, edit: EditorState) -> None:
        """Another session is open."""
        self.results, self._unsolvable = edit.results, frozenset()

    def closed(self) -> None:
        """No session is open any more; what a job still reports does not count."""
        self._tracking.cancel()
        self._past = self._newest
        self._number, self._fit_done, self._waiting = 0, None, frozenset()
        self.running, self.results, self.job = {}, None, Job()
        self.following = None

    def stop(self) -> None:
        """End the worker."""
        self._tracking.close()

    def changed(self, opened: OpenSession | None, edit: EditorState) -> None:
        """The document changed: what has no keyframes any more is tracked no further; with live on,
        what it made outdated is tracked at once."""
        if self.running and self._fit_done is None and not {*self.running} & {*edit.doc.spans}:
            self._tracking.cancel()  # keyframes are gone: nothing is left of what is tracked
        if not edit.display.live or opened is None or not edit.doc.spans:
            return
        wanted = _touching(edit, edit.results.wanted(edit.doc))
        if wanted and not self._is_tracking(wanted):
            self._start(opened, edit.doc, wanted, ("preview", edit.doc.settings.quality))

    def track(self, opened: OpenSession, edit: EditorState, what: What) -> None:
        """Track; Refused with the reason when there is nothing to do."""
        if not edit.doc.spans:
            raise ActionRefused(why_nothing_to_do(edit.doc))
        wanted = _spans_to_track(edit, what)
        if not wanted:
            done = edit.doc.evidence.words.done
            raise ActionRefused(f"All segments are {done} and up to date.")
        self._start(opened, edit.doc, wanted, (edit.doc.settings.quality,))

    def fit(self, order: FitOrder, title: str, on_end: OnFitEnd) -> None:
        """Fit; `on_end` receives its outcome, unless it is dropped or replaced before."""
        if self._fit_done is None:
            self._waiting = frozenset(self.running)
            self._interrupted = frozenset(self._wanted) if self.running else frozenset()
        if self.job.kind == "space":  # which it ends, and which is asked for again after it
            self._unsolvable = frozenset()
        self._fit_done = on_end
        self._number = self._newest = self._tracking.fit(order)
        self._progress = None
        self._began = time.monotonic()
        self.running = dict.fromkeys(self._waiting, Running())
        words = "tracking continues after it" if self._waiting else ""
        self.job = Job("running", title, words, kind=_FIT_KINDS.get(type(order), "fit"))
        self._notify(self, False)

    def drop_fit(self) -> None:
        """Drop the fit at work."""
        self._tracking.cancel()
        self._number, self.following = 0, None

    def resume(self, opened: OpenSession, edit: EditorState) -> None:
        """The fit is over: track what waited for it, and again what it made outdated of the same
        order."""
        again = self._interrupted & self._outdated(edit)
        waiting, self._waiting, self._fit_done = self._waiting | again, frozenset(), None
        self.following = None
        self.job, self.running = Job(), {}
        keys = segment_keys(edit.settled)
        wanted = [(*span, key) for span, key in keys.items() if span in waiting]
        if wanted:
            self._start(opened, edit.settled, wanted, self._stages)
        else:
            self._notify(self, False)

    def _outdated(self, edit: EditorState) -> set[Span]:
        """Return what has no whole result for the keyframes as they are."""
        known = self.results.wanted(edit.settled) if self.results is not None else ()
        return {(first, last) for first, last, _ in known}

    def solve_space(self, edit: EditorState) -> None:
        """Solve for the motion in space wherever it is not known, where nothing is at work."""
        if self.results is None or self.job.state == "running" or edit.stroke is not None:
            return
        unsolved = self.results.unsolved(edit.doc)
        wanted = [stretch for stretch in unsolved if stretch.key not in self._unsolvable]
        if not wanted:
            return
        self._unsolvable |= {stretch.key for stretch in wanted}  # asked for once
        self._ended = self.job
        self._progress = None
        self._number = self._newest = self._tracking.solve_space(edit.doc, wanted)
        spans = spans_text([stretch.span for stretch in wanted])
        self.job = Job("running", f"Smoothing {spans}", kind="space")
        self._notify(self, False)

    def learn(self, order: LearnOrder, on_end: Callable[[Learned | None], None]) -> None:
        """Solve for drafts anew, where nothing is at work. `on_end` receives the outcome, None
        where there is none, unless other work is asked for before.
        """
        if self.job.state == "running":
            return
        self._ended, self._learned = self.job, on_end
        self._progress = None
        self._number = self._newest = self._tracking.fit(order)
        self.job = Job("running", "Drafts learn from keyframes", kind="drafts")
        self._notify(self, False)

    def pause(self, on: bool) -> None:
        """Pause while something is dragged."""
        self._tracking.pause(on)

    def cancel(self) -> None:
        """Stop within a pass; what is finished stays."""
        self._tracking.cancel()

    async def leave(self) -> None:
        """Stop what is being tracked, and wait a moment for what was done until then."""
        is_at_work = self.job.state == "running" and self._progress is not None
        if not is_at_work or self._fit_done is not None:
            return
        self.cancel()
        clock = asyncio.get_running_loop().time
        end = clock() + SECONDS_TO_LEAVE
        while self.job.state == "running" and clock() < end:
            await asyncio.sleep(0.02)

    # --- reports of the worker

    def _start(
        self, opened: OpenSession, doc: Session, wanted: Sequence[Wanted], stages: Sequence[Quality]
    ) -> None:
        self._stages, self._unsolvable = tuple(stages), frozenset()
        if self._fit_done is not None:
            self._waiting |= {(first, last) for first, last, _ in wanted}
            self.running = dict.fromkeys(self._waiting, Running())
            self._notify(self, False)
            return
        self._wanted = {(first, last): key for first, last, key in wanted}
        self._keep = tuple(segment_keys(doc).values())
        self.running = dict.fromkeys(self._wanted, Running())
        words = doc.evidence.words
        self._verbs = (words.doing.capitalize(), words.done.capitalize())
        self.job = Job("running", f"{self._verbs[0]} {spans_text(list(self._wanted))}", "starting")
        self._progress = None
        folder = opened.session_path.parent
        self._number = self._newest = self._tracking.start(
            doc, opened.video.info.path, wanted, stages, folder
        )
        self._notify(self, False)

    def _is_tracking(self, wanted: Sequence[Wanted]) -> bool:
        """Return whether this is what is being tracked already."""
        at_work = self.job.state == "running" and self._fit_done is None
        return at_work and set(self._wanted.values()) == {key for *_, key in wanted}

    def _on_report(self, report: Report) -> None:
        """Results count whichever job of this session they are of, for their keys; the rest for
        the newest job."""
        if self.results is None or (report.job is not None and report.job <= self._past):
            return
        finished = isinstance(report, SegmentFinished | SpaceSolved)
        if isinstance(report, SpaceSolved):
            self.results = self.results.with_space(report.result)
        if isinstance(report, PassFinished | SegmentFinished):
            self.results = self.results.with_result(report.result, self._keep)
        if report.job == self._number:
            self._on_own(report)
        self._notify(self, finished)

    def _on_own(self, report: Report) -> None:
        if self._progress is not None:
            self._progress = self._progress.after(report)
        match report:
            case Warming():
                self.job = replace(self.job, words=report.words)
            case Ready() if self.job.kind != "track":
                self.job = replace(self.job, words="")
            case Started():
                self._progress = Progress.of(report, time.monotonic())
            case PassFinished():
                self._on_pass(report)
            case SegmentFinished():
                self._on_segment(report.result)
            case Drafting():
                self._on_drafting(report)
            case FollowingAhead():
                self._on_following(report)
            case Learned():
                self.job = self._ended
                self._learned(report)
            case Reducing():
                percent = 100 * report.done / report.expected
                self.job = replace(self.job, percent=percent)
            case PoseFitted() | SizesFitted() | Drafted() | FollowedAhead() | Reduced():
                self._on_fit_end(report)
            case JobFailed() | JobFinished() if self._fit_done is not None:
                self._on_fit_end(report)
            case JobFinished() | JobFailed() if self.job.kind == "drafts":
                self.job = self._ended
                self._learned(None)
            case JobFinished() if self.job.kind == "space":
                self.job = self._ended
            case JobFailed() if self.job.kind == "space":
                self.job = Job("failed", "Smoothing failed", report.words, 100)
            case JobFinished():
                self._on_end("cancelled" if report.cancelled else "done")
            case JobFailed():
                self._on_end("failed", report.words)

    def _on_drafting(self, report: Drafting) -> None:
        words, percent = drafting_progress(report)
        left = seconds_left(time.monotonic() - self._began, percent / 100)
        self.job = replace(self.job, words=words, percent=percent, seconds_left=left)

    def _on_following(self, report: FollowingAhead) -> None:
        self.following = report
        words, percent = following_progress(report)
        self.job = replace(self.job, words=words, percent=percent)

    def _on_fit_end(self, report: Fitted | JobFailed | JobFinished) -> None:
        self._number, self.following = 0, None
        if self._fit_done is not None:
            self._fit_done(report)

    def _on_pass(self, report: PassFinished) -> None:
        known = self.running.get(report.result.span, Running())
        scores = (*(known.scores if report.number else ()), report.result.scores[-1])
        number, of = report.number + 1, max(report.of, report.number + 1)
        percent = self._progress.percent_of(report.result.span) if self._progress else 0
        at_work = Running("tracking", number, of, percent, scores)
        self.running = {**self.running, report.result.span: at_work}
        self._set_message(report.words)

    def _on_segment(self, track: SegmentResult) -> None:
        if self._progress is not None and self._progress.percent_of(track.span) >= 100:
            self.running = {span: r for span, r in self.running.items() if span != track.span}
        self._set_message(self.job.words)

    def _set_message(self, words: str) -> None:
        share = self._progress
        percent = share.percent if share else 0
        left = share.seconds_left(time.monotonic()) if share else None
        self.job = replace(self.job, words=words, percent=percent, seconds_left=left)

    def _on_end(self, state: Ending, words: str = "") -> None:
        doing, done = self._verbs
        finished = f"{done} {spans_text(list(self._wanted))}"
        title = {"done": finished, "cancelled": "Cancelled", "failed": f"{doing} failed"}[state]
        found = [] if words else self._found()
        worst = worst_of(track.kind for track in found if track is not None)
        closing = words or closing_words(state, found)
        self.job = Job(state, title, closing, 100, worst=worst)
        self.running = {}

    def _found(self) -> list[SegmentResult | None]:
        """Return what there is of the segments that were to be tracked."""
        known = self.results.by_key if self.results else {}
        return [known.get(key) for key in self._wanted.values()]


def _spans_to_track(edit: EditorState, what: What) -> list[Wanted]:
    if what == "changed":
        return edit.results.wanted(edit.doc)
    every = [(*span, key) for span, key in segment_keys(edit.doc).items()]
    return every if what == "all" else _touching(edit, every)


def _touching(edit: EditorState, wanted: Sequence[Wanted]) -> list[Wanted]:
    """Keep what touches the present frame; all of it where nothing does."""
    near = [w for w in wanted if w[0] <= edit.frame <= w[1]]
    return near or list(wanted)
