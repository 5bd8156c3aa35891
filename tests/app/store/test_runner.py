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
from keypose.app.editor.state import EditorState
from keypose.app.jobs.fit_pose import FoundPose
from keypose.app.jobs.job import Context, Failed, Finished, Job, Progress, Report, Warming
from keypose.app.jobs.progress import Shares
from keypose.app.jobs.space import SolveSpace
from keypose.app.jobs.track import Track, TrackReporter
from keypose.app.store import runner as running
from keypose.app.store.runner import Runner
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Pass
from keypose.tracker.session import Session
from keypose.tracker.storage.results import segment_keys
from keypose.tracker.tracking.pool import PassFinished, SegmentFinished, never
from keypose.tracker.tracking.result import SegmentResult
from tests.app import surface_cases
from tests.app.editor.desk import after, desk
from tests.app.editor.test_live import track
from tests.app.jobs.job_cases import segment_done
from tests.app.results_cases import judged
from tests.tracker.session_cases import VERDICTS
from tests.tracker.storage.space_cases import both, pinned, smooth, solution

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


@pytest.fixture
def runner(monkeypatch: pytest.MonkeyPatch) -> Runner:
    monkeypatch.setattr(running, "Tracking", Orders)
    news: list[bool] = []
    made = Runner(None, lambda _, finished: news.append(finished), lambda _: None)  # type: ignore[arg-type]
    made.news = news  # type: ignore[attr-defined]
    made.opened(desk())
    return made


def orders(runner: Runner) -> Orders:
    return runner._tracking  # type: ignore[return-value]


def result(runner: Runner, number: int, kind: Any = "good", job: int = 1) -> SegmentResult:
    """What the worker finds of a segment of an order."""
    first, last = orders(runner).wanted[job - 1][number]
    key = orders(runner).keys[job - 1][number]
    return replace(judged(first, last, VERDICTS[kind]), key=key)


def finish(runner: Runner, number: int, kind: Any = "good", job: int = 1) -> None:
    """The worker has done a segment of an order."""
    found = result(runner, number, kind, job)
    orders(runner).reporters[job].report(SegmentFinished(0, 1, found))


def surfaces(frames: int, keyframes: tuple[int, ...]) -> EditorState:
    session = surface_cases.session(frames, keyframes)
    return replace(desk(), doc=session, skeleton=Skeleton.of(session.subject.body))


def few(count: int) -> EditorState:
    doc = desk().doc
    return replace(desk(), doc=doc.changed({"keyframes": doc.subject.keyframes[:count]}))


# --- what is refused


@pytest.mark.parametrize("what", ["changed", "all"])
def test_only_segments_that_reach_between_two_frames_are_tracked(runner: Runner, what: Any) -> None:
    edit = desk()
    (first, last), *_ = edit.doc.spans
    runner.track(PIECE, edit, what, (first, last))
    assert [one[:2] for one in orders(runner).wanted[-1]] == [(first, last)]
    with pytest.raises(ActionRefused, match=f"within {last + 900}–{last + 999} are tracked"):
        runner.track(PIECE, edit, what, (last + 900, last + 999))


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
    runner: Runner, edit: EditorState, words: str, what: Any
) -> None:
    with pytest.raises(ActionRefused) as refusal:
        runner.track(PIECE, edit, what)
    assert str(refusal.value) == words
    assert orders(runner).wanted == []
    assert runner.job.state == "idle"


@pytest.mark.parametrize(("of_surfaces", "done"), [(False, "tracked"), (True, "fitted")])
def test_where_nothing_has_changed_since_there_is_nothing_to_do(
    runner: Runner, of_surfaces: bool, done: str
) -> None:
    edit = surfaces(5, (0, 2)) if of_surfaces else desk()
    runner.opened(edit)
    runner.track(PIECE, edit, "changed")
    for number in range(len(orders(runner).wanted[0])):
        finish(runner, number)
    assert runner.results is not None
    edit = replace(edit, results=runner.results)
    with pytest.raises(ActionRefused, match=f"^All segments are {done} and up to date"):
        runner.track(PIECE, edit, "changed")
    runner.track(PIECE, edit, "all")
    assert len(orders(runner).wanted) == 2


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
    runner: Runner, frame: int, what: Any, spans: Any, title: str
) -> None:
    runner.track(PIECE, after(desk(), {"do": "go", "frame": frame}), what)
    assert orders(runner).wanted == [spans]
    assert orders(runner).stages == [("full",)]
    assert (runner.job.state, runner.job.title, runner.job.words) == ("running", title, "starting")
    assert list(runner.running) == spans
    assert runner.news == [False]  # type: ignore[attr-defined]


