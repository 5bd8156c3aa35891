"""What keypoints tell of wrong joints: more distance, less sight, more disagreement, more doubt."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.tracker.body.angle_errors import MEDIAN_OF_SIGMA
from keypose.tracker.tracking.cues.joint_evidence import (
    FITTED,
    FOOT_OWN,
    GOOD,
    LOST,
    POSED_M,
    POSED_S,
    USUAL_M,
    JointEvidence,
    Sight,
)


def _evidence(
    *, distance: float = 0.01, visibility: float = 0.95, apart: float = 0.005,
    drift: float = 0.001, frames: int = 5,
) -> JointEvidence:  # fmt: skip
    shape = (frames, 3)
    return JointEvidence(
        np.array([1, 1, 4]), np.full(shape, distance), np.full(shape, visibility),
        np.full(shape, apart), np.full(shape, drift), 200.0,
    )  # fmt: skip


@pytest.mark.parametrize("worse", [{"apart": 0.08}, {"drift": 0.003}, {"frames": 41}])
def test_each_doubt_makes_a_larger_error_likely(worse: dict[str, Any]) -> None:
    doubted, plain = _evidence(**worse), _evidence()
    middle = len(doubted.error) // 2
    assert doubted.error[middle, 0] > 1.15 * plain.error[2, 0]


@pytest.mark.parametrize("worse", [{"distance": 0.06}, {"distance": np.nan}])
def test_keypoints_elsewhere_say_nothing_beside_two_starts_and_all_beside_one(
    worse: dict[str, float],
) -> None:
    np.testing.assert_array_equal(_evidence(**worse).error, _evidence().error)
    assert _evidence(**worse, apart=np.nan).error[2, 0] > 1.1 * _evidence(apart=np.nan).error[2, 0]


def test_what_agrees_is_trusted_and_what_does_not_is_not() -> None:
    assert _evidence(apart=0.002, drift=0.0003).error.max() < GOOD
    assert _evidence(apart=0.15, drift=0.04).error[2].min() > LOST


def test_nothing_is_told_to_be_off_by_much_less_than_keyframes_and_keypoints_are_themselves() -> (
    None
):
    drift = np.geomspace(1e-4, 1e-1, 61)
    error = FITTED.median(np.full(61, 0.002), drift, np.full(61, 8.0))
    assert (np.diff(error) > 0).all()
    assert 0.6 * FITTED.floor < error[0] < FITTED.floor < error[-1]
    steps = np.diff(np.log(error)) / np.diff(np.log(drift + 1e-4))
    assert steps[0] == pytest.approx(FITTED.below * FITTED.by_drift)
    assert steps[-1] == pytest.approx(FITTED.by_drift)


def test_a_joint_that_strays_for_a_moment_is_in_doubt_around_it_and_no_other_is() -> None:
    calm, evidence = _evidence(frames=41), _evidence(frames=41)
    evidence.drift[20, 1] = 0.1
    error = evidence.error
    assert (error[18:23, 1] > 3 * calm.error[18:23, 1]).all()
    np.testing.assert_allclose(error[[5, 35]], calm.error[[5, 35]])
    np.testing.assert_array_equal(error[:, [0, 2]], calm.error[:, [0, 2]])


def test_from_one_start_only_a_joint_near_its_keypoint_is_trusted_and_one_far_from_it_is_not() -> (
    None
):
    near, far = _evidence(apart=np.nan), _evidence(distance=0.1, apart=np.nan)
    assert 0.0 < near.error[2, 0] < 0.015
    assert far.error[2, 0] > 2 * near.error[2, 0]


def test_at_keyframes_nothing_is_wrong_and_a_part_is_as_doubtful_as_its_worst_joint() -> None:
    evidence = _evidence()
    evidence.drift[2, 1] = 0.02
    error = evidence.expected_error(6)
    assert not error[[0, -1]][:, [1, 4]].any()
    assert 0 < error[2, 4] < error[2, 1]
    assert np.isnan(error[:, [0, 2, 3, 5]]).all()


def test_a_part_is_told_to_be_off_by_as_much_as_its_worst_joint() -> None:
    evidence = _evidence()
    evidence.drift[2, 0] = 0.02
    assert evidence.expected_error(6)[2, 1] == evidence.error[2, 0] > evidence.error[2, 1]


def test_near_a_keyframe_whose_depth_was_posed_less_is_expected_along_the_view() -> None:
    """As surely as a person poses it there, as unsure as the network once that is long ago."""
    sigma_m = np.full((5, 3), 0.1)
    evidence = replace(_evidence(), depth_sigma_m=sigma_m)
    drafted = evidence.expected_depth_m(6)
    to_posed_s = np.array([0.0, 0.5, 1.0, 2.0, np.inf])[:, None] * POSED_S * np.ones(6)
    posed = evidence.expected_depth_m(6, to_posed_s)
    assert drafted is not None
    assert posed is not None
    far = drafted[0, 4]
    assert drafted[:, 4] == pytest.approx(far)
    assert USUAL_M < far < MEDIAN_OF_SIGMA * 0.1, "what is far is less far than it seems"
    half = np.hypot(far / 2, POSED_M / 2)
    assert posed[:, 4] == pytest.approx([POSED_M, half, far, far, far])
    near = replace(_evidence(), depth_sigma_m=sigma_m / 5).expected_depth_m(6)
    assert near is not None
    assert near[0, 4] == pytest.approx(MEDIAN_OF_SIGMA * 0.02)
    assert _evidence().expected_depth_m(6, to_posed_s) is None


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


def test_a_segment_is_good_where_joints_are_expected_to_be_off_by_little_and_none_by_much() -> None:
    assert _evidence(apart=0.001, drift=0.0003, frames=21).is_good
    assert not _evidence(apart=0.02, drift=0.006, frames=21).is_good
    slightly, badly = (_evidence(apart=0.001, drift=0.0003, frames=91) for _ in range(2))
    slightly.drift[40:43, 1], badly.drift[40:43, 1] = 0.004, 0.1
    assert slightly.is_good
    assert not badly.is_good, "in the mean it is off by as little"


@pytest.mark.parametrize(("astray", "is_lost"), [(15, True), (5, True), (2, False)])
def test_it_is_lost_where_many_joints_are_far_off_and_not_where_a_limb_is(
    astray: int, is_lost: bool
) -> None:
    away, seen, calm = np.full((3, 21, 15), np.array([0.01, 0.9, 0.001])[:, None, None])
    apart, drift = np.full((2, 21, 15), 0.002)
    apart[:, :astray], drift[:, :astray] = 0.3, 0.1
    found = JointEvidence(np.arange(15), away, seen, apart, drift + calm, 200.0)
    assert found.is_lost is is_lost
    assert not found.is_good


def test_shares_of_the_height_are_judged_alike_whatever_the_size_of_the_picture() -> None:
    small = _evidence(apart=0.001, drift=0.0003, frames=21)
    assert small.is_good == replace(small, height_px=1600).is_good


def test_between_neighbouring_keyframes_nothing_can_be_off() -> None:
    nothing = _evidence(apart=0.2, drift=0.2, frames=2)
    assert nothing.is_good
    assert not nothing.is_lost


def with_feet(distance: list[float | None]) -> JointEvidence:
    """A toe of part 5 so far from its keypoint, frame by frame; None: not seen."""
    plain = _evidence(frames=len(distance))
    away = np.array([[np.nan if each is None else each] for each in distance])
    return replace(plain, foot_distance=away, foot_parts=np.array([5]))


def test_a_foot_that_is_seen_elsewhere_for_a_while_is_off_by_what_keypoints_are_not() -> None:
    hangs = with_feet([0.01] + [0.08] * 29 + [0.01])
    errors = hangs.expected_foot_error(6)
    assert errors[15, 5] == pytest.approx(np.sqrt(0.08**2 - FOOT_OWN**2))
    assert errors[[0, -1], 5].tolist() == [0.0, 0.0]  # keyframes
    assert np.isnan(errors[:, :5]).all()
    assert with_feet([0.015] * 31).expected_foot_error(6)[:, 5].max() == 0.0
    once = with_feet([0.01] * 15 + [0.3] + [0.01] * 15)
    assert once.expected_foot_error(6)[:, 5].max() == 0.0, "an outlier of one frame"
    assert np.isnan(with_feet([None] * 31).expected_foot_error(6)).all()
    assert np.isnan(_evidence().expected_foot_error(6)).all()


SIGHT = np.array([10])
"""The part that carries the one joint of these cases."""


def one_joint(distance: float, visibility: float, depth_sigma_m: float = np.nan) -> JointEvidence:
    """A joint in ten frames."""
    shape = (10, 1)
    return JointEvidence(
        SIGHT,
        np.full(shape, distance),
        np.full(shape, visibility),
        np.full(shape, np.nan),
        np.zeros(shape),
        200.0,
        depth_sigma_m=np.full(shape, depth_sigma_m),
    )


def sight(distance: float, visibility: float, depth_sigma_m: float) -> Sight:
    """The same joint in another film."""
    shape = (10, 1)
    return Sight(
        SIGHT,
        np.full(shape, distance),
        np.full(shape, visibility),
        np.full(shape, depth_sigma_m),
    )


@pytest.mark.parametrize(
    ("own", "beside", "distance", "visibility", "depth_sigma_m"),
    [
        ((np.nan, 0.0, np.nan), (0.01, 0.9, 0.03), 0.01, 0.9, 0.03),
        ((0.01, 0.9, 0.1), (np.nan, 0.0, np.inf), 0.01, 0.9, 0.1),
        ((0.01, 0.9, 0.1), (0.01, 0.9, 0.1), 0.01, 0.9, 0.1 / np.sqrt(2)),
        ((0.01, 0.1, np.nan), (0.08, 1.0, 0.02), 0.0796, 1.0, 0.02),
    ],
    ids=["hidden in the first", "hidden in the other", "seen by both", "they disagree"],
)
def test_a_joint_that_one_film_hides_is_judged_by_the_other(
    own: tuple[float, float, float],
    beside: tuple[float, float, float],
    distance: float,
    visibility: float,
    depth_sigma_m: float,
) -> None:
    both = one_joint(*own).with_sight(sight(*beside))
    assert both.depth_sigma_m is not None
    np.testing.assert_allclose(both.distance, distance, atol=1e-4)
    np.testing.assert_allclose(both.visibility, visibility)
    np.testing.assert_allclose(both.depth_sigma_m, depth_sigma_m, rtol=1e-9)


def test_a_joint_that_no_film_knows_the_depth_of_stays_unknown() -> None:
    both = one_joint(0.01, 0.9).with_sight(sight(0.01, 0.9, np.inf))
    assert both.depth_sigma_m is not None
    assert np.isnan(both.depth_sigma_m).all()
