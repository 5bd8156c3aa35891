"""How far a job is, and how long it may still take."""

from __future__ import annotations

from dataclasses import replace

import pytest

from keypose.app.jobs.progress import Shares, words_of
from keypose.tracker.body.trajectory import Pass
from keypose.tracker.session.settings import Quality
from keypose.tracker.tracking.pool import PassFinished, SegmentFinished
from keypose.tracker.tracking.result import SegmentResult
from tests.app.results_cases import session, track
from tests.tracker import session_cases as cases

WANTED = ((0, 4, "a"), (4, 8, "b"))


def begun(*stages: Quality) -> Shares:
    return Shares.of(WANTED, stages or ("full",), now=100.0)


def passed(first: int, number: int, of: int = 6, quality: Quality = "full") -> PassFinished:
    path = cases.segment(first, first + 4).trajectory
    found = SegmentResult.on_the_way(Pass("pass", path, 2.0), "a", quality)
    return PassFinished(0, number, of, found)


def done(first: int, quality: Quality = "full") -> SegmentFinished:
    return SegmentFinished(0, 1, track(session(), first, first + 4, quality))


def test_nothing_is_done_at_first_and_all_in_the_end() -> None:
    assert begun().share == 0
    assert begun().after(done(0)).share == 0.5
    assert begun().after(done(0)).after(done(4)).share == 1


def test_passes_move_it_on_and_never_back() -> None:
    progress, seen = begun(), []
    for report in (passed(0, 0), passed(0, 1), passed(4, 0), passed(0, 5), done(0), passed(0, 5)):
        progress = progress.after(report)
        seen.append(progress.share)
    assert seen == sorted(seen)
    assert seen[-1] == seen[-2] < 1.0
    assert progress.share_of((0, 4)) == 1
    assert 0 < progress.share_of((4, 8)) < 0.5
    assert progress.share_of((8, 9)) == 0


def test_more_passes_than_expected_do_not_finish_a_segment() -> None:
    progress = begun().after(passed(0, 20)).after(passed(4, 20))
    assert progress.share < 1


def test_a_preview_is_a_small_share_of_the_work() -> None:
    progress = begun("preview", "full").after(done(0, "preview")).after(done(4, "preview"))
    assert 0.1 < progress.share < 0.3
    assert progress.after(done(0)).after(done(4)).share == 1


def test_the_time_left_is_reported_once_it_can_be_known() -> None:
    assert begun().seconds_left(now=110.0) is None
    half = begun().after(done(0))
    assert half.seconds_left(now=100.2) is None
    assert half.seconds_left(now=104.0) == pytest.approx(4.0)
    assert half.after(done(4)).seconds_left(now=108.0) == 0.0


def test_other_segments_change_nothing() -> None:
    ends = session().subject.keyframes[::2]
    other = SegmentFinished(0, 1, track(session(keyframes=ends), 0, 8))
    assert begun().after(other).share == 0.0


def test_a_job_of_nothing_is_done() -> None:
    assert Shares.of((), ("full",), now=0.0).share == 1


def test_what_was_done_before_says_nothing_on_how_fast_it_goes() -> None:
    of_surfaces = passed(0, 59, 100)
    steps = replace(of_surfaces, result=replace(of_surfaces.result, steps=("fit",)))
    progress = begun().after(steps)
    assert (words_of(of_surfaces), words_of(steps)) == ("pass 60 of 100", "step 60 of 100")
    assert progress.seconds_left(now=200.0) is None
    on = progress.after(replace(steps, number=89))
    assert on.share > 0.4
    slow = on.seconds_left(now=130.0)
    assert slow is not None
    assert slow > 100  # a seventh of the whole in thirty seconds
