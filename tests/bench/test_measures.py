"""What the benchmark of real clips measures and disturbs is what it says."""

from __future__ import annotations

import numpy as np
import pytest

from bench.keyed import JITTER_M, JITTER_RAD, jittered
from bench.measures import Over, jitter_px, root_relative
from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import log_rotation, transpose


def test_a_steady_path_does_not_jitter_however_fast_it_is() -> None:
    path = np.arange(20.0)[:, None] * (3.0, -7.0)
    assert jitter_px([path]) == pytest.approx(0.0, abs=1e-9)


def test_a_path_that_alternates_jitters_by_four_times_its_amplitude() -> None:
    path = np.zeros((30, 2))
    path[:, 0] = 0.5 * (-1.0) ** np.arange(30)
    assert jitter_px([path]) == pytest.approx(2.0)


def test_the_jitter_of_white_noise_is_what_second_differences_make_of_it() -> None:
    paths = np.random.default_rng(0).normal(0.0, 0.3, (4, 20_000, 2))
    assert jitter_px(list(paths)) == pytest.approx(0.3 * np.sqrt(2 * 6), rel=0.02)


def test_keyframes_are_disturbed_by_half_a_degree_and_three_millimetres() -> None:
    skeleton = Skeleton.of(preset("adult_male"))
    pose = Pose.rest(skeleton, (0.0, 0.0, 3.0))
    moved = jittered(skeleton, {frame: pose for frame in range(400)}, seed=5)
    turns = [
        log_rotation(transpose(pose.Rs_parent_part) @ p.Rs_parent_part) for p in moved.values()
    ]
    shifts = [p.p_camera_root - pose.p_camera_root for p in moved.values()]
    assert np.std(turns) == pytest.approx(JITTER_RAD, rel=0.03)
    assert np.degrees(JITTER_RAD) == pytest.approx(0.5)
    assert np.std(shifts) == pytest.approx(JITTER_M, rel=0.06)
    assert np.abs(np.mean(shifts)) < 0.0005


def test_a_keyframe_is_disturbed_alike_whatever_keyframes_are_beside_it() -> None:
    skeleton = Skeleton.of(preset("adult_male"))
    pose = Pose.rest(skeleton, (0.0, 0.0, 3.0))
    alone = jittered(skeleton, {30: pose}, seed=1)[30]
    among = jittered(skeleton, {0: pose, 30: pose, 60: pose}, seed=1)
    assert (alone.Rs_parent_part == among[30].Rs_parent_part).all()
    assert (alone.p_camera_root != among[60].p_camera_root).any()


def test_where_the_hips_are_does_not_count_seen_from_the_hips() -> None:
    joints = np.random.default_rng(2).normal(size=(5, 3, 3))
    names = ("LHip", "RHip", "LKnee")
    assert root_relative(names, joints + np.arange(3.0), joints) == pytest.approx(0.0, abs=1e-12)
    off = joints.copy()
    off[:, 2, 2] += 0.3
    assert root_relative(names, off, joints) == pytest.approx(0.1)


def test_a_figure_is_shown_with_its_spread() -> None:
    assert str(Over((5.0, 3.0, 9.0))) == "5.0 (3.0–9.0)"
