"""Tracking as the page sees it: what is refused and why, what is ordered, what is told of it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.known import KnownMotion
from keypose.app.editor.state import EditorState
from keypose.app.jobs.fit_pose import FoundPose
from keypose.app.jobs.job import Context, Failed, Finished, Job, Progress, Report, Warming
from keypose.app.jobs.progress import Shares
from keypose.app.jobs.space import SolveSpace
from keypose.app.jobs.track import Track, TrackReporter
from keypose.app.state.app_state import AppState, Running
from keypose.app.state.job_state import JobState
from keypose.app.working import queue
from keypose.app.working.previews import HandPreviews
from keypose.app.working.queue import Item, Priority, WorkQueue
from keypose.app.working.segments import SegmentTracker
from keypose.app.working.space import SpaceSolving
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Pass
from keypose.tracker.session import Session
from keypose.tracker.storage.results import Results, segment_keys
from keypose.tracker.tracking.pool import PassFinished, SegmentFinished, never
from keypose.tracker.tracking.result import SegmentResult
from tests.app import surface_cases
from tests.app.bodies_cases import of_two
from tests.app.editor.desk import after, desk
from tests.app.editor.test_live import track
from tests.app.jobs.job_cases import segment_done
from tests.app.results_cases import judged
from tests.tracker.operations.space_cases import both, pinned, smooth, solution
from tests.tracker.session_cases import VERDICTS

PIECE: Any = SimpleNamespace(
    session_path=Path("job/session.json"),
    video=SimpleNamespace(info=SimpleNamespace(path=Path("job/clip.mp4"))),
)


class Orders:
    """Stands for the worker: takes orders, and says what a test makes it say."""

    def __init__(self, report: Callable[[Report], None], _: object) -> None:
        self.say = report
        self.jobs: list[Job] = []
        self.reporters: dict[int, TrackReporter] = {}
        self.calls: list[Any] = []

    def start(self, job: Job) -> int:
        self.jobs.append(job)
        number = len(self.jobs)
        if isinstance(job, Track):
            assert (job.video_path, job.folder) == ("job/clip.mp4", "job")
            context = Context(number, None, None, never, self.say)  # type: ignore[arg-type]
            shares = Shares.of(job.wanted, job.stages, 0.0)
            self.reporters[number] = TrackReporter(context, shares)
        return number

    @property
    def wanted(self) -> list[list[tuple[int, int]]]:
        return [job.spans if isinstance(job, Track) else [] for job in self.jobs]

    @property
    def keys(self) -> list[list[str]]:
        return [[key for *_, key in getattr(job, "wanted", ())] for job in self.jobs]

    @property
    def stages(self) -> list[tuple[str, ...]]:
        return [job.stages if isinstance(job, Track) else () for job in self.jobs]

    @property
    def solved(self) -> list[list[str]]:
        of_space = (job for job in self.jobs if isinstance(job, SolveSpace))
        return [[stretch.key for stretch in job.stretches] for job in of_space]

    def cancel(self) -> None:
        self.calls.append("cancel")

    def pause(self, on: bool) -> None:
        self.calls.append(("pause", on))

    def close(self) -> None:
        self.calls.append("close")


class Work:
    """The queue and those who work by it, of a state that a test sets."""

    def __init__(self) -> None:
        self.news: list[bool] = []
        self.noted: list[str] = []
        self.app_state = AppState(edit=desk())
        self.opened: Any = PIECE
        self.queue = WorkQueue(None, self._hear)  # type: ignore[arg-type]
        self.space = SpaceSolving(self.queue, self)  # type: ignore[arg-type]
        self.segments = SegmentTracker(self.queue, self, self.space.anew)  # type: ignore[arg-type]
        self.previewing = HandPreviews(self.queue, self)  # type: ignore[arg-type]
        self.queue.serve(self.segments.go_on, self.previewing.go_on)
        self.request: Fit | None = None

    def _hear(self, is_to_be_saved: bool) -> None:
        self.news.append(is_to_be_saved)
        self.shown = self.segments.running
        """What the page has of the segments at work."""

    def know(self, results: Results) -> None:
        self.app_state = replace(self.app_state, edit=self.edit.with_results(results))

    def show_motion(self, motion: KnownMotion) -> None:
        self.app_state = replace(self.app_state, edit=replace(self.edit, motion=motion))

    @property
    def edit(self) -> EditorState:
        return self.app_state.editing

    @property
    def job(self) -> JobState:
        return self.queue.state

    @property
    def running(self) -> dict[tuple[int, int], Running]:
        return self.segments.running

    @property
    def results(self) -> Results:
        return self.edit.results

    @property
    def orders(self) -> Orders:
        return self.queue._jobs  # type: ignore[return-value]

    def open(self, edit: EditorState) -> None:
        """Another session is open."""
        self.app_state = replace(self.app_state, edit=edit)
        self.space.anew()

    def shows(self, edit: EditorState) -> None:
        """The state is another one; what is known of the motion stays."""
        self.app_state = replace(self.app_state, edit=replace(edit, motion=self.edit.motion))

    def track(self, edit: EditorState, scope: Any, frames: Any = None) -> None:
        self.shows(edit)
        self.segments.track(scope, frames)

    def changed(self, edit: EditorState, opened: Any = PIECE) -> None:
        before, self.opened = self.edit, opened
        self.shows(edit)
        self.segments.changed(before)
        self.previewing.let_go()

    def dragged(self, edit: EditorState, opened: Any = PIECE) -> None:
        self.opened = opened
        self.shows(edit)
        self.segments.dragged()
        self.previewing.dragged()

    def fit(self, job: Job, on_end: Callable[[Any], None]) -> None:
        end: Any = on_end
        self.queue.begin(Item(job, Priority.PERSON, is_held=True, end=end))

    def resume(self, edit: EditorState) -> None:
        self.shows(edit)
        self.queue.release()

    def solve_space(self, edit: EditorState) -> None:
        self.shows(edit)
        self.space.go_on()

    def close(self) -> None:
        self.segments.closed()
        self.queue.closed()


@pytest.fixture
def work(monkeypatch: pytest.MonkeyPatch) -> Work:
    monkeypatch.setattr(queue, "JobRunner", Orders)
    return Work()


def result(work: Work, number: int, kind: Any = "good", job: int = 1) -> SegmentResult:
    """What the worker finds of a segment of an order."""
    first, last = work.orders.wanted[job - 1][number]
    key = work.orders.keys[job - 1][number]
    return replace(judged(first, last, VERDICTS[kind]), key=key)


def finish(work: Work, number: int, kind: Any = "good", job: int = 1) -> None:
    """The worker has done a segment of an order."""
    found = result(work, number, kind, job)
    work.orders.reporters[job].report(SegmentFinished(0, 1, found))


def surfaces(frames: int, keyframes: tuple[int, ...]) -> EditorState:
    session = surface_cases.session(frames, keyframes)
    return replace(desk(), doc=session, skeleton=Skeleton.of(session.subject.body))


def few(count: int) -> EditorState:
    doc = desk().doc
    return replace(desk(), doc=doc.changed({"keyframes": doc.subject.keyframes[:count]}))


# --- what is refused


@pytest.mark.parametrize("what", ["changed", "all"])
def test_only_segments_that_reach_between_two_frames_are_tracked(work: Work, what: Any) -> None:
    edit = desk()
    (first, last), *_ = edit.doc.spans
    work.track(edit, what, (first, last))
    assert [one[:2] for one in work.orders.wanted[-1]] == [(first, last)]
    with pytest.raises(ActionRefused, match=f"within {last + 900}–{last + 999} are tracked"):
        work.track(edit, what, (last + 900, last + 999))


@pytest.mark.parametrize("what", ["this", "changed", "all"])
@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (few(0), "Add two keyframes first."),
        (few(1), "Add a second keyframe first."),
        (surfaces(1, (0,)), "Nothing to fit: there is only one mesh."),
        (
            surfaces(5, ()),
            "Add a keyframe first: pose the body in one of the meshes.",
        ),
    ],
    ids=["none", "one", "one mesh", "no pose"],
)
def test_where_there_is_no_segment_yet_tracking_says_what_to_do_first(
    work: Work, edit: EditorState, words: str, what: Any
) -> None:
    with pytest.raises(ActionRefused) as refusal:
        work.track(edit, what)
    assert str(refusal.value) == words
    assert work.orders.wanted == []
    assert work.job.state == "idle"


@pytest.mark.parametrize(("of_surfaces", "done"), [(False, "tracked"), (True, "fitted")])
def test_where_nothing_has_changed_since_there_is_nothing_to_do(
    work: Work, of_surfaces: bool, done: str
) -> None:
    edit = surfaces(5, (0, 2)) if of_surfaces else desk()
    work.open(edit)
    work.track(edit, "changed")
    for number in range(len(work.orders.wanted[0])):
        finish(work, number)
    edit = edit.with_results(work.results)
    with pytest.raises(ActionRefused, match=f"^All segments are {done} and up to date"):
        work.track(edit, "changed")
    work.track(edit, "all")
    assert len(work.orders.wanted) == 2


# --- what is ordered


@pytest.mark.parametrize(
    ("frame", "what", "spans", "title"),
    [
        (30, "changed", [(0, 24), (24, 48), (48, 72)], "Tracking 0–72"),
        (30, "all", [(0, 24), (24, 48), (48, 72)], "Tracking 0–72"),
        (30, "this", [(24, 48)], "Tracking 24–48"),
        (48, "this", [(24, 48), (48, 72)], "Tracking 24–72"),
        (0, "this", [(0, 24)], "Tracking 0–24"),
        (72, "this", [(48, 72)], "Tracking 48–72"),
    ],
)
def test_this_means_the_segments_at_the_present_frame(
    work: Work, frame: int, what: Any, spans: Any, title: str
) -> None:
    work.track(after(desk(), {"do": "go", "frame": frame}), what)
    assert work.orders.wanted == [spans]
    assert work.orders.stages == [("full",)]
    assert (work.job.state, work.job.title, work.job.words) == ("running", title, "starting")
    assert list(work.running) == spans
    assert work.news == [False]


def test_outside_the_keyframes_this_means_every_segment(work: Work) -> None:
    edit = after(desk(), {"do": "delete_key", "frame": 0}, {"do": "go", "frame": 3})
    work.track(edit, "this")
    assert work.orders.wanted == [[(24, 48), (48, 72)]]


def test_segments_that_do_not_follow_one_another_are_counted_in_the_title(work: Work) -> None:
    work.track(desk(), "all")
    for number in range(3):
        finish(work, number)
    turn = {"do": "key_angle", "part": "chest", "axis": "x", "deg": 12}
    edit = desk().with_results(work.results)
    work.track(after(edit, {**turn, "frame": 0}, {**turn, "frame": 72}), "changed")
    assert work.orders.wanted[1] == [(0, 24), (48, 72)]
    assert work.job.title == "Tracking 2 segments"


LIVE = {"do": "live", "on": True}


def test_with_live_on_what_an_edit_made_outdated_is_tracked_at_once(work: Work) -> None:
    edit = after(desk(), LIVE, {"do": "go", "frame": 30})
    work.changed(edit)
    assert work.orders.wanted == [[(24, 48)]]
    assert work.orders.stages == [("preview", "full")]
    work.changed(edit)
    assert len(work.orders.wanted) == 1  # it is at that already
    turned = after(edit, {"do": "key_angle", "frame": 24, "part": "head", "axis": "x", "deg": 12})
    work.changed(turned)
    assert len(work.orders.wanted) == 2


def moved(state: EditorState, deg: float) -> EditorState:
    """A hand turns the head at a keyframe."""
    return after(state, {"do": "angles", "part": "head", "x": deg, "stroke": "s"})


def test_with_live_on_each_move_of_a_hand_is_previewed_the_newest_once_one_is_done(
    work: Work,
) -> None:
    live = after(desk(), LIVE, {"do": "go", "frame": 24})
    first, second, third = (moved(live, deg) for deg in (10, 20, 30))
    for state in (first, second, third):
        work.dragged(state)
    assert work.orders.wanted == [[(0, 24), (24, 48)]]
    assert work.orders.stages == [("preview",)]
    assert work.job.state == "idle", "nobody asked for a job"
    found = result(work, 0)
    work.orders.reporters[1].report(SegmentFinished(0, 1, found))
    assert work.edit.motion.previews == {(0, 24): found}
    assert len(work.results) == 0, "poses that a hand passed are kept nowhere"
    work.orders.say(Finished(1))
    keys = work.orders.keys
    assert keys[1] == [segment_keys(third.doc)[span] for span in ((0, 24), (24, 48))]
    work.orders.say(Finished(2))
    assert len(keys) == 2, "and no more, while the hand rests"


def test_where_a_hand_let_go_its_previews_count_and_the_rest_is_tracked(work: Work) -> None:
    live = after(desk(), LIVE, {"do": "go", "frame": 24})
    state = moved(live, 10)
    work.dragged(state)
    for number, span in enumerate([(0, 24), (24, 48)]):
        found = replace(track(state, span, 0.1), quality="preview")
        work.orders.reporters[1].report(SegmentFinished(number, 1, found))
    work.orders.say(Finished(1))
    ended = after(state, {"do": "end_stroke", "stroke": "s"})
    work.changed(ended)
    assert set(work.results.fitting(ended.doc)) == {(0, 24), (24, 48)}
    assert work.orders.stages[1:] == [("full",)]
    assert work.edit.motion.previews == {}


def test_no_hand_takes_the_worker_from_a_job(work: Work) -> None:
    work.track(desk(), "all")
    live = moved(after(desk(), LIVE, {"do": "go", "frame": 24}), 10)
    work.dragged(live)
    work.dragged(live, None)
    assert len(work.orders.jobs) == 1
    work.orders.say(Finished(1))
    work.dragged(live)
    assert len(work.orders.jobs) == 2
    work.track(desk(), "all")
    found = replace(judged(0, 24), key="late")
    work.orders.reporters[2].report(SegmentFinished(0, 1, found))
    assert work.edit.motion.previews == {}, "what was asked for meanwhile goes first"


def test_a_hand_takes_the_worker_from_what_followed_its_last_gesture(work: Work) -> None:
    live = after(desk(), LIVE, {"do": "go", "frame": 24})
    work.changed(live)
    assert work.orders.stages == [("preview", "full")]
    far = after(live, {"do": "go", "frame": 72})
    work.dragged(moved(far, 10))
    assert len(work.orders.jobs) == 1, "not where that tracks other segments"
    work.dragged(moved(live, 10))
    assert work.orders.calls[-1] == "cancel"
    assert work.orders.stages[1:] == [("preview",)]
    assert (work.job.state, work.running) == ("idle", {})
    work.orders.say(Finished(1, cancelled=True))
    assert work.job.state == "idle", "nobody cancelled anything"


def test_what_a_hand_rests_at_is_previewed_once_a_job_has_ended(work: Work) -> None:
    work.track(desk(), "all")
    state = moved(after(desk(), LIVE, {"do": "go", "frame": 24}), 10)
    work.dragged(state)
    work.orders.say(Finished(1))
    assert work.orders.stages[1:] == [("preview",)]
    work.dragged(moved(state, 20))
    work.previewing.let_go()  # the gesture was cancelled
    work.orders.say(Finished(2))
    assert len(work.orders.jobs) == 2


def test_the_published_method_has_no_previews(work: Work) -> None:
    paper = after(desk(), {"do": "settings", "method": "paper"}, LIVE, {"do": "go", "frame": 24})
    work.dragged(moved(paper, 10))
    assert work.orders.jobs == []


def test_live_waits_for_a_switch_a_session_and_a_segment(work: Work) -> None:
    work.changed(desk())
    work.changed(after(desk(), LIVE), None)
    work.changed(after(few(1), LIVE))
    assert work.orders.wanted == []


def test_live_orders_nothing_where_all_is_tracked(work: Work) -> None:
    work.track(desk(), "all")
    for number in range(3):
        finish(work, number)
    work.changed(after(desk().with_results(work.results), LIVE))
    assert len(work.orders.wanted) == 1


def test_what_lost_its_keyframes_is_tracked_no_further(work: Work) -> None:
    work.track(desk(), "all")
    turn = {"do": "key_angle", "frame": 24, "part": "head", "axis": "x", "deg": 12}
    work.changed(after(desk(), turn))
    assert "cancel" not in work.orders.calls
    work.changed(few(1))
    assert work.orders.calls[-1] == "cancel"


# --- what is told


def pass_on(work: Work, number: int, of: int = 4, score: float = 2.0) -> None:
    """The worker has one more trajectory of the first segment of the first order."""
    found = result(work, 0)
    on_the_way = SegmentResult.on_the_way(Pass("pass", found.trajectory, score), found.key)
    work.orders.reporters[1].report(PassFinished(0, number, of, on_the_way))


def test_a_job_reports_its_passes_and_then_what_was_found(work: Work) -> None:
    work.track(desk(), "all")
    say = work.orders.say
    say(Warming("compiling", 1))
    assert work.job.words == "compiling"
    say(Progress(1, 0.0))
    pass_on(work, 0)
    at_work = work.running[0, 24]
    assert (at_work.state, at_work.number, at_work.of, at_work.scores) == ("tracking", 1, 4, (2.0,))
    pass_on(work, 1, score=1.5)
    at_work = work.running[0, 24]
    assert (at_work.number, at_work.percent, at_work.scores) == (2, 40, (2.0, 1.5))
    assert (work.job.words, int(work.job.percent)) == ("pass 2 of 4", 13)
    pass_on(work, 0)
    assert work.running[0, 24].scores == (2.0,)  # another quality begins anew
    pass_on(work, 5)
    assert work.running[0, 24].of == 6
    for number, kind in enumerate(("good", "check", "good")):
        finish(work, number, kind)
        assert len(work.running) == 2 - number
    assert work.job.percent == 100
    say(Finished(1))
    assert (work.job.state, work.job.title) == ("done", "Tracked 0–72")
    assert work.job.words == "2 good, 1 to check"
    assert work.job.worst == "check"
    assert work.news.count(True) == 3


def test_of_several_bodies_the_end_tells_of_all(work: Work) -> None:
    two = of_two(desk().doc)
    work.track(replace(desk(), doc=two), "all")
    for job, kinds in ((1, ("check", "check", "check")), (2, ("good", "check", "check"))):
        for number, kind in enumerate(kinds):
            finish(work, number, kind, job)
        work.orders.say(Finished(job))
    assert (work.job.state, work.job.title) == ("done", "Tracked")
    assert work.job.words == "Adult male: 3 to check; Adult male 2: 1 good, 2 to check"
    assert work.job.worst == "check"
    assert {each.body for each in work.results.by_key.values()} == {"body", "second"}
    work.segments.track("this")
    work.orders.say(Finished(3))
    assert work.job.title == "Tracked 0–24 of Adult male", "of what was asked for last alone"


def test_a_job_that_is_cancelled_or_fails_says_what_is_kept(work: Work) -> None:
    def ended(*reports: Any) -> tuple[str, str, str]:
        work.track(desk(), "all")
        job = len(work.orders.wanted)
        for report in reports:
            work.orders.say(report(job))
        assert work.running == {}
        return work.job.state, work.job.title, work.job.words

    def cancelled(job: int) -> Finished:
        return Finished(job, cancelled=True)

    assert ended(cancelled) == ("cancelled", "Cancelled", "no segment finished")
    done = ended(lambda job: segment_done(job, result(work, 1, job=job)), cancelled)
    assert done == ("cancelled", "Cancelled", "finished segments are kept")
    failed = ended(lambda job: Failed(job, "The disk is full."))
    assert failed == ("failed", "Tracking failed", "The disk is full.")


def test_a_job_that_was_replaced_says_nothing_any_more_but_what_it_found_counts(
    work: Work,
) -> None:
    work.track(desk(), "all")
    work.track(desk(), "all")
    finish(work, 0, job=1)
    work.orders.say(Finished(1, cancelled=True))
    assert work.job.state == "running"
    assert work.results.states(desk().doc)[0, 24] == "good"


def test_what_a_job_reports_after_its_session_was_closed_is_not_received(work: Work) -> None:
    work.track(desk(), "all")
    report = segment_done(1, result(work, 0))
    work.close()
    assert work.orders.calls == ["cancel"]
    work.open(desk())
    received = len(work.news)
    work.orders.say(report)
    assert work.results.states(desk().doc)[0, 24] == "none"
    assert len(work.news) == received
    assert (work.job.state, work.running) == ("idle", {})


def test_the_worker_is_held_cancelled_and_ended(work: Work) -> None:
    work.queue.pause(True)
    work.queue.cancel()
    work.queue.stop()
    assert work.orders.calls == [("pause", True), "cancel", "close"]


async def test_leaving_waits_for_the_end_of_what_is_being_tracked(work: Work) -> None:
    await work.segments.leave()
    assert work.orders.calls == []  # nothing is at work
    work.track(desk(), "all")
    await work.segments.leave()
    assert work.orders.calls == []  # the worker has not begun: there is nothing to keep
    work.orders.say(Progress(1, 0.0))
    loop = asyncio.get_running_loop()
    loop.call_soon(work.orders.say, Finished(1, cancelled=True))
    await work.segments.leave()
    assert work.orders.calls == ["cancel"]
    assert work.job.state == "cancelled"


# --- a fit goes before tracking


class Fit(Job):
    """Has a title."""

    kind = "fit"

    def __init__(self, frame: int) -> None:
        self.frame = frame

    @property
    def title(self) -> str:
        return f"Fitting frame {self.frame}"


def fitted(job: int) -> Finished:
    return Finished(job, FoundPose(desk().opening, True, ""))


def test_what_is_being_tracked_waits_for_a_fit_and_goes_on_after_it(work: Work) -> None:
    received: list[Any] = []
    work.track(desk(), "all")
    work.orders.say(Progress(1, 0.0))
    pass_on(work, 0)
    work.news.clear()
    work.fit(Fit(3), received.append)
    assert work.news == [False]
    assert (work.job.title, work.job.kind) == ("Fitting frame 3", "fit")
    assert {one.state for one in work.running.values()} == {"waiting"}
    assert len(work.running) == 3
    work.orders.say(Finished(1, cancelled=True))
    assert work.job.state == "running"
    work.orders.say(fitted(2))
    (report,) = received
    assert isinstance(report.result, FoundPose)
    edit = after(desk(), {"do": "delete_key", "frame": 72})
    work.resume(edit)
    assert work.orders.wanted[2] == [(0, 24), (24, 48)]  # as it is posed by then
    assert work.orders.stages[2] == ("full",)
    assert (work.job.title, work.job.kind) == ("Tracking 0–48", "track")
    work.orders.say(fitted(2))
    assert len(received) == 1


@pytest.mark.parametrize(
    ("turned", "again"), [(9.0, [(0, 24), (24, 48), (48, 72)]), (0.0, [(24, 48), (48, 72)])]
)
def test_what_a_fit_makes_outdated_of_the_order_it_interrupted_is_tracked_again_and_no_more(
    work: Work, turned: float, again: list[tuple[int, int]]
) -> None:
    work.track(desk(), "all")
    work.orders.say(Progress(1, 0.0))
    finish(work, 0)
    work.fit(Fit(24), lambda _: None)
    assert (0, 24) not in work.running  # its result stays in sight
    edit = after(desk(), {"do": "go", "frame": 24})
    if turned:
        edit = after(edit, {"do": "angles", "part": "head", "x": turned})
    work.resume(edit)
    assert work.orders.wanted[2] == again


def test_what_is_asked_for_during_a_fit_waits_for_it_as_well(work: Work) -> None:
    work.fit(Fit(3), lambda _: None)
    assert (work.job.words, work.running) == ("", {})
    live = after(desk(), LIVE, {"do": "go", "frame": 30})
    received = len(work.news)
    work.changed(live)
    assert len(work.orders.wanted) == 1
    assert list(work.running) == [(24, 48)]
    assert len(work.news) == received + 1
    work.fit(Fit(4), lambda _: None)  # in place of the first one
    assert list(work.running) == [(24, 48)]
    work.resume(live)
    assert work.orders.wanted[2:] == [[(24, 48)]]
    assert work.orders.stages[2] == ("preview", "full")


def test_after_a_fit_for_which_nothing_waited_all_is_quiet(work: Work) -> None:
    work.fit(Fit(3), lambda _: None)
    work.orders.say(fitted(1))
    work.news.clear()
    work.resume(desk())
    assert (work.job.state, work.running) == ("idle", {})
    assert len(work.orders.wanted) == 1
    assert work.news == [False]


def test_what_waited_for_a_fit_and_is_gone_is_shown_no_longer(work: Work) -> None:
    work.track(desk(), "all")
    work.fit(Fit(3), lambda _: None)
    assert len(work.shown) == 3
    work.resume(few(1))
    assert (work.job.state, work.running, work.shown) == ("idle", {}, {})


def test_the_published_method_keeps_nothing_of_a_hand(work: Work) -> None:
    paper = after(desk(), {"do": "settings", "method": "paper"}, LIVE, {"do": "go", "frame": 24})
    state = moved(paper, 10)
    work.dragged(state)
    work.changed(after(state, {"do": "end_stroke", "stroke": "s"}))
    assert len(work.results) == 0


def test_a_fit_that_fails_is_reported_to_whoever_asked_for_it(work: Work) -> None:
    received: list[Any] = []
    work.fit(Fit(3), received.append)
    work.orders.say(Warming("compiling", 1))
    work.orders.say(Warming("", 1))
    assert work.job.words == ""
    work.orders.say(Failed(1, "There is no picture."))
    assert [report.words for report in received] == ["There is no picture."]


def test_a_fit_that_was_left_reports_to_nobody(work: Work) -> None:
    received: list[Any] = []
    work.fit(Fit(3), received.append)
    work.queue.release()
    assert work.orders.calls == ["cancel"]
    work.orders.say(fitted(1))
    assert received == []


async def test_leaving_does_not_wait_for_a_fit(work: Work) -> None:
    work.track(desk(), "all")
    work.orders.say(Progress(1, 0.0))
    work.fit(Fit(3), lambda _: None)
    await work.segments.leave()
    assert work.orders.calls == []


def test_a_trajectory_on_the_way_is_shown_before_its_segment_is_done(work: Work) -> None:
    work.track(desk(), "all")
    work.orders.say(Progress(1, 0.0))
    pass_on(work, 0)
    assert work.orders.keys[0][0] in work.results.by_key


def test_a_fit_to_surfaces_is_called_so_and_says_what_was_kept_of_it(work: Work) -> None:
    edit = surfaces(5, (0, 2))
    work.open(edit)
    work.track(edit, "all")
    assert work.job.title == "Fitting 0–4"
    stopped = replace(result(work, 0), missing=1)
    work.orders.say(segment_done(1, stopped))
    work.orders.say(Finished(1, cancelled=True))
    assert work.job.words == "finished frames are kept; Fit continues from there"
    work.track(edit, "all")
    work.orders.say(Finished(2))
    assert work.job.title == "Fitted 0–4"


# --- the motion in space follows by itself


def tracked(doc: Session) -> EditorState:
    """A session whose segments are tracked."""
    return replace(desk(), doc=doc, skeleton=Skeleton.of(doc.subject.body)).with_results(both(doc))


def solved(work: Work, edit: EditorState, job: int) -> Progress:
    return Progress(job, 1.0, partial=solution(work.results.unsolved(edit.doc)[0]))


def test_what_is_tracked_is_solved_for_in_space_and_the_job_s_words_come_back(
    work: Work,
) -> None:
    edit = tracked(smooth(pinned()))
    work.open(edit)
    before = work.job
    work.solve_space(edit)
    assert len(work.orders.solved) == 1
    assert (work.job.state, work.job.title, work.job.kind) == (
        "running", "Smoothing 0–8", "space"
    )  # fmt: skip
    work.news.clear()
    work.orders.say(solved(work, edit, 1))
    assert work.news == [True]
    work.orders.say(Finished(1))
    assert work.job == before
    assert work.results.unsolved(edit.doc) == []


def test_the_same_is_not_solved_twice_whatever_came_of_it(work: Work) -> None:
    edit = tracked(smooth())
    work.open(edit)
    work.solve_space(edit)
    work.solve_space(edit)  # it is at that
    work.orders.say(Finished(1, cancelled=True))
    work.solve_space(edit)
    assert len(work.orders.solved) == 1
    other = replace(edit, doc=pinned())
    work.solve_space(other)
    assert len(work.orders.solved) == 2
    assert work.orders.solved[0] != work.orders.solved[1]


def test_a_session_without_pins_and_smoothing_is_not_solved(work: Work) -> None:
    edit = tracked(pinned().changed({"pins": ()}))
    work.open(edit)
    work.solve_space(edit)
    assert work.orders.solved == []
    assert work.job.state == "idle"


def test_solving_waits_for_what_is_tracked_and_for_a_hand(work: Work) -> None:
    edit = tracked(smooth())
    work.open(edit)
    work.track(edit, "all")
    work.solve_space(edit)
    assert work.orders.solved == []
    work.orders.say(Finished(1))
    work.solve_space(replace(edit, stroke=SimpleNamespace(name="x")))  # type: ignore[arg-type]
    assert work.orders.solved == []
    work.solve_space(edit)
    assert len(work.orders.solved) == 1
    assert work.job.title == "Smoothing 0–8"
    work.orders.say(Finished(2))
    assert (work.job.state, work.job.title) == ("done", "Tracked 0–8")


def test_a_solve_that_fails_is_reported_once_and_the_motion_stays_as_tracked(
    work: Work,
) -> None:
    edit = tracked(smooth())
    work.open(edit)
    work.solve_space(edit)
    work.orders.say(Failed(1, "Smoothing met a fault."))
    assert (work.job.state, work.job.words) == ("failed", "Smoothing met a fault.")
    assert work.job.title == "Smoothing failed"
    work.solve_space(edit)
    assert len(work.orders.solved) == 1
    found = work.results.fitting(edit.doc)
    assert all(segment.before_space is None for segment in found.values())


def test_another_session_is_solved_anew(work: Work) -> None:
    edit = tracked(smooth())
    for _ in range(2):
        work.open(edit)
        work.solve_space(edit)
        work.orders.say(Finished(len(work.orders.solved), cancelled=True))
    assert len(work.orders.solved) == 2


def test_a_solve_that_a_fit_ended_is_asked_for_again_after_it(work: Work) -> None:
    edit = tracked(smooth())
    work.open(edit)
    work.solve_space(edit)
    work.fit(Fit(3), lambda _: None)
    work.solve_space(edit)
    assert len(work.orders.solved) == 1  # a fit goes first
    work.orders.say(Finished(1, cancelled=True))
    work.orders.say(fitted(2))
    work.resume(edit)
    work.solve_space(edit)
    assert work.orders.solved[0] == work.orders.solved[1]


def test_a_hand_goes_before_a_solve_in_space_which_is_asked_for_again(work: Work) -> None:
    edit = tracked(smooth())
    work.open(edit)
    work.solve_space(edit)
    work.dragged(moved(after(desk(), LIVE, {"do": "go", "frame": 24}), 10))
    assert work.orders.stages[1] == ("preview",)
    assert work.job.state == "idle", "a preview is no job that is shown"
    work.orders.say(Finished(1, cancelled=True))
    work.orders.say(Finished(2))
    work.previewing.let_go()
    work.solve_space(edit)
    assert work.orders.solved == [work.orders.solved[0]] * 2


def test_what_nobody_waits_for_begins_only_where_nothing_is_at_work(work: Work) -> None:
    asked: list[str] = []
    work.queue.serve(lambda: asked.append("first"), lambda: asked.append("second"))
    assert work.queue.begin(Item(Fit(1), Priority.FOLLOWS, is_shown=False))
    assert not work.queue.begin(Item(Fit(2), Priority.FOLLOWS))
    assert work.queue.begin(Item(Fit(3), Priority.HAND, is_shown=False))
    assert not work.queue.begin(Item(Fit(4), Priority.HAND))
    assert [job.frame for job in work.orders.jobs] == [1, 3]  # type: ignore[attr-defined]
    assert asked == []
    work.orders.say(Finished(2))
    assert asked == ["first", "second"], "in the order of who goes first"


def test_what_could_not_be_solved_is_asked_for_again_once_something_is_tracked(work: Work) -> None:
    edit = tracked(smooth())
    work.open(edit)
    work.solve_space(edit)
    work.orders.say(Failed(1, "Smoothing met a fault."))
    work.solve_space(edit)
    assert len(work.orders.solved) == 1
    work.track(edit, "all")
    work.orders.say(Finished(2))
    work.solve_space(edit)
    assert work.orders.solved == [work.orders.solved[0]] * 2
