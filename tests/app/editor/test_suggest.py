"""What to do next, in the page's words."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from keypose.app.editor.advice import ALL_GOOD, middle, suggestion
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation, rotation_from_euler
from keypose.tracker.review.segment_errors import fast_about
from keypose.tracker.review.segments import JudgedSegments
from keypose.tracker.session.verdict import GOOD, Cause, Verdict
from keypose.tracker.storage.results import Span
from keypose.tracker.tracking.result import SegmentResult
from tests.app.results_cases import judged, passing, session

KEYS = (0, 24, 48, 72)
PARTS = ("chest", "left_hand")


def good(first: int, last: int) -> SegmentResult:
    return judged(first, last)


def fitting(*others: SegmentResult, keys: tuple[int, ...] = KEYS) -> dict[Span, SegmentResult]:
    """All good but for these."""
    return {span: good(*span) for span in pairwise(keys)} | {t.span: t for t in others}


def test_without_keyframes_the_first_pose_is_asked_for() -> None:
    found = suggestion((), 73, {})
    assert found.title == "Pose this frame, then press K"
    assert (found.kind, found.frame) == ("pose", None)


def test_with_one_keyframe_another_about_a_second_away_is_asked_for() -> None:
    assert suggestion((0,), 73, {}).frame == 24
    assert suggestion((0,), 73, {}).title == "Pose frame 24, then press K"
    assert suggestion((60,), 73, {}).frame == 72
    assert suggestion((70,), 73, {}).frame == 46
    assert suggestion((0,), 6, {}).frame == 5
    assert suggestion((0,), 1, {}).frame is None


def test_what_is_not_tracked_is_to_be_tracked() -> None:
    found = suggestion(KEYS, 73, {(0, 24): good(0, 24)})
    assert (found.kind, found.title, found.frame) == ("track", "2 segments need tracking", None)
    assert found.detail == "Frames 24–48 and 48–72"
    assert suggestion(KEYS, 73, {}).detail == "Frames 0–24, 24–48 and 1 more"


def test_a_trajectory_on_the_way_does_not_count_as_tracked() -> None:
    way = passing(session(), 0, 4, 0.1)
    assert suggestion((0, 4), 9, {(0, 4): way}).kind == "track"


def test_what_is_lost_comes_first_with_the_frame_where_a_key_helps() -> None:
    lost = judged(48, 72, Verdict.not_followed(57))
    check = judged(0, 24, Verdict.check("not_seen", (3, 9), "left_hand"))
    found = suggestion(KEYS, 73, fitting(lost, check))
    assert (found.kind, found.frame, found.title) == ("key", 57, "Add a keyframe at 57")
    assert found.detail == "Forward and backward differ in 48–72"
    del (some := fitting(lost, check))[24, 48]
    assert suggestion(KEYS, 73, some).frame == 57


def test_frames_that_are_damaged_in_the_video_are_the_reason_for_a_key_among_them() -> None:
    check = judged(24, 48, Verdict.check("damaged", (31, 40)))
    found = suggestion(KEYS, 73, fitting(check))
    assert (found.kind, found.frame) == ("key", 36)
    assert found.detail == "Frames 31–40 are damaged in the video"


def test_what_is_hidden_where_tracking_was_lost_is_named() -> None:
    seen = np.full((24, 2), 0.9)
    seen[4:14, 1] = 0.05
    lost = judged(48, 72, Verdict.not_followed(57), seen)
    assert suggestion(KEYS, 73, fitting(lost), PARTS).detail == "Left hand hidden, frames 53–62"


def test_of_what_is_to_be_checked_the_longest_stretch_comes_first() -> None:
    short = judged(0, 24, Verdict.check("not_seen", (3, 9), "chest"))
    long = judged(24, 48, Verdict.check("not_seen", (26, 41), "left_hand"))
    found = suggestion(KEYS, 73, fitting(short, long))
    assert (found.frame, found.title) == (34, "Add a keyframe at 34")
    assert found.detail == "Left hand hidden, frames 26–41"
    assert found.kind == "key"


def test_everything_is_tracked_before_a_check_is_mended() -> None:
    check = judged(0, 24, Verdict.check("not_seen", (3, 9), "chest"))
    assert suggestion(KEYS, 73, {(0, 24): check}).kind == "track"


def test_a_key_is_never_asked_for_where_there_is_one() -> None:
    edge = judged(0, 24, Verdict.check("uncertain", (24, 24), "chest"))
    assert suggestion(KEYS, 73, fitting(edge)).frame == 23


def test_keyframes_that_are_wrong_themselves_are_to_be_looked_at() -> None:
    lost = judged(3, 4, Verdict.contradiction(3, 4))
    found = suggestion((3, 4), 9, {(3, 4): lost})
    assert (found.kind, found.frame) == ("look", 3)
    assert found.title == "Check keyframe 3"
    assert found.detail == "Keys 3 and 4 contradict each other"
    found = suggestion((0, 24), 73, {(0, 24): judged(0, 24, Verdict.nothing_seen(0, 24))})
    assert (found.frame, found.kind) == (0, "look")
    assert found.detail == "The body is not visible: check keyframes, camera and masks"


def test_in_a_short_interval_there_is_nothing_to_do_but_look() -> None:
    causes: tuple[Cause, ...] = ("uncertain", "not_seen", "diverged")
    for cause in causes:
        keys = (0, 10, 14, 24)
        check = judged(10, 14, Verdict.check(cause, (11, 13), "left_forearm"))
        found = suggestion(keys, 25, fitting(check, keys=keys))
        assert (found.kind, found.frame) == ("look", 12)
        assert found.title == "Check frame 12 and move on"
    keys = (0, 10, 15, 24)
    check = judged(10, 15, Verdict.check("uncertain", (11, 14), "left_forearm"))
    assert suggestion(keys, 25, fitting(check, keys=keys)).kind == "key"


def test_where_a_part_is_hidden_no_keyframe_is_asked_for_in_a_short_interval() -> None:
    for length, kind in ((6, "look"), (7, "key")):
        keys = (0, 10, 10 + length)
        check = judged(10, 10 + length, Verdict.check("not_seen", (12, 8 + length), "left_shin"))
        found = suggestion(keys, 30, fitting(check, keys=keys))
        assert found.kind == kind
        assert found.detail == f"Left shin hidden, frames 12–{8 + length}"


def test_halving_where_a_keyframe_was_asked_for_comes_to_an_end() -> None:
    keys, asked = [0, 24], 0
    while True:
        spans = list(pairwise(keys))
        bad = {
            s: judged(*s, Verdict.check("uncertain", (s[0] + 1, s[1] - 1), "chest")) for s in spans
        }
        found = suggestion(keys, 25, bad)
        if found.kind != "key":
            break
        assert found.frame is not None
        keys, asked = sorted({*keys, found.frame}), asked + 1
    assert found.kind == "look"
    assert asked < 8


def test_what_a_keyframe_can_mend_comes_before_what_is_only_to_be_looked_at() -> None:
    keys = (0, 4, 28)
    short = judged(0, 4, Verdict.not_followed(2))
    long = judged(4, 28, Verdict.check("uncertain", (9, 12), "chest"))
    found = suggestion(keys, 29, fitting(short, long, keys=keys))
    assert (found.kind, found.frame) == ("key", 11)
    assert suggestion(keys, 29, {(0, 4): short}).kind == "track"
    assert suggestion(keys, 29, fitting(short, keys=keys)).title == "Check frame 2 and move on"


def test_good_but_long_intervals_are_divided() -> None:
    keys = (0, 48, 60)
    found = suggestion(keys, 61, fitting(keys=keys))
    assert (found.frame, found.detail) == (24, "Longest interval, 48 frames")


def test_when_all_is_good_nothing_is_asked_for() -> None:
    assert suggestion(KEYS, 73, fitting()) == ALL_GOOD
    assert suggestion(KEYS, 100, fitting()) == ALL_GOOD
    assert ALL_GOOD.title == "All good"
    assert (ALL_GOOD.kind, ALL_GOOD.frame) == ("good", None)


def needing(first: int, last: int, per_frame_px: float, at: int, verdict: Verdict = GOOD) -> Any:
    """A segment where the keyframe `at` is expected to mend so much in the mean."""
    gains = np.zeros(last - first + 1)
    gains[at - first] = per_frame_px * (last - first)
    found = judged(first, last, verdict)
    return replace(found, diagnostics=replace(found.diagnostics, expected_gain=gains))


def test_the_keyframe_that_is_expected_to_mend_most_is_asked_for() -> None:
    found = suggestion(
        KEYS, 73, fitting(needing(0, 24, 2, 9), needing(24, 48, 5, 37), needing(48, 72, 1, 50))
    )
    assert (found.kind, found.frame, found.title) == ("key", 37, "Add a keyframe at 37")
    assert found.detail == "Most drift in 24–48"


def test_what_seems_wrong_right_beside_a_keyframe_is_the_keyframes_own_error() -> None:
    """However much it is: one more keyframe there would have such an error, too."""
    some = fitting(needing(0, 24, 40, 22), needing(24, 48, 2, 36), needing(48, 72, 0, 60))
    assert suggestion(KEYS, 73, some).frame == 36


def test_more_is_mended_in_a_longer_segment() -> None:
    keys = (0, 12, 60)
    some = fitting(needing(0, 12, 4, 6), needing(12, 60, 3, 33), keys=keys)
    assert suggestion(keys, 61, some).frame == 33


def test_a_long_segment_that_is_expected_to_be_right_is_left_alone() -> None:
    keys = (0, 180)
    found = suggestion(keys, 181, fitting(needing(0, 180, 0.2, 90), keys=keys))
    assert found.title == "All good"


def test_where_a_verdict_says_why_the_reason_is_the_verdicts() -> None:
    hidden = Verdict.check("not_seen", (26, 41), "left_hand")
    found = suggestion(
        KEYS, 73,
        fitting(needing(0, 24, 0.1, 9), needing(24, 48, 5, 37, hidden), needing(48, 72, 1, 50)),
    )  # fmt: skip
    assert (found.frame, found.detail) == (37, "Left hand hidden, frames 26–41")


def test_a_verdict_about_other_frames_is_no_reason() -> None:
    hidden = Verdict.check("not_seen", (26, 31), "left_hand")
    some = fitting(needing(24, 48, 5, 40, hidden), needing(0, 24, 0, 9), needing(48, 72, 0, 60))
    assert suggestion(KEYS, 73, some).detail == "Most drift in 24–48"
    keys = (0, 24, 60)
    some = fitting(needing(0, 24, 5, 20, Verdict.check("uncertain", (2, 9), "chest")),
                   needing(24, 60, 0, 40), keys=keys)  # fmt: skip
    assert suggestion(keys, 61, some).detail == "Most drift in 0–24"


def test_what_is_hidden_is_only_to_be_looked_at_where_a_keyframe_would_mend_little() -> None:
    hidden = Verdict.check("not_seen", (26, 41), "left_hand")
    quiet = [needing(0, 24, 0.1, 9), needing(48, 72, 0.1, 60)]
    found = suggestion(KEYS, 73, fitting(*quiet, needing(24, 48, 0.2, 37, hidden)))
    assert (found.kind, found.frame) == ("look", 34)


def test_where_tracking_was_lost_a_keyframe_is_asked_for_however_little_is_expected() -> None:
    lost = needing(24, 48, 0.1, 37, Verdict.not_followed(30))
    found = suggestion(KEYS, 73, fitting(needing(0, 24, 0, 9), lost, needing(48, 72, 0, 60)))
    assert (found.kind, found.frame) == ("key", 37)


def test_where_tracking_was_lost_comes_before_a_check_from_which_more_is_expected() -> None:
    lost = needing(0, 24, 0.1, 18, Verdict.not_followed(20))
    check = needing(48, 72, 9, 54, Verdict.check("uncertain", (52, 60), "chest"))
    found = suggestion(KEYS, 73, fitting(lost, needing(24, 48, 0, 30), check))
    assert (found.kind, found.frame) == ("key", 18)
    wrong = needing(48, 50, 0, 49, Verdict.check("keyframe_off_keypoints", (48, 49), "chest"))
    keys = (0, 24, 48, 50)
    found = suggestion(keys, 73, fitting(lost, needing(24, 48, 0, 30), wrong, keys=keys))
    assert (found.kind, found.frame) == ("key", 18)


def test_of_what_was_lost_the_one_that_a_keyframe_mends_most_comes_first() -> None:
    less = needing(0, 24, 2, 18, Verdict.not_followed(20))
    more = needing(48, 72, 5, 57, Verdict.not_followed(60))
    found = suggestion(KEYS, 73, fitting(less, needing(24, 48, 9, 30), more))
    assert (found.kind, found.frame) == ("key", 57)


def test_what_even_short_intervals_show_is_the_keyframes_own_error() -> None:
    keys = (0, 6, 30)
    long = needing(6, 30, 2, 15)
    sharp, rough = (fitting(needing(0, 6, px, 3), long, keys=keys) for px in (0.1, 1.8))
    assert suggestion(keys, 31, sharp).frame == 15
    assert suggestion(keys, 31, rough).kind == "good"


def test_keyframes_that_contradict_each_other_come_before_what_could_be_mended() -> None:
    wrong = needing(3, 4, 0, 3, Verdict.contradiction(3, 4))
    found = suggestion((3, 4, 28), 29, fitting(wrong, needing(4, 28, 5, 12), keys=(3, 4, 28)))
    assert (found.kind, found.frame) == ("look", 3)


def test_fast_motion_is_named_where_it_stands_out() -> None:
    quick = needing(24, 48, 5, 37)
    angles = np.cumsum(np.where((np.arange(25) > 10) & (np.arange(25) < 16), 0.15, 0.01))
    Rs = np.tile(rotation_from_euler(0.0, 0.0, 0.0), (25, 2, 1, 1))
    Rs[:, 1] = [rotation_from_euler(0.0, 0.0, angle) for angle in angles]
    quick = replace(quick, trajectory=Trajectory(24, Rs, np.ones((25, 3))))
    found = suggestion(KEYS, 73, fitting(needing(0, 24, 0, 9), quick, needing(48, 72, 0, 60)))
    assert found.detail == "Fast motion 34–39"


def test_a_camera_that_is_jerked_is_no_fast_motion_of_the_body() -> None:
    track = needing(24, 48, 5, 37)
    jerk = np.cumsum(np.where((np.arange(73) > 34) & (np.arange(73) < 40), 0.1, 0.0))
    turns = exp_rotation(jerk[:, None] * np.array([0.0, -1.0, 0.0]))
    path = CameraPath.of(turns, np.zeros((73, 3)), np.ones(73))
    stays = Trajectory(24, np.tile(np.eye(3), (25, 2, 1, 1)), np.full((25, 3), 2.0))
    track = replace(track, trajectory=stays.carried(path.between(24, 48).Ts_camera_world))
    still, moved = (JudgedSegments({track.span: track}, path=one) for one in (None, path))
    assert fast_about(still.in_world(track), 37) is not None
    assert fast_about(moved.in_world(track), 37) is None


def test_asking_for_what_is_expected_to_be_mended_comes_to_an_end() -> None:
    for floor_px in (0.0, 2.0):
        keys, asked = [0, 48], 0
        while True:
            spans = list(pairwise(keys))
            some = {(a, b): needing(a, b, floor_px + 0.1 * (b - a), (a + b) // 2) for a, b in spans}
            found = suggestion(keys, 49, some)
            if found.kind != "key":
                break
            assert found.frame is not None
            keys, asked = sorted({*keys, found.frame}), asked + 1
        assert found.kind == "good"
        assert asked < 9


def test_results_that_do_not_show_what_could_be_mended_are_judged_as_before() -> None:
    some = fitting(
        needing(0, 24, 5, 9), judged(24, 48, Verdict.check("not_seen", (26, 41), "left_hand"))
    )
    assert suggestion(KEYS, 73, some).frame == 34


def test_the_middle_is_that_of_the_interval_one_stands_in() -> None:
    assert middle(KEYS, 5) == 12
    assert middle(KEYS, 24) == 36
    assert middle(KEYS, 72) == 60
    assert middle(KEYS, 80) is None
    assert middle((3, 4), 3) is None
    assert middle((), 3) is None
    assert middle((3,), 3) is None