def test_outside_the_keyframes_this_means_every_segment(runner: Runner) -> None:
    edit = after(desk(), {"do": "delete_key", "frame": 0}, {"do": "go", "frame": 3})
    runner.track(PIECE, edit, "this")
    assert orders(runner).wanted == [[(24, 48), (48, 72)]]


def test_segments_that_do_not_follow_one_another_are_counted_in_the_title(runner: Runner) -> None:
    runner.track(PIECE, desk(), "all")
    for number in range(3):
        finish(runner, number)
    turn = {"do": "key_angle", "part": "chest", "axis": "x", "deg": 12}
    edit = replace(desk(), results=runner.results)
    runner.track(PIECE, after(edit, {**turn, "frame": 0}, {**turn, "frame": 72}), "changed")
    assert orders(runner).wanted[1] == [(0, 24), (48, 72)]
    assert runner.job.title == "Tracking 2 segments"


LIVE = {"do": "live", "on": True}


def test_with_live_on_what_an_edit_made_outdated_is_tracked_at_once(runner: Runner) -> None:
    edit = after(desk(), LIVE, {"do": "go", "frame": 30})
    runner.changed(PIECE, edit)
    assert orders(runner).wanted == [[(24, 48)]]
    assert orders(runner).stages == [("preview", "full")]
    runner.changed(PIECE, edit)
    assert len(orders(runner).wanted) == 1  # it is at that already
    turned = after(edit, {"do": "key_angle", "frame": 24, "part": "head", "axis": "x", "deg": 12})
    runner.changed(PIECE, turned)
    assert len(orders(runner).wanted) == 2


def moved(state: EditorState, deg: float) -> EditorState:
    """A hand turns the head at a keyframe."""
    return after(state, {"do": "angles", "part": "head", "x": deg, "stroke": "s"})


def test_with_live_on_each_move_of_a_hand_is_previewed_the_newest_once_one_is_done(
    runner: Runner,
) -> None:
    live = after(desk(), LIVE, {"do": "go", "frame": 24})
    first, second, third = (moved(live, deg) for deg in (10, 20, 30))
    for state in (first, second, third):
        runner.dragged(PIECE, state)
    assert orders(runner).wanted == [[(0, 24), (24, 48)]]
    assert orders(runner).stages == [("preview",)]
    assert runner.job.state == "idle", "nobody asked for a job"
    found = result(runner, 0)
    orders(runner).reporters[1].report(SegmentFinished(0, 1, found))
    assert runner.previews.by_span == {(0, 24): found}
    assert runner.results is not None
    assert len(runner.results) == 0, "poses that a hand passed are kept nowhere"
    orders(runner).say(Finished(1))
    keys = orders(runner).keys
    assert keys[1] == [segment_keys(third.doc)[span] for span in ((0, 24), (24, 48))]
    orders(runner).say(Finished(2))
    assert len(keys) == 2, "and no more, while the hand rests"


def test_where_a_hand_let_go_its_previews_count_and_the_rest_is_tracked(runner: Runner) -> None:
    live = after(desk(), LIVE, {"do": "go", "frame": 24})
    state = moved(live, 10)
    runner.dragged(PIECE, state)
    for number, span in enumerate([(0, 24), (24, 48)]):
        found = replace(track(state, span, 0.1), quality="preview")
        orders(runner).reporters[1].report(SegmentFinished(number, 1, found))
    orders(runner).say(Finished(1))
    ended = after(state, {"do": "end_stroke", "stroke": "s"})
    runner.changed(PIECE, ended)
    assert runner.results is not None
    assert set(runner.results.fitting(ended.doc)) == {(0, 24), (24, 48)}
    assert orders(runner).stages[1:] == [("full",)]
    assert runner.previews.by_span == {}


def test_no_hand_takes_the_worker_from_a_job(runner: Runner) -> None:
    runner.track(PIECE, desk(), "all")
    live = moved(after(desk(), LIVE, {"do": "go", "frame": 24}), 10)
    runner.dragged(PIECE, live)
    runner.dragged(None, live)
    assert len(orders(runner).jobs) == 1
    orders(runner).say(Finished(1))
    runner.dragged(PIECE, live)
    assert len(orders(runner).jobs) == 2
    runner.track(PIECE, desk(), "all")
    found = replace(judged(0, 24), key="late")
    orders(runner).reporters[2].report(SegmentFinished(0, 1, found))
    assert runner.previews.by_span == {}, "what was asked for meanwhile goes first"


