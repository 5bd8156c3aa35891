"""What keypoints tell of wrong joints: more distance, less sight, more disagreement, more doubt."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.tracking.cues.joint_evidence import RIGHT_ERROR, WRONG_ERROR, JointEvidence


def _evidence(
    distance: float = 0.01, visibility: float = 0.95, apart: float = 0.01, frames: int = 5
) -> JointEvidence:
    shape = (frames, 3)
    return JointEvidence(
        np.array([1, 1, 4]), np.full(shape, distance), np.full(shape, visibility),
        np.full(shape, apart), 200.0,
    )  # fmt: skip


@pytest.mark.parametrize(
    "worse", [{"distance": 0.06}, {"visibility": 0.1}, {"apart": 0.08}, {"distance": np.nan}]
)
def test_each_doubt_makes_a_wrong_joint_more_likely(worse: dict[str, float]) -> None:
    assert _evidence(**worse).wrong[2, 0] > 1.2 * _evidence().wrong[2, 0]


def test_what_agrees_is_trusted_and_what_does_not_is_not() -> None:
    assert _evidence(0.004, 0.99, 0.002).wrong.max() < 0.02
    assert _evidence(0.10, 0.1, 0.15).wrong[2].min() > 0.8


def test_a_joint_that_strays_for_a_moment_is_in_doubt_around_it_and_no_other_is() -> None:
    shape = (41, 3)
    evidence = JointEvidence(
        np.array([1, 1, 4]), np.full(shape, 0.01), np.full(shape, 0.95), np.full(shape, 0.01), 200.0
    )
    calm = evidence.wrong
    evidence.distance[20, 1] = 0.1
    wrong = evidence.wrong
    assert (wrong[18:23, 1] > 3 * calm[18:23, 1]).all()
    np.testing.assert_array_equal(wrong[[5, 35]], calm[[5, 35]])
    np.testing.assert_array_equal(wrong[:, [0, 2]], calm[:, [0, 2]])


def test_from_one_start_only_a_joint_near_its_keypoint_is_trusted_and_one_far_from_it_is_not() -> (
    None
):
    near, far = _evidence(apart=np.nan), _evidence(0.1, 0.2, np.nan)
    assert 0.0 < near.wrong[2, 0] < 0.05
    assert far.wrong[2, 0] > 5 * near.wrong[2, 0]


def test_at_keyframes_nothing_is_wrong_and_a_part_is_as_doubtful_as_its_worst_joint() -> None:
    evidence = _evidence()
    evidence.distance[2, 1] = 0.2
    error = evidence.expected_error(6)
    assert not error[[0, -1]][:, [1, 4]].any()
    assert RIGHT_ERROR < error[2, 4] < error[2, 1] < WRONG_ERROR
    assert np.isnan(error[:, [0, 2, 3, 5]]).all()


def test_a_keyframe_is_doubted_where_a_joint_is_seen_well_and_elsewhere() -> None:
    evidence, limbs = _evidence(frames=21), np.array([False, False, False, False, True])
    assert evidence.keyed_wrong(limbs) is None
    evidence.distance[10, 2] = 0.2  # between the keyframes
    evidence.distance[0, 1] = 0.2  # a shoulder
    assert evidence.keyed_wrong(limbs) is None
    evidence.distance[20, 2] = 0.06
    assert evidence.keyed_wrong(limbs) == (20, 2)
    evidence.visibility[20, 2] = 0.4
    assert evidence.keyed_wrong(limbs) is None


def test_a_keyframe_is_not_doubted_where_its_keypoint_stays_elsewhere() -> None:
    evidence, limbs = _evidence(frames=21), np.array([False, False, False, False, True])
    evidence.distance[:3, 2] = 0.08, 0.06, 0.01
    assert evidence.keyed_wrong(limbs) == (0, 2)
    evidence.distance[2:4, 2] = 0.06
    assert evidence.keyed_wrong(limbs) is None


def test_a_segment_agrees_where_both_starts_led_to_about_the_same_whatever_keypoints_say() -> None:
    assert _evidence(apart=0.001, frames=21).agreed
    assert _evidence(distance=0.05, visibility=0.3, apart=0.001, frames=21).agreed
    assert not _evidence(apart=0.003, frames=21).agreed
    assert _evidence(apart=0.0014, frames=21).agreed
    assert not _evidence(apart=0.0014, frames=91).agreed  # errors grow with the distance


def test_nothing_is_known_of_agreement_where_there_was_one_start() -> None:
    assert _evidence(apart=np.nan, frames=21).agreed is None
    assert _evidence(frames=2).agreed
