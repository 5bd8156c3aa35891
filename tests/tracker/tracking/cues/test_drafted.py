"""Keypoints of a draft serve the segments whose keyframes lie on them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.tracking.cues.drafted import DraftedKeypoints
from keypose.tracker.tracking.segment import Segment
from tests.tracker.tracking.cues.people import BENT, SKELETON, Filmed, moving

FILM = Filmed(moving(), BENT)
FIRST = FILM.segment.first_frame
LAST = FILM.segment.last_frame
LOOKED = FILM.keypoints.over(FIRST, FIRST)
"""What comes back where a network looked."""


class Looks:
    def over(
        self, segment: Segment, skeleton: Skeleton, report: Callable[[], None]
    ) -> Keypoints | None:
        return LOOKED

    def at(self, frame: int, skeleton: Skeleton, pose: Pose) -> Keypoints | None:
        return LOOKED

    def beyond(
        self, frame: int, last: int, skeleton: Skeleton, pose: Pose, report: Callable[[], None]
    ) -> Keypoints | None:
        return LOOKED


def moved(pose: Pose, metres: float) -> Pose:
    return replace(pose, p_camera_root=pose.p_camera_root + np.array([metres, 0.0, 0.0]))


def without_a_wrist(drafted: Keypoints) -> Keypoints:
    uv = drafted.uv.copy()
    uv[5, 4] = np.nan
    return replace(drafted, uv=uv)


AS_DRAFTED = FILM.segment
CASES = {
    "both keyframes on the draft": (FILM.keypoints, AS_DRAFTED, True),
    "one mended by a hand's width": (
        FILM.keypoints, replace(AS_DRAFTED, end=moved(AS_DRAFTED.end, 0.1)), True,
    ),
    "left and right exchanged": (FILM.keypoints.exchanged(), AS_DRAFTED, True),
    "one on somebody beside": (
        FILM.keypoints, replace(AS_DRAFTED, end=moved(AS_DRAFTED.end, 0.5)), False,
    ),
    "one behind the camera": (
        FILM.keypoints,
        replace(AS_DRAFTED, end=replace(AS_DRAFTED.end, p_camera_root=np.array([0, 0, -1.0]))),
        False,
    ),
    "a frame not drafted": (FILM.keypoints.over(FIRST, LAST - 1), AS_DRAFTED, False),
    "a frame in which somebody was lost": (without_a_wrist(FILM.keypoints), AS_DRAFTED, False),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_segment_is_tracked_with_the_draft_where_its_keyframes_lie_on_it(name: str) -> None:
    drafted, segment, serves = CASES[name]
    source = DraftedKeypoints(drafted, Looks(), BENT)
    found = source.over(segment, SKELETON, lambda: None)
    expected = drafted if serves else LOOKED
    assert found is not None
    np.testing.assert_array_equal(found.uv, expected.uv)
    assert (found.first_frame, found.last_frame) == (expected.first_frame, expected.last_frame)


def hidden(drafted: Keypoints, *frames: int) -> Keypoints:
    uv = drafted.uv.copy()
    uv[list(frames)] = np.nan
    return replace(drafted, uv=uv)


@pytest.mark.parametrize(
    ("drafted", "segment", "serves"),
    [
        (hidden(FILM.keypoints, 4, 5), AS_DRAFTED, True),
        (hidden(FILM.keypoints, -1), AS_DRAFTED, True),
        (hidden(FILM.keypoints, 0, -1), AS_DRAFTED, False),
        (hidden(FILM.keypoints, 4), replace(AS_DRAFTED, end=moved(AS_DRAFTED.end, 0.5)), True),
        (
            FILM.keypoints,
            replace(
                AS_DRAFTED,
                start=moved(AS_DRAFTED.start, 0.5),
                end=moved(AS_DRAFTED.end, 0.5),
            ),
            False,
        ),
        (FILM.keypoints.over(FIRST, LAST - 1), AS_DRAFTED, False),
    ],
    ids=["between", "at a keyframe", "at both", "a keyframe beside", "both beside", "not drafted"],
)
def test_whoever_was_followed_among_others_and_is_unseen_is_hidden(
    drafted: Keypoints, segment: Segment, serves: bool
) -> None:
    source = DraftedKeypoints(drafted, Looks(), BENT, together=True)
    keypoints = source.over(segment, SKELETON, lambda: None)
    assert keypoints is not None
    assert (keypoints is not LOOKED) == serves


def test_among_others_only_the_frame_whose_keyframe_lies_beside_does_not_count() -> None:
    segment = replace(AS_DRAFTED, end=moved(AS_DRAFTED.end, 0.5))
    source = DraftedKeypoints(FILM.keypoints, Looks(), BENT, together=True)
    keypoints = source.over(segment, SKELETON, lambda: None)
    assert keypoints is not None
    np.testing.assert_array_equal(keypoints.uv[:-1], FILM.keypoints.uv[:-1])
    assert np.isnan(keypoints.uv[-1]).all()
    assert not keypoints.visibility[-1].any()


def test_so_are_one_frame_and_those_that_are_followed_ahead() -> None:
    source, pose = DraftedKeypoints(FILM.keypoints, Looks(), BENT), FILM.truth.pose(FIRST + 2)
    here = source.at(FIRST + 2, SKELETON, pose)
    beside = source.at(FIRST + 2, SKELETON, moved(pose, 1.0))
    assert here is not None
    np.testing.assert_array_equal(here.uv[0], FILM.keypoints.uv[2])
    assert beside is LOOKED
    for last, frames in ((LAST, (FIRST + 2, LAST)), (FIRST, (FIRST, FIRST + 2))):
        ahead = source.beyond(FIRST + 2, last, SKELETON, pose, lambda: None)
        assert ahead is not None
        assert (ahead.first_frame, ahead.last_frame) == frames
    assert source.beyond(FIRST + 2, LAST + 1, SKELETON, pose, lambda: None) is LOOKED


def test_a_body_that_is_no_person_is_looked_for() -> None:
    box = Skeleton.of(preset("box"))
    pose = Pose.rest(box, (0.0, 0.0, 4.0))
    source = DraftedKeypoints(FILM.keypoints, Looks(), BENT)
    assert source.at(FIRST, box, pose) is LOOKED
