"""What tracking found, laid side by side, cut out again, and kept with what is not known."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.trajectory import Pass
from keypose.tracker.tracking.result import COLUMNS, Diagnostics, SegmentResult, side_by_side
from tests.tracker import session_cases as cases

PARTS = 3
DOFS = 5


def measured(frames: int, gain: bool = True) -> Diagnostics:
    """Every array with numbers of its own."""
    rng = np.random.default_rng(frames)
    steps = frames - 1
    return Diagnostics(
        rank=rng.integers(0, DOFS, steps),
        singular_values=rng.uniform(size=(steps, DOFS)),
        observability=rng.uniform(size=(steps, PARTS)),
        residual=rng.uniform(size=(steps, PARTS)),
        expected_gain=rng.uniform(size=frames) if gain else None,
    )


def assert_equal(one: Diagnostics, other: Diagnostics) -> None:
    for column in COLUMNS:
        np.testing.assert_array_equal(one.rows(column), other.rows(column))


def test_pieces_lie_where_they_begin_and_nothing_is_known_between_them() -> None:
    laid = side_by_side([(1, np.array([1.0, 2.0])), (4, np.array([5.0]))], 6)
    np.testing.assert_array_equal(laid, [np.nan, 1, 2, np.nan, 5, np.nan])


def test_what_reaches_beyond_the_rows_is_left_out() -> None:
    rows = np.arange(5.0)
    np.testing.assert_array_equal(side_by_side([(-2, rows)], 2), [2, 3])
    np.testing.assert_array_equal(side_by_side([(1, rows)], 3), [np.nan, 0, 1])
    np.testing.assert_array_equal(side_by_side([(9, rows), (-9, rows)], 2), [np.nan, np.nan])


def test_of_two_pieces_that_overlap_the_later_one_stands() -> None:
    laid = side_by_side([(0, np.zeros((3, 2))), (2, np.ones((2, 2)))], 4, (2,))
    np.testing.assert_array_equal(laid[:, 0], [0, 0, 1, 1])


def test_segments_side_by_side_are_found_again_where_they_were_laid() -> None:
    one, other = measured(5), measured(4)
    whole = Diagnostics.side_by_side([(0, one), (6, other)], 10, PARTS, DOFS)
    assert_equal(whole.between(0, 4), one)
    assert_equal(whole.between(6, 9), other)
    gap = whole.between(4, 6)
    assert (gap.rank == -1).all()
    assert np.isnan(gap.residual).all()


def test_what_lies_beyond_the_measured_frames_is_unknown() -> None:
    wider = measured(5).between(-2, 6)
    assert len(wider.rank) == 8
    assert wider.rank[:2].tolist() == wider.rank[6:].tolist() == [-1, -1]
    assert_equal(wider.between(2, 6), measured(5))


def test_an_array_that_no_segment_knows_is_not_there() -> None:
    whole = Diagnostics.side_by_side([(0, measured(5, gain=False))], 5, PARTS, DOFS)
    assert whole.expected_gain is None


def test_an_array_known_of_a_part_of_the_frames_is_not_that_of_the_segment() -> None:
    whole = Diagnostics.side_by_side(
        [(0, measured(5)), (4, measured(4, gain=False))], 8, PARTS, DOFS
    )
    assert whole.between(0, 4).complete().expected_gain is not None
    assert whole.between(4, 7).complete().expected_gain is None


def test_arrays_cannot_be_written_to() -> None:
    for _, rows in measured(5).arrays():
        with pytest.raises(ValueError, match="read-only"):
            rows[...] = 0


def test_a_trajectory_on_the_way_has_no_verdict_and_nothing_measured() -> None:
    path = cases.segment(4, 8).trajectory
    found = SegmentResult.on_the_way(Pass("pass", path, 2.5), "key", "preview")
    assert (found.span, found.key, found.quality) == ((4, 8), "key", "preview")
    assert not found.finished
    assert found.scores == (2.5,)
    assert np.isnan(found.diagnostics.observability).all()


def test_frames_that_were_not_reached_have_no_pose_of_their_own() -> None:
    found = SegmentResult(
        cases.segment(0, 4).trajectory, None, measured(5), unreached=(2, 3)
    )  # fmt: skip
    assert found.tracked.tolist() == [True, True, False, False, True]
    ps = found.where_tracked(found.trajectory.ps_camera_root)
    assert np.isnan(ps[2:4]).all()
    assert np.isfinite(ps[[0, 1, 4]]).all()