def test_a_hand_takes_the_worker_from_what_followed_its_last_gesture(runner: Runner) -> None:
    live = after(desk(), LIVE, {"do": "go", "frame": 24})
    runner.changed(PIECE, live)
    assert orders(runner).stages == [("preview", "full")]
    far = after(live, {"do": "go", "frame": 72})
    runner.dragged(PIECE, moved(far, 10))
    assert len(orders(runner).jobs) == 1, "not where that tracks other segments"
    runner.dragged(PIECE, moved(live, 10))
    assert orders(runner).calls[-1] == "cancel"
    assert orders(runner).stages[1:] == [("preview",)]
    assert (runner.job.state, runner.running) == ("idle", {})
    orders(runner).say(Finished(1, cancelled=True))
    assert runner.job.state == "idle", "nobody cancelled anything"


def test_what_a_hand_rests_at_is_previewed_once_a_job_has_ended(runner: Runner) -> None:
    runner.track(PIECE, desk(), "all")
    state = moved(after(desk(), LIVE, {"do": "go", "frame": 24}), 10)
    runner.dragged(PIECE, state)
    orders(runner).say(Finished(1))
    assert orders(runner).stages[1:] == [("preview",)]
    runner.dragged(PIECE, moved(state, 20))
    runner.forget_hand()  # the gesture was cancelled
    orders(runner).say(Finished(2))
    assert len(orders(runner).jobs) == 2


def test_the_published_method_has_no_previews(runner: Runner) -> None:
    paper = after(desk(), {"do": "settings", "method": "paper"}, LIVE, {"do": "go", "frame": 24})
    runner.dragged(PIECE, moved(paper, 10))
    assert orders(runner).jobs == []


def test_live_waits_for_a_switch_a_session_and_a_segment(runner: Runner) -> None:
    runner.changed(PIECE, desk())
    runner.changed(None, after(desk(), LIVE))
    runner.changed(PIECE, after(few(1), LIVE))
    assert orders(runner).wanted == []


def test_live_orders_nothing_where_all_is_tracked(runner: Runner) -> None:
    runner.track(PIECE, desk(), "all")
    for number in range(3):
        finish(runner, number)
    runner.changed(PIECE, after(replace(desk(), results=runner.results), LIVE))
    assert len(orders(runner).wanted) == 1


def test_what_lost_its_keyframes_is_tracked_no_further(runner: Runner) -> None:
    runner.track(PIECE, desk(), "all")
    runner.changed(
        PIECE,
        after(desk(), {"do": "key_angle", "frame": 24, "part": "head", "axis": "x", "deg": 12}),
    )
    assert "cancel" not in orders(runner).calls
    runner.changed(PIECE, few(1))
    assert orders(runner).calls[-1] == "cancel"


# --- what is told


def pass_on(runner: Runner, number: int, of: int = 4, score: float = 2.0) -> None:
    """The worker has one more trajectory of the first segment of the first order."""
    found = result(runner, 0)
    on_the_way = SegmentResult.on_the_way(Pass("pass", found.trajectory, score), found.key)
    orders(runner).reporters[1].report(PassFinished(0, number, of, on_the_way))


def test_a_job_reports_its_passes_and_then_what_was_found(runner: Runner) -> None:
    runner.track(PIECE, desk(), "all")
    say = orders(runner).say
    say(Warming("compiling", 1))
    assert runner.job.words == "compiling"
    say(Progress(1, 0.0))
    pass_on(runner, 0)
    at_work = runner.running[0, 24]
    assert (at_work.state, at_work.number, at_work.of, at_work.scores) == ("tracking", 1, 4, (2.0,))
    pass_on(runner, 1, score=1.5)
    at_work = runner.running[0, 24]
    assert (at_work.number, at_work.percent, at_work.scores) == (2, 40, (2.0, 1.5))
    assert (runner.job.words, int(runner.job.percent)) == ("pass 2 of 4", 13)
    pass_on(runner, 0)
    assert runner.running[0, 24].scores == (2.0,)  # another quality begins anew
    pass_on(runner, 5)
    assert runner.running[0, 24].of == 6
    for number, kind in enumerate(("good", "check", "good")):
        finish(runner, number, kind)
        assert len(runner.running) == 2 - number
    assert runner.job.percent == 100
    say(Finished(1))
    assert (runner.job.state, runner.job.title) == ("done", "Tracked 0–72")
    assert runner.job.words == "2 good, 1 to check"
    assert runner.job.worst == "check"
    assert runner.news.count(True) == 3  # type: ignore[attr-defined]


