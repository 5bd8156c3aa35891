"""Keyframes are moved to where tracking between them stays near to the motion they are from."""

from __future__ import annotations

from itertools import pairwise

import pytest

from keypose.tracker.reduction.tracked import (
    TRACKED_AGAIN,
    Span,
    nearer_by_tracking,
)

HARD = 37


def across_what_is_hard(span: Span) -> float:
    """A segment strays the more, the farther it leads over a frame that shows little."""
    first, last = span
    return 0.01 + 0.01 * max(min(HARD - first, last - HARD), 0)


def test_the_keyframes_beside_the_worst_segment_are_moved_until_it_is_near_enough() -> None:
    path = (0, 20, 40, 60)
    found = nearer_by_tracking(path, across_what_is_hard, 0.02)
    assert len(found.frames) == len(path)
    assert (found.frames[0], found.frames[-1]) == (0, 60)
    assert found.worst_m <= 0.02 < found.before_m
    assert found.deviations_m == tuple(map(across_what_is_hard, pairwise(found.frames)))


def test_keyframes_that_are_near_enough_or_have_to_stay_are_not_moved() -> None:
    path = (0, 20, 40, 60)
    near = nearer_by_tracking(path, across_what_is_hard, 0.05)
    fixed = nearer_by_tracking(path, across_what_is_hard, 0.02, fixed={20, 40})
    assert near.frames == fixed.frames == path
    assert fixed.worst_m == fixed.before_m


def test_no_keyframe_goes_to_a_frame_without_a_pose_nor_too_far_from_the_next_one() -> None:
    path = (0, 20, 40, 60)
    odd = nearer_by_tracking(path, across_what_is_hard, 0.0, allowed=lambda frame: frame % 2 == 0)
    assert all(frame % 2 == 0 for frame in odd.frames)
    near = nearer_by_tracking(path, across_what_is_hard, 0.0, longest=21)
    assert max(b - a for a, b in pairwise(near.frames)) <= 21


def test_no_more_is_tracked_than_is_allowed_and_nothing_twice() -> None:
    tracked: list[Span] = []

    def restless(span: Span) -> float:
        tracked.append(span)
        return 0.03 + 0.001 * ((7 * span[0] + 3 * span[1]) % 11)

    reported: list[tuple[int, int]] = []
    path = tuple(range(0, 201, 20))
    found = nearer_by_tracking(
        path, restless, 0.0, progress=lambda done, most: reported.append((done, most))
    )
    assert len(tracked) == len(set(tracked)) == len(reported)
    assert sum(b - a for a, b in tracked) <= (1 + TRACKED_AGAIN) * 200
    assert all(done < most == 600 for done, most in reported)
    assert found.worst_m <= found.before_m


def test_what_progress_raises_ends_the_work() -> None:
    def stop(_done: int, _most: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        nearer_by_tracking((0, 20), across_what_is_hard, 0.0, progress=stop)
