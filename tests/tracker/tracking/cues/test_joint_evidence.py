"""What keypoints tell of wrong joints: more distance, less sight, more disagreement, more doubt."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.tracker.tracking.cues.joint_evidence import WRONG, JointEvidence


def _evidence(
    *, distance: float = 0.01, visibility: float = 0.95, apart: float = 0.005,
    drift: float = 0.001, frames: int = 5,
) -> JointEvidence:  # fmt: skip
    shape = (frames, 3)
    return JointEvidence(
        np.array([1, 1, 4]), np.full(shape, distance), np.full(shape, visibility),
        np.full(shape, apart), np.full(shape, drift), 200.0,
    )  # fmt: skip


@pytest.mark.parametrize("worse", [{"apart": 0.08}, {"drift": 0.003}, {"frames": 21}])
def test_each_doubt_makes_a_larger_error_likely(worse: dict[str, Any]) -> None:
    doubted, plain = _evidence(**worse), _evidence()
    middle = len(doubted.error) // 2
    assert doubted.error[middle, 0] > 1.2 * plain.error[2, 0]
    assert doubted.wrong[middle, 0] > 1.2 * plain.wrong[2, 0]


@pytest.mark.parametrize("worse", [{"distance": 0.06}, {"visibility": 0.1}, {"distance": np.nan}])
def test_keypoints_elsewhere_say_nothing_beside_two_starts_and_all_beside_one(
    worse: dict[str, float],
) -> None:
    np.testing.assert_array_equal(_evidence(**worse).error, _evidence().error)
    assert _evidence(**worse, apart=np.nan).error[2, 0] > 1.1 * _evidence(apart=np.nan).error[2, 0]


def test_what_agrees_is_trusted_and_what_does_not_is_not() -> None:
    assert _evidence(apart=0.002, drift=0.0003).wrong.max() < 0.02
    assert _evidence(apart=0.15, drift=0.04).wrong[2].min() > 0.8


def test_a_joint_is_as_likely_wrong_as_right_whose_median_error_is_the_limit() -> None:
    drifting = [_evidence(drift=drift) for drift in np.geomspace(1e-4, 1e-1, 41)]
    error = np.array([evidence.error[2, 1] for evidence in drifting])
    wrong = np.array([evidence.wrong[2, 1] for evidence in drifting])
    assert error[0] < WRONG < error[-1]
    assert np.interp(WRONG, error, wrong) == pytest.approx(0.5, abs=0.02)
    assert (np.diff(wrong) > 0).all()


def test_a_joint_that_strays_for_a_moment_is_in_doubt_around_it_and_no_other_is() -> None:
    calm, evidence = _evidence(frames=41), _evidence(frames=41)
    evidence.drift[20, 1] = 0.1
    wrong = evidence.wrong
    assert (wrong[18:23, 1] > 3 * calm.wrong[18:23, 1]).all()
    np.testing.assert_allclose(wrong[[5, 35]], calm.wrong[[5, 35]])
    np.testing.assert_array_equal(wrong[:, [0, 2]], calm.wrong[:, [0, 2]])


def test_from_one_start_only_a_joint_near_its_keypoint_is_trusted_and_one_far_from_it_is_not() -> (
    None
):
    near, far = _evidence(apart=np.nan), _evidence(distance=0.1, visibility=0.2, apart=np.nan)
    assert 0.0 < near.wrong[2, 0] < 0.1
    assert far.wrong[2, 0] > 5 * near.wrong[2, 0]


def test_at_keyframes_nothing_is_wrong_and_a_part_is_as_doubtful_as_its_worst_joint() -> None:
    evidence = _evidence()
    evidence.drift[2, 1] = 0.02
    error = evidence.expected_error(6)
    assert not error[[0, -1]][:, [1, 4]].any()
    assert 0 < error[2, 4] < error[2, 1]
    assert np.isnan(error[:, [0, 2, 3, 5]]).all()


def test_the_mean_of_an_error_exceeds_its_median_as_large_ones_are_rarer_and_larger() -> None:
    evidence = _evidence()
    by_part = evidence.expected_error(6)[2, 4]
    assert 1.05 < by_part / evidence.error[2, 2] < 1.5


def test_a_keyframe_is_doubted_where_a_joint_is_seen_well_and_elsewhere() -> None:
    evidence, limbs = _evidence(drift=0.01, frames=21), np.array([False] * 4 + [True])
    assert evidence.keyed_wrong(limbs) is None
    evidence.distance[10, 2] = 0.2  # between the keyframes
    evidence.distance[0, 1] = 0.2  # a shoulder
    assert evidence.keyed_wrong(limbs) is None
    evidence.distance[20, 2] = 0.06
    assert evidence.keyed_wrong(limbs) == (20, 2)
    evidence.visibility[20, 2] = 0.4
    assert evidence.keyed_wrong(limbs) is None


def test_a_keyframe_is_not_doubted_where_its_keypoint_stays_elsewhere() -> None:
    evidence, limbs = _evidence(drift=0.01, frames=21), np.array([False] * 4 + [True])
    evidence.distance[:3, 2] = 0.08, 0.06, 0.01
    assert evidence.keyed_wrong(limbs) == (0, 2)
    evidence.distance[2:4, 2] = 0.06
    assert evidence.keyed_wrong(limbs) is None


def test_a_keyframe_is_not_doubted_where_pictures_agree_with_the_motion_beside_it() -> None:
    evidence, limbs = _evidence(drift=0.001, frames=21), np.array([False] * 4 + [True])
    evidence.distance[20, 2] = 0.06
    assert evidence.keyed_wrong(limbs) is None
    evidence.drift[14:, 2] = 0.02
    assert evidence.keyed_wrong(limbs) == (20, 2)


def test_a_segment_is_good_where_nearly_all_joints_are_expected_to_be_off_by_little() -> None:
    assert _evidence(apart=0.001, drift=0.0003, frames=21).is_good
    assert not _evidence(apart=0.02, drift=0.006, frames=21).is_good
    moment, longer = (_evidence(apart=0.001, drift=0.0003, frames=91) for _ in range(2))
    moment.drift[40, 1] = longer.drift[30:60, 1] = 0.02
    assert moment.is_good
    assert not longer.is_good


def test_marks_on_a_large_person_are_no_finer_than_on_one_400_px_tall() -> None:
    sizes = [replace(_evidence(drift=0.004, frames=21), height_px=h) for h in (200, 400, 1600)]
    assert [evidence.is_good for evidence in sizes] == [True, False, False]
    large = _evidence(apart=0.002, drift=0.0003, frames=21)
    assert replace(large, height_px=1600).is_good


def test_between_neighbouring_keyframes_nothing_can_be_off() -> None:
    assert _evidence(apart=0.2, drift=0.2, frames=2).is_good
