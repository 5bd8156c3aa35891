"""Where on a body the joints are that detectors see."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.pose import Pose, joint_names, joint_positions, pose_transforms
from keypose.tracker.body.preset_names import PEOPLE
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import points_on_body
from tests.tracker.formats import recordings

DISTAL = ("upper_arm", "forearm", "hand", "thigh", "shin", "foot")
PROXIMAL = {
    "shoulder": "chest", "elbow": "upper_arm", "wrist": "forearm",
    "hip": "waist", "knee": "thigh", "ankle": "shin",
}  # fmt: skip


def _distal(name: str) -> str:
    side, joint = name.split("_")
    return f"{side}_{DISTAL[list(PROXIMAL).index(joint)]}"


def _random_pose(skeleton: Skeleton, rng: np.random.Generator) -> Pose:
    turns = exp_rotation(rng.normal(0, 0.6, (skeleton.part_count, 3)))
    return Pose(turns, np.array([0.1, 0.2, 4.0]))


@pytest.mark.parametrize("name", PEOPLE)
def test_every_joint_of_a_preset_is_where_its_parts_meet_in_any_pose(name: str) -> None:
    body = preset(name)
    skeleton = Skeleton.of(body)
    on = points_on_body(body, JOINTS)
    assert on.indices.tolist() == list(range(12))
    rng = np.random.default_rng(5)
    for _ in range(5):
        Ts = pose_transforms(skeleton, _random_pose(skeleton, rng))
        at = dict(zip(joint_names(skeleton), joint_positions(skeleton, Ts), strict=True))
        T = Ts[on.part]
        here = (T[:, :3, :3] @ on.point[..., None])[..., 0] + T[:, :3, 3]
        assert np.allclose(here, [at[_distal(joint)] for joint in JOINTS], atol=1e-12)


def test_a_joint_is_on_the_part_nearer_to_the_trunk() -> None:
    body = preset("adult_male")
    on = points_on_body(body, JOINTS)
    for joint, part in zip(JOINTS, on.part, strict=True):
        assert (
            body.names[part].removeprefix("left_").removeprefix("right_")
            == (PROXIMAL[joint.split("_")[1]])
        )


def test_names_keep_their_order_and_unknown_ones_are_left_out() -> None:
    body = preset("adult_male")
    on = points_on_body(body, ["mouth_left", "left_knee", "left_small_toe", "right_wrist"])
    assert on.indices.tolist() == [1, 3]
    assert [body.names[part] for part in on.part] == ["left_thigh", "right_forearm"]


def test_nose_and_ears_are_on_the_head_the_nose_in_front_and_each_ear_on_its_side() -> None:
    body = preset("adult_male")
    on = points_on_body(body, ["nose", "left_ear", "right_ear", "left_shoulder", "right_shoulder"])
    assert [body.names[part] for part in on.part] == ["head"] * 3 + ["chest"] * 2
    nose, left, right, left_shoulder, _ = on.point
    assert nose[2] < -0.05  # a body at rest looks at the camera
    assert np.sign(left[0]) == np.sign(left_shoulder[0]) == -np.sign(right[0])


def test_a_body_of_other_parts_has_none() -> None:
    box = recordings.session("box").subject.body
    dog = Body(
        name="dog",
        parts=tuple(
            part.model_copy(update={"name": f"dog {i}", "parent": parent and "dog 0"})
            for i, (part, parent) in enumerate(
                (part, part.parent) for part in preset("adult_male").parts
            )
        ),
    )
    for body in (box, dog):
        on = points_on_body(body, JOINTS)
        assert on.indices.shape == on.part.shape == (0,)
        assert on.point.shape == (0, 3)


def test_a_forearm_without_a_hand_gives_its_wrist_by_a_landmark() -> None:
    body = preset("adult_male")
    wrist = body.parts[body.index("left_hand")].joint_m
    body = Body(
        name="no hand",
        parts=tuple(part for part in body.parts if part.name != "left_hand"),
    )
    assert len(points_on_body(body, ["left_wrist"]).indices) == 0
    forearm = body.parts[body.index("left_forearm")]
    body = body.with_part(forearm.model_copy(update={"landmarks": {"left_wrist": wrist}}))
    on = points_on_body(body, ["left_wrist"])
    assert body.names[on.part[0]] == "left_forearm"
    assert np.allclose(on.point, [wrist])
