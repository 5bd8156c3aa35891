"""Left and right exchanged."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.app.posing import mirror_pose, with_other_side
from keypose.tracker.body.body import Body
from keypose.tracker.body.skeleton import Skeleton
from tests.app.posing.posing_cases import DOG, PERSON, bent, difference, points, rotations, tumbling


@pytest.mark.parametrize("body", [PERSON, DOG], ids=["person", "dog"])
def test_every_joint_goes_to_its_mirror_image_in_the_root_s_own_plane(body: Body) -> None:
    pose = bent(body, 8)
    other = mirror_pose(Skeleton.of(body), pose)
    normal = pose.Rs_parent_part[0][:, 0]
    before, after = points(body, pose), points(body, other)
    for name in body.names:
        p = before[name] - pose.p_camera_root
        image = p - 2 * (p @ normal) * normal + pose.p_camera_root
        np.testing.assert_allclose(after[body.mirror_of(name)], image, atol=1e-12)
    np.testing.assert_array_equal(other.p_camera_root, pose.p_camera_root)
    np.testing.assert_array_equal(other.Rs_parent_part[0], pose.Rs_parent_part[0])


@pytest.mark.parametrize("body", [PERSON, DOG], ids=["person", "dog"])
def test_mirrored_twice_is_the_same(body: Body) -> None:
    skeleton, pose = Skeleton.of(body), bent(body, 9)
    assert difference(mirror_pose(skeleton, mirror_pose(skeleton, pose)), pose) == 0
    assert difference(mirror_pose(skeleton, pose), pose) > 0.1


def test_one_part_hands_its_pose_to_the_other_side() -> None:
    skeleton, pose = Skeleton.of(PERSON), tumbling()
    one = with_other_side(skeleton, pose, "left_thigh")
    both = mirror_pose(skeleton, pose)
    i = PERSON.index("right_thigh")
    np.testing.assert_array_equal(one.Rs_parent_part[i], both.Rs_parent_part[i])
    rest = [k for k in range(len(PERSON.parts)) if k != i]
    np.testing.assert_array_equal(one.Rs_parent_part[rest], pose.Rs_parent_part[rest])
    assert with_other_side(skeleton, pose, "head") is pose
    for R in rotations(PERSON, both).values():
        assert np.linalg.det(R) == pytest.approx(1)
