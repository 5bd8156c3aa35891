"""Keypoints of a clip, prepared: what is known, where frames belong together, where joints are."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.modify import with_clavicles
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.fitting.draft.observed import (
    ENDS,
    FEWEST_SEEN,
    GAP,
    POINTS,
    SEEN,
    SIDES,
    Joints,
    Observed,
    place_of,
    turning_ends,
)
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from tests.tracker.fitting.draft.clips import BODY, CAMERA, place, standing, walk

COUNT = 30


def observed(
    blind: Collection[int] = (),
    shift: dict[int, float] | None = None,
    changes: Collection[int] = (),
) -> Observed:
    """A walk of which some frames show nobody; from some on it is so many pixels aside."""
    keypoints = walk(COUNT).keypoints
    uv, visibility = keypoints.uv.copy(), keypoints.visibility.copy()
    for frame, by in (shift or {}).items():
        uv[frame:, :, 0] += by
    uv[list(blind)], visibility[list(blind)] = np.nan, 0.0
    return Observed.of(replace(keypoints, uv=uv, visibility=visibility), CAMERA, changes)


# --- frames that belong together


@pytest.mark.parametrize(
    ("blind", "shift", "changes", "runs"),
    [
        ((), {}, (), [(0, 30)]),
        (range(4), {}, (), [(4, 30)]),
        (range(10, 10 + GAP), {}, (), [(0, 30)]),
        (range(10, 11 + GAP), {}, (), [(0, 10), (11 + GAP, 30)]),
        ((), {12: 300.0}, (), [(0, 12), (12, 30)]),
        ((), {12: 300.0, 20: -300.0}, (), [(0, 12), (12, 20), (20, 30)]),
        ((), {12: 20.0}, (), [(0, 30)]),
        ((), {}, (9,), [(0, 9), (9, 30)]),
        (range(9, 11), {}, (9,), [(0, 9), (11, 30)]),
        (range(COUNT), {}, (5,), []),
    ],
    ids=[
        *("whole", "late", "short gap", "long gap", "jump", "there and back", "a step"),
        *("another person", "another person after a gap", "nobody"),
    ],
)  # fmt: skip
def test_a_run_ends_where_nobody_is_seen_for_long_or_another_person_may_begin(
    blind: Collection[int],
    shift: dict[int, float],
    changes: Collection[int],
    runs: list[tuple[int, int]],
) -> None:
    found = observed(blind, shift, changes).runs()
    assert [(run.start, run.stop) for run in found] == runs


@pytest.mark.parametrize(("seen", "is_usable"), [(FEWEST_SEEN, True), (FEWEST_SEEN - 1, False)])
def test_a_frame_is_used_from_six_seen_joints_on_and_ends_do_not_count(
    seen: int, is_usable: bool
) -> None:
    keypoints = walk(2).keypoints
    visibility = np.full_like(keypoints.visibility, 1.0)
    visibility[:, seen : len(JOINTS)] = SEEN - 0.01
    made = Observed.of(replace(keypoints, visibility=visibility), CAMERA)
    assert made.usable.tolist() == [is_usable] * 2


def test_rows_keep_their_numbers_in_the_film() -> None:
    whole = observed()
    some = whole.rows(slice(7, 12))
    assert (some.first_frame, len(some)) == (7, 5)
    np.testing.assert_array_equal(some.uv, whole.uv[7:12])
    again = some.rows(slice(1, None))
    assert (again.first_frame, len(again)) == (8, 4)
    assert whole.rows(slice(None, 3)).first_frame == 0


# --- what is known


def test_prepared_keypoints_are_the_same_when_prepared_again() -> None:
    first = observed(blind=(3, 4), shift={12: 300.0})
    again = Observed.of(first.keypoints(), CAMERA.without_distortion())
    for name in ("uv", "known", "visibility", "p_hips", "usable", "jumped", "depth_sigma_m"):
        np.testing.assert_allclose(getattr(again, name), getattr(first, name), atol=1e-9)


def test_a_keypoint_without_pixel_or_depth_is_not_known_and_weighs_nothing() -> None:
    keypoints = walk(3).keypoints
    uv, p_hips = keypoints.uv.copy(), np.array(keypoints.p_hips)
    uv[1, place("left_wrist")] = np.nan
    p_hips[1, place("right_knee"), 2] = np.nan
    made = Observed.of(replace(keypoints, uv=uv, p_hips=p_hips), CAMERA)
    unknown = {(int(n), POINTS[k]) for n, k in np.argwhere(~made.known)}
    assert unknown == {(1, "left_wrist"), (1, "right_knee")}
    assert (made.visibility[~made.known] == 0).all()
    assert (made.uv[~made.known] == 0).all(), "no NaN reaches a sum"


def test_ends_that_a_network_does_not_know_are_unknown_and_the_joints_are_not() -> None:
    keypoints = walk(3).keypoints
    bare = Keypoints(
        0,
        keypoints.names[: len(JOINTS)],
        keypoints.uv[:, : len(JOINTS)],
        keypoints.visibility[:, : len(JOINTS)],
        np.array(keypoints.p_hips)[:, : len(JOINTS)],
    )
    made = Observed.of(bare, CAMERA)
    assert made.known[:, : len(JOINTS)].all()
    assert not made.known[:, len(JOINTS) :].any()


def test_what_is_disbelieved_is_unknown_and_stays_so() -> None:
    whole = observed()
    doubted = np.zeros_like(whole.known)
    doubted[5, place("left_ankle")] = True
    less = whole.without(doubted)
    assert not less.known[5, place("left_ankle")]
    assert less.visibility[5, place("left_ankle")] == 0
    assert less.known.sum() == whole.known.sum() - 1
    assert not less.without(np.zeros_like(doubted)).known[5, place("left_ankle")]


def test_depth_is_lifted_where_any_of_it_has_a_deviation() -> None:
    plain = observed()
    sigma_m = np.full_like(plain.depth_sigma_m, np.nan)
    sigma_m[3, 2] = 0.1
    lifted = replace(plain, depth_sigma_m=sigma_m, p_hips=plain.p_hips + 1.0)
    assert (plain.is_lifted, lifted.is_lifted) == (False, True)
    taken = plain.with_depth_of(lifted)
    assert taken.is_lifted
    np.testing.assert_array_equal(taken.p_hips, lifted.p_hips)
    np.testing.assert_array_equal(taken.uv, plain.uv)


@pytest.mark.parametrize(
    ("known", "expected"),
    [([0, 10], 5.0), ([4, 6], 5.0), ([0, 2], 2.0), ([8], 8.0)],
    ids=["between", "between near ones", "after the last", "before the only one"],
)
def test_a_joint_that_is_not_known_goes_straight_between_the_frames_that_know_it(
    known: list[int], expected: float
) -> None:
    whole, elbow = observed().rows(slice(11)), place_of("left", "elbow")
    p_hips = whole.p_hips.copy()
    p_hips[:, elbow] = np.arange(11.0)[:, None]
    mask = whole.known.copy()
    mask[:, elbow] = np.isin(np.arange(11), known)
    bridged = replace(whole, p_hips=p_hips, known=mask).bridged(np.full((12, 3), 99.0))
    np.testing.assert_allclose(bridged[5, elbow], expected)


def test_a_joint_that_no_frame_knows_is_as_in_the_rest_pose() -> None:
    whole, wrist = observed(), place_of("right", "wrist")
    mask = whole.known.copy()
    mask[:, wrist] = False
    rest = np.arange(36.0).reshape(12, 3)
    bridged = replace(whole, known=mask).bridged(rest)
    np.testing.assert_array_equal(bridged[:, wrist], np.tile(rest[wrist], (COUNT, 1)))
    others = np.arange(12) != wrist
    np.testing.assert_array_equal(bridged[:, others], whole.p_hips[:, :12][:, others])


# --- joints on the body


@pytest.mark.parametrize("name", ["adult_female", "adult_male", "child"])
def test_a_bone_is_as_long_as_its_joints_are_apart_and_seen_as_its_points_are(name: str) -> None:
    joints = Joints.of(Skeleton.of(preset(name)))
    T = pose_transforms(joints.skeleton, Pose.rest(joints.skeleton, (0.0, 0.0, 3.0)))
    at, seen = joints.points.at(T), joints.seen.at(T)
    for bone in joints.bones:
        assert joints.length_m(bone) == pytest.approx(np.linalg.norm(at[bone.far] - at[bone.near]))
    for limb in joints.limbs:
        lower = np.linalg.norm(seen[limb.lower.far] - seen[limb.lower.near])
        assert joints.seen_length_m(limb.lower) == pytest.approx(lower, abs=0.003)


def test_landmarks_of_hips_and_shoulders_come_to_the_joints() -> None:
    """Those of a person at rest, seen where the network puts them."""
    joints = Joints.of(Skeleton.of(BODY))
    T = pose_transforms(joints.skeleton, Pose.rest(joints.skeleton, (0.0, 0.0, 3.0)))
    seen = joints.seen.at(T)[None]
    at = joints.on_joints(seen)[0]
    for joint in ("hip", "shoulder"):
        left, right = (place_of(side, joint) for side in SIDES)
        ours = np.linalg.norm(joints.rest[left] - joints.rest[right])
        assert np.linalg.norm(seen[0, left] - seen[0, right]) != pytest.approx(ours, abs=0.01)
        assert np.linalg.norm(at[left] - at[right]) == pytest.approx(ours, abs=0.002)
        middle = seen[0, [left, right]].mean(axis=0)
        np.testing.assert_allclose(at[[left, right]].mean(axis=0), middle)


def test_elbows_bend_forward_and_knees_backward() -> None:
    """The person faces −z: forearms go to −z, shins to +z."""
    joints = Joints.of(Skeleton.of(BODY))
    assert [limb.bends_to[2] for limb in joints.limbs] == [-1.0, -1.0, 1.0, 1.0]


def test_what_turns_for_head_and_feet_are_these_alone() -> None:
    turning = turning_ends(Joints.of(Skeleton.of(with_clavicles(BODY))))
    free = {turning.body.names[part] for part in turning.dof_part}
    assert free == {"head", "left_foot", "right_foot"}
    assert {POINTS[k] for k in Joints.of(turning).ends[0]} == set(ENDS)


def test_standing_people_are_known_throughout() -> None:
    made = Observed.of(standing(2).keypoints, CAMERA)
    assert made.known.all()
    assert made.usable.all()
    assert not made.jumped.any()
