"""Bodies whose shoulders move: the same at rest, within limits, and back again."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.body import Body, Part, preset
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.modify import (
    can_have_clavicles,
    has_clavicles,
    height,
    resized,
    with_clavicles,
    with_height,
    without_clavicles,
)
from keypose.tracker.body.pose import Pose, joint_names, joint_positions, pose_transforms
from keypose.tracker.body.preset_names import PEOPLE
from keypose.tracker.body.shapes import Cylinder
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.tracking.cues.anchors import with_free_joints

SIDES = {"left": 1.0, "right": -1.0}


def joints(body: Body, **turns: tuple[float, float, float]) -> dict[str, Array]:
    """Where joints are, the root at 0, when these parts turn by degrees about x, y, z."""
    skeleton = Skeleton.of(body)
    Rs = np.tile(np.eye(3), (skeleton.part_count, 1, 1))
    for name, degrees in turns.items():
        Rs[body.index(name)] = exp_rotation(np.radians(degrees))
    Ts = pose_transforms(skeleton, Pose(Rs, np.zeros(3)))
    return dict(zip(joint_names(skeleton), joint_positions(skeleton, Ts), strict=True))


@pytest.mark.parametrize("name", PEOPLE)
def test_a_body_with_clavicles_is_the_same_body_in_every_pose_of_the_old_parts(name: str) -> None:
    plain, moving = preset(name), with_clavicles(preset(name))
    assert has_clavicles(moving)
    assert not can_have_clavicles(moving)
    turns = {"chest": (10.0, 20.0, 5.0), "left_upper_arm": (-40.0, 10.0, -30.0)}
    before, after = joints(plain, **turns), joints(moving, **turns)
    for joint, place in before.items():
        np.testing.assert_allclose(after[joint], place, atol=1e-9)
    assert height(moving) == pytest.approx(height(plain))


@pytest.mark.parametrize("name", PEOPLE)
def test_without_them_again_it_is_the_body_that_it_was(name: str) -> None:
    assert without_clavicles(with_clavicles(preset(name))) == preset(name)


@pytest.mark.parametrize(("side", "sign"), SIDES.items())
def test_a_shoulder_rises_and_swings_within_its_limits(side: str, sign: float) -> None:
    body = with_clavicles(preset("adult_male"))
    part, arm = f"{side}_clavicle", f"{side}_upper_arm"
    rest = joints(body)[arm]
    raised, forward = (
        joints(body, **{part: (0, 0, -30 * sign)}),
        joints(body, **{part: (0, 20 * sign, 0)}),
    )
    assert rest[1] - raised[arm][1] > 0.07  # y points down
    assert rest[2] - forward[arm][2] > 0.04  # z points away from the camera, the body faces it
    np.testing.assert_array_equal(raised["head"], joints(body)["head"])
    limits, index = Limits.of(body), body.index(part)
    Rs = np.tile(np.eye(3), (len(body.parts), 1, 1))
    for degrees, is_inside in ((35, True), (45, False), (-5, True), (-15, False)):
        Rs[index] = exp_rotation(np.radians((0, 0, -degrees * sign)))
        assert (np.abs(limits.excess(Rs)[0]).max() < 1e-9) == is_inside, degrees


def test_they_are_a_pair_that_keypoints_turn_and_brightness_does_not() -> None:
    body = with_clavicles(preset("adult_female"))
    assert body.mirror_of("left_clavicle") == "right_clavicle"
    assert not any("clavicle" in name for name in Skeleton.of(body).dof_names)
    assert "left_clavicle rz" in with_free_joints(Skeleton.of(body)).dof_names
    left, right = (body.parts[body.index(f"{side}_clavicle")] for side in SIDES)
    assert left.joint_m[0] == -right.joint_m[0]
    assert left.joint_m[1:] == right.joint_m[1:]


def test_the_shoulder_as_a_keypoint_moves_with_the_clavicle() -> None:
    body = with_clavicles(preset("adult_male"))
    on = points_on_body(body, JOINTS)
    assert len(on.indices) == len(JOINTS)
    part = on.part[JOINTS.index("left_shoulder")]
    assert body.names[part] == "left_clavicle"


def test_sizes_carry_the_shoulders_along() -> None:
    body = with_clavicles(preset("adult_male"))
    rest = joints(body)
    wide = joints(resized(body, "left_clavicle", thickness_factor=1.2))
    assert wide["left_upper_arm"][0] > rest["left_upper_arm"][0] + 0.02
    assert wide["right_upper_arm"][0] < rest["right_upper_arm"][0] - 0.02
    tall = with_height(body, 2.0)
    assert without_clavicles(tall).parts[4].joint_m == pytest.approx(
        with_height(preset("adult_male"), 2.0).parts[4].joint_m, abs=1e-6
    )


def test_other_bodies_have_none() -> None:
    stick = Body(name="stick", parts=(Part(name="stick", shape=Cylinder(end_m=1.0, radius_m=0.1)),))
    assert with_clavicles(stick) is stick
    assert without_clavicles(stick) is stick
    assert without_clavicles(preset("adult_male")) == preset("adult_male")
