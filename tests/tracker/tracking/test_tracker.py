"""Tracking a whole session: events, workers, cancelling, and what one keyframe may change."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from threading import Event
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Pass, Trajectory, interpolate
from keypose.tracker.errors import SessionError, VideoError
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.operations import track as tracking
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.storage.files import load_session, open_video_of
from keypose.tracker.tracking.initial import chains
from keypose.tracker.tracking.per_clip import PerClip
from keypose.tracker.tracking.pool import (
    PassFinished,
    Progress,
    SegmentFinished,
    SegmentStarted,
    TrackFinished,
    run,
)
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video.clip_loader import Memory
from tests.tracker import session_cases
from tests.tracker.tracking_cases import Case, MemoryVideo, case, tracked

KEYS = (0, 6, 12, 18)


@pytest.fixture(scope="module")
def person() -> Case:
    return case("stride", 30, 48)


@pytest.fixture(scope="module")
def box() -> Case:
    return case("tumbling_box", 20, 38)


def same(a: SegmentResult, b: SegmentResult) -> bool:
    """Byte by byte."""
    arrays: list[list[NDArray[Any]]] = [
        [r.trajectory.Rs_parent_part, r.trajectory.ps_camera_root, np.array(r.scores),
         *(rows for _, rows in r.diagnostics.arrays())]
        for r in (a, b)
    ]  # fmt: skip
    equal = all(x.tobytes() == y.tobytes() for x, y in zip(*arrays, strict=True))
    reported = [(r.verdict, r.steps, r.best_pass) for r in (a, b)]
    return equal and reported[0] == reported[1]


def nudged(pose: Pose, x: float = 0.01) -> Pose:
    turn = exp_rotation([0.0, 0.02, 0.0])
    return Pose(pose.Rs_parent_part @ turn, pose.p_camera_root + np.array([x, 0.0, 0.0]))


def test_events_give_the_work_of_every_segment_in_its_order(person: Case) -> None:
    events = list(run(person.tracker(*KEYS), TrackSettings()))
    assert isinstance(events[-1], TrackFinished)
    assert not events[-1].cancelled
    assert not any(isinstance(event, TrackFinished) for event in events[:-1])
    segments: list[list[Progress]] = [[], [], []]
    for event in events[:-1]:
        assert not isinstance(event, TrackFinished)
        segments[event.index].append(event)
    assert events[:-1] == [event for work in segments for event in work]  # one worker: in turn
    for index, (started, *passes, finished) in enumerate(segments):
        assert isinstance(started, SegmentStarted)
        assert (started.first_frame, started.last_frame) == KEYS[index : index + 2]
        assert isinstance(finished, SegmentFinished)
        assert started.count == finished.count == 3
        assert [p.number for p in passes if isinstance(p, PassFinished)] == [*range(len(passes))]
        result = finished.result
        reported = [p for p in passes if isinstance(p, PassFinished)]
        assert tuple(p.score for p in reported) == result.scores
        assert all(len(passes) <= p.of for p in reported)
        best = reported[result.best_pass].trajectory
        np.testing.assert_array_equal(best.Rs_parent_part, result.trajectory.Rs_parent_part)
        np.testing.assert_array_equal(best.ps_camera_root, result.trajectory.ps_camera_root)
        assert events[-1].result.segments[index] is result


@pytest.mark.parametrize("method", ["keypose", "paper"])
def test_the_number_of_passes_is_the_one_asked_for(person: Case, method: str) -> None:
    settings = TrackSettings(method=method, passes=2)  # type: ignore[arg-type]
    events = list(run(person.tracker(0, 6), settings))
    passes = [e for e in events if isinstance(e, PassFinished)]
    whats = events[-1].result.segments[0].steps  # type: ignore[union-attr]
    assert whats.count("pass") == 2
    assert all(p.of >= len(passes) for p in passes)


def test_results_have_the_shapes_that_are_promised(person: Case) -> None:
    dofs, parts = person.skeleton.dof_count, person.skeleton.part_count
    for result in tracked(person.tracker(*KEYS)):
        assert len(result.trajectory) == 7
        assert result.diagnostics.rank.shape == (6,)
        assert result.diagnostics.singular_values.shape == (6, dofs)
        assert (
            result.diagnostics.observability.shape
            == result.diagnostics.residual.shape
            == (6, parts)
        )
        assert result.closing_error <= 1e-9
        assert (np.diff(result.diagnostics.singular_values, axis=1) <= 0).all()
        shares = result.diagnostics.observability[:, np.unique(person.skeleton.dof_part)]
        assert ((shares >= 0) & (shares <= 1)).all()
        assert ((result.diagnostics.rank > 0) & (result.diagnostics.rank <= dofs)).all()


@pytest.mark.parametrize("method", ["keypose", "paper"])
def test_every_segment_shows_what_a_keyframe_more_would_mend(person: Case, method: str) -> None:
    for segment in tracked(person.tracker(0, 18), method=method):
        assert segment.diagnostics.expected_gain is not None
        assert segment.diagnostics.expected_gain.shape == (19,)
        assert segment.diagnostics.expected_gain[0] == segment.diagnostics.expected_gain[-1] == 0
        assert (segment.diagnostics.expected_gain[1:-1] > 0).all()


def test_a_preview_does_not_look_and_says_so(person: Case) -> None:
    (result,) = tracked(person.tracker(0, 6), quality="preview")
    assert (result.diagnostics.rank == -1).all()
    assert np.isnan(result.diagnostics.observability).all()
    assert np.isnan(result.diagnostics.residual).all()


def test_the_whole_motion_passes_through_every_keyframe(person: Case) -> None:
    *_, last = run(person.tracker(*KEYS), TrackSettings())
    assert isinstance(last, TrackFinished)
    whole = last.result.trajectory
    assert (whole.first_frame, whole.last_frame) == (0, 18)
    for k in KEYS:
        found, keyed = whole.pose(k), person.truth.pose(k)
        np.testing.assert_allclose(found.Rs_parent_part, keyed.Rs_parent_part, atol=1e-12)
        np.testing.assert_array_equal(found.p_camera_root, keyed.p_camera_root)


@pytest.mark.parametrize("method", ["keypose", "paper"])
def test_the_result_does_not_depend_on_workers_or_on_the_day(person: Case, method: str) -> None:
    tracker = person.tracker(*KEYS)
    alone = tracked(tracker, method=method)
    settings = TrackSettings(method=method)  # type: ignore[arg-type]
    for workers in (1, 3):
        fresh = person.tracker(*KEYS)
        *_, last = run(fresh, settings, workers=workers)
        assert isinstance(last, TrackFinished)
        for mine, other in zip(alone, last.result.segments, strict=True):
            assert same(mine, other)


def test_a_changed_keyframe_changes_its_two_segments_and_no_other(person: Case) -> None:
    tracker = person.tracker(*KEYS, 15)
    before = tracked(tracker)
    tracker.move_keyframe(6, nudged(person.truth.pose(6)))
    after = tracked(tracker)
    equal = [same(a, b) for a, b in zip(before, after, strict=True)]
    assert equal == [False, False, True, True]


def test_while_a_keyframe_is_moved_the_body_is_not_followed_anew_from_those_beside_it(
    person: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    tracker, followed = person.tracker(0, 6, 12), list[tuple[int, int]]()

    def find(clip: Any, key: tuple[Any, ...], work: Callable[[], Any]) -> Any:
        def counted() -> Any:
            followed.append(key[2:4])
            return work()

        return kept.get(clip, key, counted)

    kept = PerClip[Any](most=8)
    monkeypatch.setattr(chains, "_CHAINS", SimpleNamespace(get=find))
    tracked(tracker)
    assert sorted(followed) == [(0, 6), (6, 0), (6, 12), (12, 6)]
    moved = nudged(person.truth.pose(6))
    for _ in range(2):
        followed.clear()
        tracker.move_keyframe(6, moved)
        after = tracked(tracker)
        moved = nudged(moved)
    assert sorted(followed) == [(6, 0), (6, 12)]
    fresh = person.tracker(0, 6, 12)
    fresh.move_keyframe(6, nudged(nudged(person.truth.pose(6))))
    for mine, other in zip(after, tracked(fresh), strict=True):
        assert same(mine, other)


def test_a_renewed_tracker_finds_what_a_fresh_one_finds_with_the_same_pictures(
    person: Case,
) -> None:
    tracker = person.tracker(*KEYS)
    before = tracked(tracker)
    added = {k: person.truth.pose(k) for k in (0, 9, 18)}
    renewed = tracker.renewed(tracker.skeleton, added)
    assert renewed.spans == [(0, 9), (9, 18)]
    assert renewed.loader((0, 6)) is tracker.loader((0, 6))
    for mine, other in zip(tracked(renewed), tracked(person.tracker(*added)), strict=True):
        assert same(mine, other)
    assert tracker.spans == [(0, 6), (6, 12), (12, 18)]
    for mine, other in zip(tracked(tracker), before, strict=True):
        assert same(mine, other)


def test_a_renewed_tracker_takes_another_body(person: Case) -> None:
    old = person.skeleton.body
    head = old.parts[old.index("head")].model_copy(update={"joint_m": (0.0, -0.05, 0.0)})
    other = Skeleton.of(old.with_part(head))
    poses = {k: person.truth.pose(k) for k in (0, 6)}
    renewed = person.tracker(*KEYS).renewed(other, poses)
    fresh = Tracker(renewed.loader((0, 6)).video, person.camera, other, poses)
    assert same(tracked(renewed)[0], tracked(fresh)[0])
    with pytest.raises(SessionError, match="at least two"):
        renewed.renewed(other, {})


def test_segments_do_not_depend_on_keyframes_that_are_not_theirs(person: Case) -> None:
    before = tracked(person.tracker(*KEYS))
    far = person.truth.pose(18)
    moved = person.tracker(*KEYS)
    fresh = Tracker(
        moved.loader((0, 6)).video, person.camera, person.skeleton,
        moved.keyposes | {18: Pose(far.Rs_parent_part, far.p_camera_root * 1.02)},
    )  # fmt: skip
    assert same(before[0], tracked(fresh)[0])


def test_one_segment_alone_is_the_same_as_among_others(person: Case) -> None:
    tracker = person.tracker(*KEYS)
    everything = tracked(tracker)
    *_, last = run(tracker, TrackSettings(), segments=[2, 0, 2])
    assert isinstance(last, TrackFinished)
    first, second = last.result.segments
    assert same(first, everything[0])
    assert same(second, everything[2])
    with pytest.raises(ValueError, match="shared frame"):
        _ = last.result.trajectory
    events = list(run(tracker, TrackSettings(), segments=[1]))
    counts = [e.count for e in events if isinstance(e, SegmentStarted)]
    assert counts == [1]
    assert list(run(tracker, TrackSettings(), segments=[]))[-1].result.segments == ()  # type: ignore[union-attr]


def test_cancelling_keeps_what_is_finished_and_stops_within_one_pass(person: Case) -> None:
    stop: list[int] = []
    events: list[Progress] = []
    for event in run(person.tracker(*KEYS), TrackSettings(), cancelled=lambda: bool(stop)):
        events.append(event)
        if isinstance(event, SegmentFinished):
            stop.append(1)
    last = events[-1]
    assert isinstance(last, TrackFinished)
    assert last.cancelled
    kept = [e.result for e in events if isinstance(e, SegmentFinished)]
    assert 1 <= len(kept) == len(last.result.segments) <= 2
    assert kept[0] is last.result.segments[0]


def test_cancelled_from_the_start_nothing_is_tracked(person: Case) -> None:
    events = list(run(person.tracker(*KEYS), TrackSettings(), cancelled=lambda: True))
    assert isinstance(events[-1], TrackFinished)
    assert events[-1].cancelled
    assert len(events[-1].result.segments) < 3


def test_a_segment_is_left_at_its_next_pass_after_cancelling(
    person: Case, monkeypatch: pytest.MonkeyPatch
) -> None:
    tracker, go_on, polls = person.tracker(0, 18), Event(), []
    reached: list[int] = []

    def run_segment(index: int, settings: TrackSettings, emit: Any) -> Any:
        path = interpolate(person.truth.pose(0), person.truth.pose(18), 0, 18)
        emit(Pass("interpolation", path, 1.0), 0)
        assert go_on.wait(60)
        reached.append(0)
        emit(Pass("pass", path, 1.0), 1)
        reached.append(1)

    def cancelled() -> bool:
        if not seen or not isinstance(seen[-1], PassFinished):
            return False
        polls.append(True)
        if len(polls) > 1:  # the answer before this one has been heeded by now
            go_on.set()
        return True

    monkeypatch.setattr(tracker, "run_segment", run_segment)
    seen: list[Progress] = []
    for event in run(tracker, TrackSettings(), cancelled=cancelled):
        seen.append(event)
    assert reached == [0]
    assert [type(e) for e in seen] == [SegmentStarted, PassFinished, TrackFinished]
    assert isinstance(seen[-1], TrackFinished)
    assert seen[-1].cancelled
    assert seen[-1].result.segments == ()


def test_leaving_the_stream_early_ends_the_work(person: Case) -> None:
    stream = run(person.tracker(*KEYS), TrackSettings(), workers=2)
    assert isinstance(next(stream), SegmentStarted)
    stream.close()  # type: ignore[attr-defined]
    again = list(run(person.tracker(*KEYS), TrackSettings()))
    assert isinstance(again[-1], TrackFinished)


def test_an_error_while_reading_the_video_reaches_the_caller(person: Case) -> None:
    class Broken(MemoryVideo):
        def frames(self, first: int, stop: int) -> Any:
            raise VideoError("The video is gone.")

    video: Any = Broken(person.pictures)
    poses = {k: person.truth.pose(k) for k in KEYS}
    tracker = Tracker(video, person.camera, person.skeleton, poses)
    for workers in (1, 2):
        with pytest.raises(VideoError, match=r"The video is gone\."):
            list(run(tracker, TrackSettings(), workers=workers))


@pytest.mark.parametrize("count", [0, 1])
def test_fewer_than_two_keyframes_are_refused_in_one_sentence(person: Case, count: int) -> None:
    with pytest.raises(SessionError, match=r"^keyframes: at least two are needed .*\.$"):
        person.tracker(*KEYS[:count])


def test_a_keyframe_that_is_not_there_cannot_be_moved(person: Case) -> None:
    with pytest.raises(SessionError, match=r"Frame 5 has no keyframe"):
        person.tracker(*KEYS).move_keyframe(5, person.truth.pose(5))


def test_keyframes_may_be_given_in_any_order(person: Case) -> None:
    tracker = person.tracker(12, 0, 6)
    assert tracker.spans == [(0, 6), (6, 12)]
    joined = [r.trajectory.first_frame for r in tracked(tracker)]
    assert joined == [0, 6]


def test_a_saved_session_is_tracked_with_its_own_settings(tmp_path: Path) -> None:
    path = session_cases.write_session(tmp_path)
    session = load_session(path)
    with open_video_of(session, path) as video:
        *_, last = tracking.track_session(session, video)
        assert isinstance(last, TrackFinished)
        assert last.result.settings == session.settings
        spans = [(s.trajectory.first_frame, s.trajectory.last_frame) for s in last.result.segments]
    assert spans == [(0, 4), (4, 8)]
    for segment in last.result.segments:
        assert segment.closing_error <= 1e-9


def test_a_long_session_is_tracked_at_the_same_size_by_any_number_of_workers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = session_cases.write_session(tmp_path)
    session = load_session(path)
    one_clip = 5 * session_cases.WIDTH * session_cases.HEIGHT * 22
    monkeypatch.setattr(tracking, "ONCE", Memory(2 * one_clip))
    found: list[Trajectory] = []
    with open_video_of(session, path) as video:
        for workers in (1, 4):
            *_, last = tracking.track_session(session, video, workers=workers)
            assert isinstance(last, TrackFinished)
            found.append(last.result.trajectory)
    np.testing.assert_array_equal(found[0].Rs_parent_part, found[1].Rs_parent_part)


def test_keyframes_too_far_apart_are_refused_and_the_other_segments_tracked(person: Case) -> None:
    poses = {frame: person.truth.pose(0) for frame in (0, 6, 5000)}
    tracker = person.tracker(*KEYS).renewed(person.skeleton, poses)
    events: list[Any] = []
    with pytest.raises(SessionError, match=r"Keyframes 6 and 5000 lie 4994 frames apart"):
        events.extend(run(tracker, TrackSettings(quality="preview")))
    assert [event.index for event in events if isinstance(event, SegmentFinished)] == [0]
