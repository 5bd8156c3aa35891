"""The body turned to face a way, as seen in the picture."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.app.posing import Way, facing, opening_pose, view_rotations, with_angles
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, exp_rotation, frozen
from tests.app.posing.posing_cases import CAMERA, PERSON

SKELETON = Skeleton.of(PERSON)
UPS = {"level": (0.0, -1.0, 0.0), "from above": (0.0, -0.8, -0.6), "rolled": (0.28, -0.96, 0.0)}
WAYS: tuple[Way, ...] = ("camera", "away", "left", "right")

AHEAD = {"camera": (0, 0, -1), "away": (0, 0, 1), "left": (-1, 0, 0), "right": (1, 0, 0)}
LEFT_SIDE = {"camera": (1, 0, 0), "away": (-1, 0, 0), "left": (0, 0, -1), "right": (0, 0, 1)}
"""In the frame of the front view: x right, y down, z away. Who faces left shows the left side."""


def places(body: Body, pose: Pose) -> dict[str, Array]:
    """Joints and landmarks in the camera frame."""
    Ts = pose_transforms(Skeleton.of(body), pose)
    found = {part.name: T[:3, 3] for part, T in zip(body.parts, Ts, strict=True)}
    for part, T in zip(body.parts, Ts, strict=True):
        found |= {name: T[:3, :3] @ np.array(p) + T[:3, 3] for name, p in part.landmarks.items()}
    return found


def posed(up: tuple[float, float, float]) -> Pose:
    """One who leans, turned by some angle, the limbs in various positions."""
    pose = opening_pose(PERSON, CAMERA, up)
    Rs = pose.Rs_parent_part.copy()
    Rs[0] = exp_rotation(np.array(up) * 0.6) @ Rs[0] @ exp_rotation(np.array([0.2, 0.0, 0.1]))
    pose = Pose(Rs, pose.p_camera_root)
    pose = with_angles(SKELETON, pose, "left_upper_arm", x=-50, z=20)
    return with_angles(SKELETON, pose, "right_shin", x=30)


@pytest.mark.parametrize("up", UPS.values(), ids=UPS)
@pytest.mark.parametrize("way", WAYS)
def test_toes_point_where_the_body_faces_and_its_left_is_where_it_then_must_be(
    way: Way, up: tuple[float, float, float]
) -> None:
    at = places(PERSON, facing(opening_pose(PERSON, CAMERA, up), way, up))
    R_front_camera = view_rotations(up)["front"]
    toe = R_front_camera @ (at["left_toe"] - at["left_heel"])
    side = R_front_camera @ (at["left_upper_arm"] - at["right_upper_arm"])
    level = np.array([1.0, 0.0, 1.0])
    for found, wanted in ((toe, AHEAD[way]), (side, LEFT_SIDE[way])):
        flat = found * level
        np.testing.assert_allclose(flat / np.linalg.norm(flat), wanted, atol=1e-9)


@pytest.mark.parametrize("up", UPS.values(), ids=UPS)
@pytest.mark.parametrize("way", WAYS)
def test_the_waist_stays_and_so_does_what_was_posed(
    way: Way, up: tuple[float, float, float]
) -> None:
    before = posed(up)
    after = facing(before, way, up)
    np.testing.assert_array_equal(after.p_camera_root, before.p_camera_root)
    np.testing.assert_array_equal(after.Rs_parent_part[1:], before.Rs_parent_part[1:])
    one, other = places(PERSON, before), places(PERSON, after)
    axis = np.array(up) / np.linalg.norm(up)
    for name in one:  # turned about what is up, nothing rises or sinks
        assert (other[name] - one[name]) @ axis == pytest.approx(0, abs=1e-9), name


def test_the_ways_follow_one_another_by_quarter_turns() -> None:
    """Whatever was chosen before, the last choice alone decides."""
    up = UPS["from above"]
    pose = posed(up)
    direct = [facing(pose, way, up).Rs_parent_part[0] for way in WAYS]
    for way in WAYS:
        pose = facing(pose, way, up)
    np.testing.assert_allclose(pose.Rs_parent_part[0], direct[-1], atol=1e-12)
    for i, degrees in ((1, 180), (2, 90), (3, 90)):
        cosine = (np.trace(direct[0].T @ direct[i]) - 1) / 2
        assert np.degrees(np.arccos(np.clip(cosine, -1, 1))) == pytest.approx(degrees, abs=1e-4)


@pytest.mark.parametrize("quarter", [1, -1], ids=["on its front", "on its back"])
@pytest.mark.parametrize("way", WAYS)
def test_one_who_lies_faces_where_the_head_or_the_feet_point(way: Way, quarter: int) -> None:
    stands = opening_pose(PERSON, CAMERA)
    Rs = stands.Rs_parent_part.copy()
    Rs[0] = Rs[0] @ exp_rotation(np.array([quarter * np.pi / 2, 0.0, 0.0]))
    at = places(PERSON, facing(Pose(frozen(Rs), stands.p_camera_root), way))
    spine = at["head"] - at["waist"]
    faces_down = at["left_toe"][1] > at["left_heel"][1]
    along = spine if faces_down else -spine
    np.testing.assert_allclose(along / np.linalg.norm(along), AHEAD[way], atol=0.05)
