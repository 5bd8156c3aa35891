"""A motion from elsewhere as the start of a segment."""

from __future__ import annotations

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, interpolate
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.tracking.drift import closing_error
from keypose.tracker.tracking.initial.chains import fit_to_keyframes
from tests.tracker.formats import recordings

TRUTH = recordings.trajectory("person")
SKELETON = Skeleton.of(recordings.session("person").subject.body)
START = TRUTH.pose(24)
END = TRUTH.pose(48)


def _off(motion: Trajectory) -> float:
    """Mean distance of the joints from the truth, metres."""
    here = slice(motion.first_frame, motion.last_frame + 1)
    away = motion.joints(SKELETON) - TRUTH.joints(SKELETON)[here]
    return float(np.linalg.norm(away, axis=-1).mean())


def test_it_meets_both_keyframes_however_far_it_lies_from_them() -> None:
    turn = exp_rotation(np.random.default_rng(2).normal(0, 0.2, (SKELETON.part_count, 3)))
    motion = Trajectory(0, TRUTH.Rs_parent_part @ turn, TRUTH.ps_camera_root + 0.4)
    found = fit_to_keyframes(motion, START, END, 24, 48)
    assert found is not None
    assert (found.first_frame, found.last_frame) == (24, 48)
    assert closing_error(found, START, END) < 1e-9
    assert _off(found) < 0.5 * _off(motion)


def test_it_leaves_an_even_motion_as_it_is() -> None:
    even = interpolate(START, END, 24, 48)
    found = fit_to_keyframes(even, START, END, 24, 48)
    assert found is not None
    assert np.allclose(found.joints(SKELETON), even.joints(SKELETON), atol=1e-9)


def test_it_evens_out_jitter() -> None:
    noise = exp_rotation(np.random.default_rng(3).normal(0, 0.05, (73, SKELETON.part_count, 3)))
    jittery = Trajectory(0, TRUTH.Rs_parent_part @ noise, TRUTH.ps_camera_root)
    found = fit_to_keyframes(jittery, START, END, 24, 48)
    assert found is not None
    speeds = [
        np.linalg.norm(np.diff(motion.joints(SKELETON), 2, axis=0), axis=-1).mean()
        for motion in (jittery, found)
    ]
    assert speeds[1] < 0.3 * speeds[0]


def test_it_is_no_start_for_a_segment_that_it_does_not_reach() -> None:
    short = Trajectory(25, TRUTH.Rs_parent_part[25:], TRUTH.ps_camera_root[25:])
    assert fit_to_keyframes(short, START, END, 24, 48) is None
    assert fit_to_keyframes(short, START, END, 30, 80) is None
    assert fit_to_keyframes(short, TRUTH.pose(25), END, 25, 48) is not None