def test_a_job_that_is_cancelled_or_fails_says_what_is_kept(runner: Runner) -> None:
    def ended(*reports: Any) -> tuple[str, str, str]:
        runner.track(PIECE, desk(), "all")
        job = len(orders(runner).wanted)
        for report in reports:
            orders(runner).say(report(job))
        assert runner.running == {}
        return runner.job.state, runner.job.title, runner.job.words

    def cancelled(job: int) -> Finished:
        return Finished(job, cancelled=True)

    assert ended(cancelled) == ("cancelled", "Cancelled", "no segment finished")
    done = ended(lambda job: segment_done(job, result(runner, 1, job=job)), cancelled)
    assert done == ("cancelled", "Cancelled", "finished segments are kept")
    failed = ended(lambda job: Failed(job, "The disk is full."))
    assert failed == ("failed", "Tracking failed", "The disk is full.")


def test_a_job_that_was_replaced_says_nothing_any_more_but_what_it_found_counts(
    runner: Runner,
) -> None:
    runner.track(PIECE, desk(), "all")
    runner.track(PIECE, desk(), "all")
    finish(runner, 0, job=1)
    orders(runner).say(Finished(1, cancelled=True))
    assert runner.job.state == "running"
    assert runner.results is not None
    assert runner.results.states(desk().doc)[0, 24] == "good"


def test_what_a_job_reports_after_its_session_was_closed_is_not_received(runner: Runner) -> None:
    runner.track(PIECE, desk(), "all")
    report = segment_done(1, result(runner, 0))
    runner.closed()
    assert orders(runner).calls == ["cancel"]
    runner.opened(desk())
    received = len(runner.news)  # type: ignore[attr-defined]
    orders(runner).say(report)
    assert runner.results is not None
    assert runner.results.states(desk().doc)[0, 24] == "none"
    assert len(runner.news) == received  # type: ignore[attr-defined]
    assert (runner.job.state, runner.running) == ("idle", {})


def test_the_worker_is_held_cancelled_and_ended(runner: Runner) -> None:
    runner.pause(True)
    runner.cancel()
    runner.stop()
    assert orders(runner).calls == [("pause", True), "cancel", "close"]


async def test_leaving_waits_for_the_end_of_what_is_being_tracked(runner: Runner) -> None:
    await runner.leave()
    assert orders(runner).calls == []  # nothing is at work
    runner.track(PIECE, desk(), "all")
    await runner.leave()
    assert orders(runner).calls == []  # the worker has not begun: there is nothing to keep
    orders(runner).say(Progress(1, 0.0))
    loop = asyncio.get_running_loop()
    loop.call_soon(orders(runner).say, Finished(1, cancelled=True))
    await runner.leave()
    assert orders(runner).calls == ["cancel"]
    assert runner.job.state == "cancelled"


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


def test_what_is_being_tracked_waits_for_a_fit_and_goes_on_after_it(runner: Runner) -> None:
    received: list[Any] = []
    runner.track(PIECE, desk(), "all")
    orders(runner).say(Progress(1, 0.0))
    pass_on(runner, 0)
    runner.news.clear()  # type: ignore[attr-defined]
    runner.fit(Fit(3), received.append)
    assert runner.news == [False]  # type: ignore[attr-defined]
    assert (runner.job.title, runner.job.kind) == ("Fitting frame 3", "fit")
    assert runner.job.words == "tracking continues after it"
    assert {one.state for one in runner.running.values()} == {"waiting"}
    assert len(runner.running) == 3
    orders(runner).say(Finished(1, cancelled=True))
    assert runner.job.state == "running"
    orders(runner).say(fitted(2))
    (report,) = received
    assert isinstance(report.result, FoundPose)
    edit = after(desk(), {"do": "delete_key", "frame": 72})
    runner.resume(PIECE, edit)
    assert orders(runner).wanted[2] == [(0, 24), (24, 48)]  # as it is posed by then
    assert orders(runner).stages[2] == ("full",)
    assert (runner.job.title, runner.job.kind) == ("Tracking 0–48", "track")
    orders(runner).say(fitted(2))
    assert len(received) == 1


