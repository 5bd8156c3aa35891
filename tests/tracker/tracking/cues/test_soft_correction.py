"""Drift correction over soft anchors: keyframes exact, limbs where the keypoints are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import exp_rotation, log_rotation, transpose
from keypose.tracker.solver.least_squares import QUICK
from keypose.tracker.solver.motion_problem import MotionProblem
from keypose.tracker.solver.robust import SQUARED, Cauchy
from keypose.tracker.tracking.cues.anchors import Anchors
from keypose.tracker.tracking.cues.keypoint_start import from_keypoints
from keypose.tracker.tracking.cues.soft_correction import Correction, measured_increments
from keypose.tracker.tracking.drift import Doubt, Motions, closing_error, correct_drift
from tests.tracker.tracking.cues.people import SKELETON, Filmed, joints_apart_m, moving


def _correction(film: Filmed, open_end: bool = False) -> Correction:
    return Correction(film.free, film.segment, film.anchors()[0], open_end)


def _drifting(truth: Trajectory, seed: int = 4, size: float = 0.004) -> Motions:
    """The true motion of every step, each a little off in the same way."""
    rng = np.random.default_rng(seed)
    off = rng.normal(0, size, (SKELETON.part_count, 3))
    tracked = np.isin(np.arange(SKELETON.part_count), SKELETON.dof_part)
    off[~tracked] = 0.0
    steps = transpose(truth.Rs_parent_part[:-1]) @ truth.Rs_parent_part[1:] @ exp_rotation(off)
    return Motions(
        truth.Rs_parent_part[:-1] @ steps,
        truth.ps_camera_root[1:] + rng.normal(0, size, 3),
        Doubt.equal(len(truth) - 1, SKELETON.part_count),
    )


def test_without_keypoints_it_is_the_drift_correction_of_the_paper() -> None:
    """What is missing at the second keyframe is spread evenly over steps of equal doubt."""
    film = Filmed(moving())
    first, last = film.truth.first_frame, film.truth.last_frame
    plain = film.segment.interpolated()
    rng = np.random.default_rng(5)
    off = rng.normal(0, 0.004, (SKELETON.part_count, 3))
    off[~np.isin(np.arange(SKELETON.part_count), SKELETON.dof_part)] = 0.0
    off[0] = 0.0  # the paper carries the root along with its uncorrected turns
    R = plain.Rs_parent_part
    motions = Motions(
        R[:-1] @ (transpose(R[:-1]) @ R[1:] @ exp_rotation(off)),
        plain.ps_camera_root[1:] + 0.003,
        Doubt.equal(last - first, SKELETON.part_count),
    )
    printed = correct_drift(plain, motions, film.segment.end).trajectory
    bare = replace(_correction(film), anchors=_nothing(film))
    measured = measured_increments(film.free, plain, motions)
    problem = bare.problem((replace(measured, kernel=SQUARED),), SQUARED, None)
    found = _solved(problem, plain)
    turn = np.linalg.norm(
        log_rotation(transpose(printed.Rs_parent_part) @ found.Rs_parent_part), axis=-1
    )
    tracked = np.unique(SKELETON.dof_part)
    assert turn[:, tracked].max() < 2e-4
    assert np.abs(printed.ps_camera_root - found.ps_camera_root).max() < 2e-4
    assert np.linalg.norm(log_rotation(transpose(R) @ found.Rs_parent_part), axis=-1).max() < 0.02


def _nothing(film: Filmed) -> Anchors:
    anchors = film.anchors()[0]
    return replace(anchors, scale=0 * anchors.scale, depth_scale=0 * anchors.depth_scale)


def _solved(problem: MotionProblem, start: Trajectory) -> Trajectory:
    return problem.solve(start, replace(QUICK, most_steps=30, settled=1e-7, gain=0.0))


def test_both_keyframes_stay_exactly_where_they_were_posed() -> None:
    film = Filmed(moving())
    measured = measured_increments(film.free, film.truth, _drifting(film.truth))
    found = _correction(film).solve(film.segment.interpolated(), (measured,), Cauchy())
    assert closing_error(found, film.segment.start, film.segment.end) == 0.0


@pytest.mark.parametrize("size", [0.05, 0.9, 1.6], ids=["near identity", "swinging", "far"])
def test_keypoints_alone_bring_limbs_to_where_they_were(size: float) -> None:
    film = Filmed(moving(size=size))
    found = from_keypoints(_correction(film))
    assert closing_error(found, film.segment.start, film.segment.end) == 0.0
    away = joints_apart_m(found, film.truth)
    missed = joints_apart_m(film.segment.interpolated(), film.truth)
    assert away.mean() < 0.05
    assert away.mean() < max(0.25 * missed.mean(), 0.02)


@pytest.mark.parametrize(("count", "size"), [(13, 0.9), (25, 2.2)], ids=["swinging", "far"])
def test_what_no_keypoint_turns_goes_evenly_from_keyframe_to_keyframe(
    count: int, size: float
) -> None:
    """Hands and feet do not stay as they were at the first keyframe, and leap at the second: not
    where keypoints are followed frame by frame either, as from far."""
    film = Filmed(moving(count, size))
    start, end = film.segment.start, film.segment.end
    hand, foot = (SKELETON.body.index(name) for name in ("left_hand", "right_foot"))
    R = end.Rs_parent_part.copy()
    R[[hand, foot]] = exp_rotation(np.array([[0.9, 0.0, 0.3], [0.0, 0.5, 0.0]]))
    found = from_keypoints(_correction(film.keyed(start, replace(end, Rs_parent_part=R))))
    R = found.Rs_parent_part[:, [hand, foot]]
    steps = np.linalg.norm(log_rotation(transpose(R[:-1]) @ R[1:]), axis=-1)
    np.testing.assert_allclose(steps, np.broadcast_to(steps.mean(axis=0), steps.shape), atol=1e-6)


def test_drift_is_taken_out_between_keyframes_too_not_only_at_the_second() -> None:
    film = Filmed(moving(25))
    motions = _drifting(film.truth, size=0.02)
    printed = correct_drift(film.truth, motions, film.segment.end).trajectory
    measured = measured_increments(film.free, film.truth, motions)
    soft = _correction(film).solve(film.truth, (measured,), Cauchy())
    assert (
        joints_apart_m(soft, film.truth).mean() < 0.5 * joints_apart_m(printed, film.truth).mean()
    )


def test_an_open_end_follows_the_keypoints() -> None:
    film = Filmed(moving())
    start = film.segment.start
    open_ended = film.keyed(start, film.segment.end)
    found = from_keypoints(_correction(open_ended, open_end=True))
    assert joints_apart_m(found, film.truth)[-1].mean() < 0.08
    np.testing.assert_array_equal(found.Rs_parent_part[0], start.Rs_parent_part)


def test_a_keypoint_far_from_all_others_counts_hardly_more_than_one_that_is_not_seen() -> None:
    film = Filmed(moving())
    far, unseen = film.keypoints.uv.copy(), film.keypoints.uv.copy()
    far[6, 4] += (80.0, -60.0)  # a wrist in one frame
    unseen[6, 4] = np.nan
    found, without = (
        from_keypoints(replace(_correction(film), anchors=film.anchors(seen)[0]))
        for seen in (replace(film.keypoints, uv=uv) for uv in (far, unseen))
    )
    assert joints_apart_m(found, without).max() < 0.01
