"""Tracking as the page sees it: orders, progress and results."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal, TypeAlias

from keypose.app.document.open import OpenSession
from keypose.app.editor.advice import why_nothing_to_do
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.live import let_go, moved_spans
from keypose.app.editor.state import EditorState, Previews
from keypose.app.jobs.job import Ended, Failed, Finished, Job, Progress, Report, Warming
from keypose.app.jobs.progress import Wanted, reaching
from keypose.app.jobs.space import SolveSpace
from keypose.app.jobs.track import Track, Tracked, found_in
from keypose.app.jobs.tracking import Tracking
from keypose.app.state.app_state import Running
from keypose.app.state.job_state import JobState
from keypose.app.state.outcomes import Following
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import Quality
from keypose.tracker.space.result import SpaceResult
from keypose.tracker.storage.fingerprints import keys_of_spans
from keypose.tracker.storage.results import Results, Span, segment_keys
from keypose.tracker.tracking.pool import SegmentFinished

What: TypeAlias = Literal["this", "changed", "all"]
OnEnd: TypeAlias = Callable[[Ended], None]

SECONDS_TO_LEAVE = 3.0
"""A pass, or a step of time, takes less."""


def _ignore(_: Ended) -> None:
    """Nobody waits for the end."""


class Runner:
    """One job at a time. `notify` is called after each report; its flag: a segment is done.

    While a hand moves a keyframe with live on, previews of the segments beside it follow one
    another, where no job is at work; they are no jobs that are shown. `previewed` is called with
    what they find.

    What a person waits for goes before tracking: what is at work, and what is asked for meanwhile,
    waits for it and is resumed, as it is posed then, by `resume`. What follows by itself begins
    where nothing is at work, and ends with whatever is asked for.
    """

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        notify: Callable[[Runner, bool], None],
        previewed: Callable[[Previews], None],
    ) -> None:
        self._notify, self._previewed = notify, previewed
        self._tracking = Tracking(self._on_report, loop)
        self._jobs: dict[int, Job] = {}
        """Of this session, those that have not ended."""
        self._number = 0
        self._on_end: OnEnd = _ignore
        self._track: Track | None = None
        self._keep: tuple[str, ...] = ()
        self._stages: tuple[Quality, ...] = ()
        self._fitting = self._has_begun = False
        self._waiting: frozenset[Span] = frozenset()
        self._interrupted: frozenset[Span] = frozenset()
        self._unsolvable: frozenset[str] = frozenset()
        self._hand: EditorState | None = None
        """As a hand has it by now."""
        self._is_newer = False
        """Whether no preview was asked for of that yet."""
        self._film: OpenSession | None = None
        self._preview_job = 0
        self._follows: frozenset[Span] = frozenset()
        """The segments that are tracked since a gesture with live on ended."""
        self.previews = Previews()
        self._before = JobState()
        self.results: Results | None = None
        self.running: dict[Span, Running] = {}
        self.following: Following | None = None
        self.job = JobState()

    # --- called by the store

    def opened(self, edit: EditorState) -> None:
        """Another session is open."""
        self.results, self._unsolvable = edit.results, frozenset()

    def closed(self) -> None:
        """No session is open any more; what a job still reports does not count."""
        self._tracking.cancel()
        self._jobs, self._number, self._fitting, self._waiting = {}, 0, False, frozenset()
        self._hand = self._film = None
        self._is_newer, self._preview_job, self.previews = False, 0, Previews()
        self.running, self.results, self.job = {}, None, JobState()
        self.following = None

    def stop(self) -> None:
        """End the worker."""
        self._tracking.close()

    def changed(self, opened: OpenSession | None, edit: EditorState) -> None:
        """The document changed: what has no keyframes any more is tracked no further; with live on,
        what it made outdated is tracked at once."""
        if self.running and not self._fitting and not {*self.running} & {*edit.doc.spans}:
            self._tracking.cancel()  # keyframes are gone: nothing is left of what is tracked
        results = self._let_go(edit)
        if not edit.display.live or opened is None or not edit.doc.spans:
            return
        wanted = _touching(edit, results.wanted(edit.doc))
        if wanted and not self._is_tracking(wanted):
            is_previewed = set(wanted).isdisjoint(results.wanted(edit.doc, "preview"))
            stages: tuple[Quality, ...] = () if is_previewed else ("preview",)
            self._start(opened, edit.doc, wanted, (*stages, edit.doc.settings.quality))
            self._follows = frozenset((first, last) for first, last, _ in wanted)

    def _let_go(self, edit: EditorState) -> Results:
        """The results, with what followed the hand until it let go."""
        results, hand = self.results or edit.results, self._hand
        if hand is not None and hand.doc is edit.doc:
            results = self.results = let_go(replace(hand, previews=self.previews), results)
        self.forget_hand()
        return results

    def forget_hand(self) -> None:
        """No hand moves a keyframe any more."""
        self._hand, self.previews, self._is_newer = None, Previews(), False

    def dragged(self, opened: OpenSession | None, edit: EditorState) -> None:
        """A hand moved a keyframe, with live on: the segments beside it are tracked at once, where
        nothing else is at work; for the newest poses, once those at work are done."""
        if opened is None or edit.stroke is None or edit.doc.settings.method == "paper":
            return
        if self.job.state == "running" and self._follows and self._follows <= {*moved_spans(edit)}:
            self._leave_outdated()
        if self.previews.gesture != edit.stroke.name:
            self.previews = Previews(edit.stroke.name)
        self._hand, self._film, self._is_newer = edit, opened, True
        self._preview_newest()

    def _leave_outdated(self) -> None:
        """Leave the tracking that followed the last gesture, which this one outdates."""
        self._tracking.cancel()
        self._number, self._follows = 0, frozenset()
        self.job, self.running = JobState(), {}
        self._notify(self, False)

    def _preview_newest(self) -> None:
        if self._hand is None or self._film is None or not self._is_newer:
            return
        if self._preview_job or self.job.state == "running":
            return
        self._is_newer, doc = False, self._hand.doc
        keys = keys_of_spans(doc, moved_spans(self._hand))
        wanted = [(*span, key) for span, key in keys.items()]
        place, folder = self._film.video.info.path, self._film.session_path.parent
        if wanted:
            job = Track.of(doc, place, wanted, ("preview",), folder)
            self._preview_job = self._tracking.start(job)

    def _on_preview(self, report: Report) -> None:
        if isinstance(report, Progress) and isinstance(found := found_in(report), SegmentFinished):
            by_span = {**self.previews.by_span, found.result.span: found.result}
            self.previews = replace(self.previews, by_span=by_span)
        if isinstance(report, Finished | Failed):
            self._preview_job = 0
            self._preview_newest()
        self._previewed(self.previews)

    def track(
        self, opened: OpenSession, edit: EditorState, what: What, frames: Span | None = None
    ) -> None:
        """Track, between two frames where they are given; Refused with the reason when there is
        nothing to do."""
        if not edit.doc.spans:
            raise ActionRefused(why_nothing_to_do(edit.doc))
        wanted = _spans_to_track(edit, what, frames)
        if not wanted:
            done = edit.doc.evidence.words.done
            there = "" if frames is None else f" within {frames[0]}–{frames[1]}"
            raise ActionRefused(f"All segments{there} are {done} and up to date.")
        self._start(opened, edit.doc, wanted, (edit.doc.settings.quality,))

    def fit(self, job: Job, on_end: OnEnd) -> None:
        """Do what a person waits for; `on_end` receives its end, unless it is dropped or replaced
        before."""
        if not self._fitting:
            self._waiting = frozenset(self.running)
            at_work = self._track.spans if self._track is not None and self.running else ()
            self._interrupted = frozenset(at_work)
        if self.job.kind == "space":  # which it ends, and which is asked for again after it
            self._unsolvable = frozenset()
        self._fitting = True
        self.running = dict.fromkeys(self._waiting, Running())
        words = "tracking continues after it" if self._waiting else ""
        self._begin(job, words, on_end)

    def drop_fit(self) -> None:
        """Drop the fit at work."""
        self._tracking.cancel()
        self._number, self.following = 0, None

    def resume(self, opened: OpenSession, edit: EditorState) -> None:
        """The fit is over: track what waited for it, and again what it made outdated of the same
        order."""
        again = self._interrupted & self._outdated(edit)
        waiting, self._waiting, self._fitting = self._waiting | again, frozenset(), False
        self.following = None
        self.job, self.running = JobState(), {}
        keys = segment_keys(edit.settled)
        wanted = [(*span, key) for span, key in keys.items() if span in waiting]
        if wanted:
            self._start(opened, edit.settled, wanted, self._stages)
        else:
            self._notify(self, False)

    def _outdated(self, edit: EditorState) -> set[Span]:
        """What has no whole result for the keyframes as they are."""
        known = self.results.wanted(edit.settled) if self.results is not None else ()
        return {(first, last) for first, last, _ in known}

    def follow(self, job: Job, on_end: OnEnd = _ignore) -> None:
        """Do what follows by itself, where nothing is at work. `on_end` receives its end, unless
        other work is asked for before."""
        if self.job.state != "running":
            self._before = self.job
            self._begin(job, "", on_end)

    def look(self, job: Job, on_end: OnEnd) -> bool:
        """Do what nobody waits for and is not shown, where nothing is at work; whether it began.
        Whatever else begins ends it, and then `on_end` is not called."""
        if self.job.state == "running" or self._preview_job:
            return False
        self._before = self.job
        self._number, self._on_end = self._tracking.start(job), on_end
        self._jobs[self._number] = job
        return True

    def solve_space(self, edit: EditorState) -> None:
        """Solve for the motion in space wherever it is not known, where nothing is at work."""
        if self.results is None or self.job.state == "running" or edit.stroke is not None:
            return
        unsolved = self.results.unsolved(edit.doc)
        wanted = [stretch for stretch in unsolved if stretch.key not in self._unsolvable]
        if wanted:
            self._unsolvable |= {stretch.key for stretch in wanted}  # asked for once
            self.follow(SolveSpace.of(edit.doc, wanted))

    def pause(self, on: bool) -> None:
        """Pause while something is dragged."""
        self._tracking.pause(on)

    def cancel(self) -> None:
        """Stop within a pass; what is finished stays."""
        self._tracking.cancel()

    async def leave(self) -> None:
        """Stop what is being tracked, and wait a moment for what was done until then."""
        is_at_work = self.job.state == "running" and self.job.kind == "track"
        if not is_at_work or not self._has_begun:
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
        if self._fitting:
            self._waiting |= {(first, last) for first, last, _ in wanted}
            self.running = dict.fromkeys(self._waiting, Running())
            self._notify(self, False)
            return
        self._keep = tuple(segment_keys(doc).values())
        folder = opened.session_path.parent
        self._track = Track.of(doc, opened.video.info.path, wanted, stages, folder)
        self.running = dict.fromkeys(self._track.spans, Running())
        self._begin(self._track, "starting")

    def _begin(self, job: Job, words: str, on_end: OnEnd = _ignore) -> None:
        self._preview_job, self._follows = 0, frozenset()
        self._number, self._on_end = self._tracking.start(job), on_end
        self._jobs[self._number] = job
        self._has_begun = False
        self.job = JobState("running", job.title, words, kind=job.kind)
        self._notify(self, False)

    def _is_tracking(self, wanted: Sequence[Wanted]) -> bool:
        """Whether this is what is being tracked already."""
        at_work = self.job.state == "running" and self.job.kind == "track"
        return at_work and self._track is not None and self._track.keys == {k for *_, k in wanted}

    def _on_report(self, report: Report) -> None:
        """What is there by now counts whichever job of this session it is of; the rest of the
        newest job alone."""
        finished = False
        if self.results is None:
            return
        if report.job is not None and report.job == self._preview_job:
            self._on_preview(report)
            return
        if report.job is not None:
            job = self._jobs.get(report.job)
            if job is None:
                return
            if isinstance(report, Progress):
                finished = self._take(report.partial, self.results)
            if isinstance(report, Finished | Failed):
                del self._jobs[report.job]
            if report.job == self._number:
                self._on_own(report, job)
        self._notify(self, finished)

    def _take(self, partial: object, results: Results) -> bool:
        """Add what is there by now to the results; whether it is to be saved."""
        if isinstance(partial, Tracked):
            self.results = results.with_result(partial.found.result, self._keep)
            return isinstance(partial.found, SegmentFinished)
        if isinstance(partial, SpaceResult):
            self.results = results.with_space(partial)
            return True
        return False

    def _on_own(self, report: Report, job: Job) -> None:
        match report:
            case Warming() if report.words or job.kind != "track":
                self.job = replace(self.job, words=report.words)
            case Progress():
                self._on_progress(report)
            case Finished() | Failed():
                self._number, self.following = 0, None
                if not self._fitting:
                    self.job, self.running = self._ended(report, job), {}
                self._on_end(report)
                self._preview_newest()

    def _ended(self, end: Ended, job: Job) -> JobState:
        if isinstance(end, Failed) and job.failed:
            return JobState("failed", job.failed, end.words, 100)
        if isinstance(end, Finished) and isinstance(job, Track) and self.results is not None:
            return job.closing(end.cancelled, self.results)
        return self._before

    def _on_progress(self, report: Progress) -> None:
        self._has_begun = True
        if isinstance(report.partial, Following):
            self.following = report.partial
        elif isinstance(report.partial, Tracked):
            self._on_tracked(report.partial)
        self.job = replace(
            self.job,
            words=report.words or self.job.words,
            percent=100 * report.share,
            seconds_left=report.seconds_left,
        )

    def _on_tracked(self, step: Tracked) -> None:
        found, span = step.found, step.found.result.span
        if not isinstance(found, SegmentFinished):
            running = self.running.get(span, Running())
            scores = (*(running.scores if found.number else ()), found.score)
            number, of = found.number + 1, max(found.of, found.number + 1)
            at_work = Running("tracking", number, of, int(100 * step.share), scores)
            self.running = {**self.running, span: at_work}
        elif step.share >= 1:
            self.running = {other: r for other, r in self.running.items() if other != span}


def _spans_to_track(edit: EditorState, what: What, frames: Span | None) -> list[Wanted]:
    if what == "changed":
        return reaching(edit.results.wanted(edit.doc), frames)
    every = [(*span, key) for span, key in segment_keys(edit.doc).items()]
    return reaching(every, frames) if what == "all" else _touching(edit, every)


def _touching(edit: EditorState, wanted: Sequence[Wanted]) -> list[Wanted]:
    """Keep what touches the present frame; all of it where nothing does."""
    near = [w for w in wanted if w[0] <= edit.frame <= w[1]]
    return near or list(wanted)