@pytest.mark.parametrize(
    ("turned", "again"), [(9.0, [(0, 24), (24, 48), (48, 72)]), (0.0, [(24, 48), (48, 72)])]
)
def test_what_a_fit_makes_outdated_of_the_order_it_interrupted_is_tracked_again_and_no_more(
    runner: Runner, turned: float, again: list[tuple[int, int]]
) -> None:
    runner.track(PIECE, desk(), "all")
    orders(runner).say(Progress(1, 0.0))
    finish(runner, 0)
    runner.fit(Fit(24), lambda _: None)
    assert (0, 24) not in runner.running  # its result stays in sight
    edit = after(desk(), {"do": "go", "frame": 24})
    if turned:
        edit = after(edit, {"do": "angles", "part": "head", "x": turned})
    runner.resume(PIECE, edit)
    assert orders(runner).wanted[2] == again


def test_what_is_asked_for_during_a_fit_waits_for_it_as_well(runner: Runner) -> None:
    runner.fit(Fit(3), lambda _: None)
    assert (runner.job.words, runner.running) == ("", {})
    live = after(desk(), LIVE, {"do": "go", "frame": 30})
    received = len(runner.news)  # type: ignore[attr-defined]
    runner.changed(PIECE, live)
    assert len(orders(runner).wanted) == 1
    assert list(runner.running) == [(24, 48)]
    assert len(runner.news) == received + 1  # type: ignore[attr-defined]
    runner.fit(Fit(4), lambda _: None)  # in place of the first one
    assert list(runner.running) == [(24, 48)]
    runner.resume(PIECE, live)
    assert orders(runner).wanted[2:] == [[(24, 48)]]
    assert orders(runner).stages[2] == ("preview", "full")


def test_after_a_fit_for_which_nothing_waited_all_is_quiet(runner: Runner) -> None:
    runner.fit(Fit(3), lambda _: None)
    orders(runner).say(fitted(1))
    runner.news.clear()  # type: ignore[attr-defined]
    runner.resume(PIECE, desk())
    assert (runner.job.state, runner.running) == ("idle", {})
    assert len(orders(runner).wanted) == 1
    assert runner.news == [False]  # type: ignore[attr-defined]


def test_a_fit_that_fails_is_reported_to_whoever_asked_for_it(runner: Runner) -> None:
    received: list[Any] = []
    runner.fit(Fit(3), received.append)
    orders(runner).say(Warming("compiling", 1))
    orders(runner).say(Warming("", 1))
    assert runner.job.words == ""
    orders(runner).say(Failed(1, "There is no picture."))
    assert [report.words for report in received] == ["There is no picture."]


def test_a_fit_that_was_left_reports_to_nobody(runner: Runner) -> None:
    received: list[Any] = []
    runner.fit(Fit(3), received.append)
    runner.drop_fit()
    assert orders(runner).calls == ["cancel"]
    orders(runner).say(fitted(1))
    assert received == []


async def test_leaving_does_not_wait_for_a_fit(runner: Runner) -> None:
    runner.track(PIECE, desk(), "all")
    orders(runner).say(Progress(1, 0.0))
    runner.fit(Fit(3), lambda _: None)
    await runner.leave()
    assert orders(runner).calls == []


def test_a_trajectory_on_the_way_is_shown_before_its_segment_is_done(runner: Runner) -> None:
    runner.track(PIECE, desk(), "all")
    orders(runner).say(Progress(1, 0.0))
    pass_on(runner, 0)
    assert runner.results is not None
    assert orders(runner).keys[0][0] in runner.results.by_key


def test_a_fit_to_surfaces_is_called_so_and_says_what_was_kept_of_it(runner: Runner) -> None:
    edit = surfaces(5, (0, 2))
    runner.opened(edit)
    runner.track(PIECE, edit, "all")
    assert runner.job.title == "Fitting 0–4"
    stopped = replace(result(runner, 0), missing=1)
    orders(runner).say(segment_done(1, stopped))
    orders(runner).say(Finished(1, cancelled=True))
    assert runner.job.words == "finished frames are kept; Fit continues from there"
    runner.track(PIECE, edit, "all")
    orders(runner).say(Finished(2))
    assert runner.job.title == "Fitted 0–4"


