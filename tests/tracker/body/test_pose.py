"""Forward kinematics and motions: what turns what, and by how much."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.body import ALL_DOFS, ROTATIONS, Body, Part, preset
from keypose.tracker.body.pose import (
    Pose,
    joint_names,
    joint_positions,
    moved,
    part_transforms,
    pose_transforms,
    twists,
)
from keypose.tracker.body.shapes import Box
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, interpolate, joined
from keypose.tracker.geometry.rotations import apply_transform, rotation_from_euler, transform
from tests.tracker.tracking_cases import deep_chain, random_body, random_pose

BLOCK = Box(low_m=(-0.1, -0.1, -0.1), high_m=(0.1, 0.1, 0.1))
QUARTER = np.pi / 2


def arm() -> Skeleton:
    """Trunk, upper arm 1 m to the right of it, forearm 2 m below that, with a fingertip."""
    trunk = Part(name="trunk", shape=BLOCK, tracked=ALL_DOFS)
    upper = Part(
        name="upper", parent="trunk", joint_m=(1.0, 0.0, 0.0), shape=BLOCK, tracked=("rz",)
    )
    fore = Part(
        name="fore",
        parent="upper",
        joint_m=(0.0, 2.0, 0.0),
        shape=BLOCK,
        tracked=ROTATIONS,
        landmarks={"tip": (0.0, 3.0, 0.0)},
    )
    return Skeleton.of(Body(name="arm", parts=(trunk, upper, fore)))


def test_a_bent_arm_is_where_a_ruler_would_find_it() -> None:
    turns = [(0.0, 0.0, 0.0), (QUARTER, 0.0, 0.0), (0.0, 0.0, QUARTER)]
    pose = Pose(np.stack([rotation_from_euler(*t) for t in turns]), np.array([0.0, 0.0, 5.0]))
    skeleton = arm()
    p = joint_positions(skeleton, pose_transforms(skeleton, pose))
    at = dict(zip(joint_names(skeleton), p, strict=True))
    np.testing.assert_allclose(at["trunk"], (0, 0, 5), atol=1e-12)
    np.testing.assert_allclose(at["upper"], (1, 0, 5), atol=1e-12)
    # turned about z, the upper arm points to −x; the forearm, turned about x, away from the camera
    np.testing.assert_allclose(at["fore"], (-1, 0, 5), atol=1e-12)
    np.testing.assert_allclose(at["tip"], (-1, 0, 8), atol=1e-12)


def test_the_chain_is_the_product_of_its_transforms_over_any_batch() -> None:
    skeleton = random_body(2, parts=6)
    poses = [random_pose(skeleton, seed) for seed in range(4)]
    Rs = np.stack([p.Rs_parent_part for p in poses]).reshape(2, 2, 6, 3, 3)
    ps = np.stack([p.p_camera_root for p in poses]).reshape(2, 2, 3)
    T = part_transforms(skeleton, Rs, ps)
    for k, pose in enumerate(poses):
        np.testing.assert_allclose(T[k // 2, k % 2], pose_transforms(skeleton, pose))
        for i, parent in enumerate(skeleton.parents):
            if parent >= 0:
                own = transform(pose.Rs_parent_part[i], skeleton.joints[i])
                np.testing.assert_allclose(T[k // 2, k % 2, i], T[k // 2, k % 2, parent] @ own)


def test_a_pose_cannot_be_changed_by_those_who_hold_it() -> None:
    Rs = np.tile(np.eye(3), (3, 1, 1))
    pose = Pose(Rs, np.array([0.0, 0.0, 3.0]))
    Rs[0, 0, 0] = 7
    assert pose.Rs_parent_part[0, 0, 0] == 1
    with pytest.raises(ValueError, match="read-only"):
        pose.p_camera_root[0] = 1


@pytest.mark.parametrize(
    "skeleton",
    [arm(), deep_chain(), random_body(3), random_body(4), Skeleton.of(preset("adult_female"))],
    ids=["arm", "chain", "random", "other", "person"],
)
def test_every_twist_is_the_velocity_that_a_small_motion_gives(skeleton: Skeleton) -> None:
    pose = random_pose(skeleton, 5, size=1.0)
    T = pose_transforms(skeleton, pose)
    S = twists(skeleton, T)
    local = np.random.default_rng(6).normal(0, 0.3, (4, 3))
    at = apply_transform(T, local)
    step = 1e-6
    for d in range(skeleton.dof_count):
        motion = np.zeros(skeleton.dof_count)
        motion[d] = step
        ahead = apply_transform(pose_transforms(skeleton, moved(skeleton, pose, motion)), local)
        back = apply_transform(pose_transforms(skeleton, moved(skeleton, pose, -motion)), local)
        measured = (ahead - back) / (2 * step)
        below = skeleton.below[:, skeleton.dof_part[d]]
        reported = (S[d, :3] + np.cross(S[d, 3:], at)) * below[:, None, None]
        np.testing.assert_allclose(measured, reported, atol=1e-7, err_msg=skeleton.dof_names[d])


def test_a_part_moves_with_its_ancestors_and_itself_only() -> None:
    skeleton = random_body(7, parts=8)
    pose = random_pose(skeleton, 7)
    before = pose_transforms(skeleton, pose)
    for d in range(skeleton.dof_count):
        motion = np.zeros(skeleton.dof_count)
        motion[d] = 0.2
        after = pose_transforms(skeleton, moved(skeleton, pose, motion))
        stays = np.abs(after - before).max(axis=(1, 2)) < 1e-12
        np.testing.assert_array_equal(stays, ~skeleton.below[:, skeleton.dof_part[d]])


def test_below_says_who_hangs_on_whom() -> None:
    skeleton = Skeleton.of(preset("adult_male"))
    names = skeleton.body.names
    hand, chest = names.index("left_hand"), names.index("chest")
    assert skeleton.below[hand, chest]
    assert not skeleton.below[chest, hand]
    assert not skeleton.below[hand, names.index("right_upper_arm")]
    assert skeleton.below[:, 0].all()
    assert skeleton.dof_names[:7] == (
        *(f"waist t{a}" for a in "xyz"),
        *(f"waist r{a}" for a in "xyz"),
        "chest rx",
    )


def test_translations_stand_before_rotations_however_they_are_listed() -> None:
    root = Part(name="block", shape=BLOCK, tracked=("rz", "tx", "rx", "tz"))
    skeleton = Skeleton.of(Body(name="one", parts=(root,)))
    assert skeleton.dof_names == ("block tx", "block tz", "block rx", "block rz")
    np.testing.assert_array_equal(skeleton.column_scale, [0.3, 0.3, 1.0, 1.0])


def test_motions_are_composed_in_the_parts_own_frame() -> None:
    skeleton = arm()
    turned = Pose(
        np.stack([rotation_from_euler(0.0, QUARTER, 0.0), np.eye(3), np.eye(3)]),
        np.array([0.0, 0.0, 5.0]),
    )
    motion = np.zeros(skeleton.dof_count)
    motion[skeleton.dof_names.index("trunk tx")] = 0.5
    # x of the turned trunk points at −z of the camera
    np.testing.assert_allclose(
        moved(skeleton, turned, motion).p_camera_root, (0, 0, 4.5), atol=1e-12
    )


def test_ten_thousand_motions_leave_rotations_that_are_rotations() -> None:
    skeleton = deep_chain(3)
    pose = random_pose(skeleton, 8)
    motions = np.random.default_rng(9).normal(0, 0.02, (10_000, skeleton.dof_count))
    for motion in motions:
        pose = moved(skeleton, pose, motion)
    R = pose.Rs_parent_part
    np.testing.assert_allclose(R @ np.swapaxes(R, 1, 2), np.tile(np.eye(3), (3, 1, 1)), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(R), 1.0, atol=1e-12)


def test_a_motion_mends_rotations_that_are_not_quite_rotations() -> None:
    skeleton = deep_chain(3)
    pose = random_pose(skeleton, 8)
    bent = Pose(pose.Rs_parent_part * (1 + 1e-4), pose.p_camera_root)
    R = moved(skeleton, bent, np.zeros(skeleton.dof_count)).Rs_parent_part
    np.testing.assert_allclose(R, pose.Rs_parent_part, atol=1e-12)


def test_interpolation_meets_both_keyframes_exactly_and_divides_evenly() -> None:
    skeleton = random_body(10)
    start, end = random_pose(skeleton, 11), random_pose(skeleton, 12)
    path = interpolate(start, end, 30, 37)
    assert (path.first_frame, path.last_frame, len(path)) == (30, 37, 8)
    for frame, pose in ((30, start), (37, end)):
        np.testing.assert_array_equal(path.pose(frame).Rs_parent_part, pose.Rs_parent_part)
        np.testing.assert_array_equal(path.pose(frame).p_camera_root, pose.p_camera_root)
    steps = np.swapaxes(path.Rs_parent_part[:-1], -1, -2) @ path.Rs_parent_part[1:]
    np.testing.assert_allclose(steps, np.broadcast_to(steps[0], steps.shape), atol=1e-9)
    np.testing.assert_allclose(np.ptp(np.diff(path.ps_camera_root, axis=0), axis=0), 0, atol=1e-12)


def test_trajectories_are_joined_at_their_shared_frames_and_not_elsewhere() -> None:
    skeleton = random_body(13)
    poses = [random_pose(skeleton, seed) for seed in (14, 15, 16)]
    first, second = interpolate(poses[0], poses[1], 0, 4), interpolate(poses[1], poses[2], 4, 9)
    whole = joined([first, second])
    assert (whole.first_frame, whole.last_frame) == (0, 9)
    np.testing.assert_array_equal(whole.Rs_parent_part[5], second.Rs_parent_part[1])
    with pytest.raises(ValueError, match="shared frame"):
        joined([second, first])
    with pytest.raises(IndexError, match=r"frame 10 is not in 0\.\.9"):
        whole.pose(10)
    with pytest.raises(IndexError, match="frame -1"):
        Trajectory(0, whole.Rs_parent_part, whole.ps_camera_root).pose(-1)