# --- the motion in space follows by itself


def tracked(doc: Session) -> EditorState:
    """A session whose segments are tracked."""
    return replace(desk(), doc=doc, skeleton=Skeleton.of(doc.subject.body), results=both(doc))


def solved(runner: Runner, edit: EditorState, job: int) -> Progress:
    assert runner.results is not None
    return Progress(job, 1.0, partial=solution(runner.results.unsolved(edit.doc)[0]))


def test_what_is_tracked_is_solved_for_in_space_and_the_job_s_words_come_back(
    runner: Runner,
) -> None:
    edit = tracked(smooth(pinned()))
    runner.opened(edit)
    before = runner.job
    runner.solve_space(edit)
    assert len(orders(runner).solved) == 1
    assert (runner.job.state, runner.job.title, runner.job.kind) == (
        "running", "Smoothing 0–8", "space"
    )  # fmt: skip
    runner.news.clear()  # type: ignore[attr-defined]
    orders(runner).say(solved(runner, edit, 1))
    assert runner.news == [True]  # type: ignore[attr-defined]
    orders(runner).say(Finished(1))
    assert runner.job == before
    assert runner.results is not None
    assert runner.results.unsolved(edit.doc) == []


def test_the_same_is_not_solved_twice_whatever_came_of_it(runner: Runner) -> None:
    edit = tracked(smooth())
    runner.opened(edit)
    runner.solve_space(edit)
    runner.solve_space(edit)  # it is at that
    orders(runner).say(Finished(1, cancelled=True))
    runner.solve_space(edit)
    assert len(orders(runner).solved) == 1
    other = replace(edit, doc=pinned())
    runner.solve_space(other)
    assert len(orders(runner).solved) == 2
    assert orders(runner).solved[0] != orders(runner).solved[1]


def test_a_session_without_pins_and_smoothing_is_not_solved(runner: Runner) -> None:
    edit = tracked(pinned().changed({"pins": ()}))
    runner.opened(edit)
    runner.solve_space(edit)
    assert orders(runner).solved == []
    assert runner.job.state == "idle"


def test_solving_waits_for_what_is_tracked_and_for_a_hand(runner: Runner) -> None:
    edit = tracked(smooth())
    runner.opened(edit)
    runner.track(PIECE, edit, "all")
    runner.solve_space(edit)
    assert orders(runner).solved == []
    orders(runner).say(Finished(1))
    runner.solve_space(replace(edit, stroke=SimpleNamespace(name="x")))  # type: ignore[arg-type]
    assert orders(runner).solved == []
    runner.solve_space(edit)
    assert len(orders(runner).solved) == 1
    assert runner.job.title == "Smoothing 0–8"
    orders(runner).say(Finished(2))
    assert (runner.job.state, runner.job.title) == ("done", "Tracked 0–8")


def test_a_solve_that_fails_is_reported_once_and_the_motion_stays_as_tracked(
    runner: Runner,
) -> None:
    edit = tracked(smooth())
    runner.opened(edit)
    runner.solve_space(edit)
    orders(runner).say(Failed(1, "Smoothing met a fault."))
    assert (runner.job.state, runner.job.words) == ("failed", "Smoothing met a fault.")
    assert runner.job.title == "Smoothing failed"
    runner.solve_space(edit)
    assert len(orders(runner).solved) == 1
    assert runner.results is not None
    found = runner.results.fitting(edit.doc)
    assert all(segment.before_space is None for segment in found.values())


def test_another_session_is_solved_anew(runner: Runner) -> None:
    edit = tracked(smooth())
    for _ in range(2):
        runner.opened(edit)
        runner.solve_space(edit)
        orders(runner).say(Finished(len(orders(runner).solved), cancelled=True))
    assert len(orders(runner).solved) == 2


def test_a_solve_that_a_fit_ended_is_asked_for_again_after_it(runner: Runner) -> None:
    edit = tracked(smooth())
    runner.opened(edit)
    runner.solve_space(edit)
    runner.fit(Fit(3), lambda _: None)
    runner.solve_space(edit)
    assert len(orders(runner).solved) == 1  # a fit goes first
    orders(runner).say(Finished(1, cancelled=True))
    orders(runner).say(fitted(2))
    runner.resume(PIECE, edit)
    runner.solve_space(edit)
    assert orders(runner).solved[0] == orders(runner).solved[1]
