"""A limb set right stays where it was put, whatever becomes of the body that carries it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.tracking.parts.limb_keyframes import (
    KeyedParts,
    keyed_limbs,
    placed,
    with_exact_ends,
)

SKELETON = Skeleton.of(preset("adult_male"))
CAMERA = Camera(width=640, height=480, fx=700, fy=710, cx=322, cy=235)
ARM = ("right_upper_arm", "right_forearm", "right_hand")


def index(*names: str) -> list[int]:
    return [SKELETON.body.index(name) for name in names]


def pose(seed: int = 1, turn_rad: float = 0.4) -> Pose:
    """With the right elbow bent."""
    R = exp_rotation(np.random.default_rng(seed).normal(0, turn_rad, (SKELETON.part_count, 3)))
    R[index("right_forearm")] = exp_rotation(np.array([-1.2, 0.1, 0.0]))
    return Pose(R, np.array([0.2, -0.1, 4.0]))


def moved(of: Pose, turn_rad: float, shift_m: float, seed: int = 2) -> Pose:
    """The rest of the body as it might be tracked later, limbs and all."""
    rng = np.random.default_rng(seed)
    turn = exp_rotation(rng.normal(0, turn_rad, (SKELETON.part_count, 3)))
    shift = rng.normal(size=3)
    return Pose(
        of.Rs_parent_part @ turn, of.p_camera_root + shift_m * shift / np.linalg.norm(shift)
    )


def keyed(at: Pose, parts: tuple[str, ...] = ARM) -> KeyedParts:
    return KeyedParts.of(SKELETON, 7, parts, at)


def apart_m(a: Pose, b: Pose, *names: str) -> NDArray[np.float64]:
    Ts = [pose_transforms(SKELETON, each)[index(*names), :3, 3] for each in (a, b)]
    return np.asarray(np.linalg.norm(Ts[0] - Ts[1], axis=-1))


def off_root_m(at: Pose) -> float:
    """How much farther away the hand is than the root."""
    place = pose_transforms(SKELETON, at)[index("right_hand")[0], :3, 3]
    return float(place[2] - at.p_camera_root[2])


def test_on_the_body_as_it_was_the_limb_is_put_back_to_the_last_digit() -> None:
    at, rest = pose(), pose()
    R, t = rest.writable()
    R[index(*ARM)] = pose(seed=5).Rs_parent_part[index(*ARM)]
    back = placed(SKELETON, keyed(at), Pose(R, t))
    np.testing.assert_array_equal(back.Rs_parent_part, at.Rs_parent_part)


@pytest.mark.parametrize("shift_m", [0.0, 0.01, 0.05])
@pytest.mark.parametrize("turn_rad", [0.0, np.radians(2.0)])
def test_the_end_of_the_limb_stays_in_its_place_and_the_rest_where_it_is_tracked(
    turn_rad: float, shift_m: float
) -> None:
    at = pose()
    rest = moved(at, turn_rad, shift_m)
    back = placed(SKELETON, keyed(at), rest)
    assert off_root_m(back) == pytest.approx(off_root_m(at), abs=5e-4)
    seen = [
        CAMERA.project(pose_transforms(SKELETON, p)[index("right_hand"), :3, 3]) for p in (back, at)
    ]
    assert np.linalg.norm(seen[0] - seen[1]) < 0.1
    hands = [pose_transforms(SKELETON, p)[index("right_hand")[0], :3, :3] for p in (back, at)]
    np.testing.assert_allclose(hands[0], hands[1], atol=1e-9)
    others = [i for i in range(SKELETON.part_count) if i not in index(*ARM)]
    np.testing.assert_array_equal(back.Rs_parent_part[others], rest.Rs_parent_part[others])
    np.testing.assert_array_equal(back.p_camera_root, rest.p_camera_root)


def test_the_elbow_moves_no_farther_than_what_carries_the_arm() -> None:
    at = pose()
    rest = moved(at, 0.0, 0.03)
    back = placed(SKELETON, keyed(at), rest)
    assert apart_m(back, at, "right_forearm")[0] < 0.035


def test_by_a_telephoto_lens_a_limb_is_seen_where_it_was_however_far_the_body_is() -> None:
    at = pose()
    rest = Pose(at.Rs_parent_part, at.p_camera_root + np.array([0.0, 0.0, 0.4]))
    far = KeyedParts.of(SKELETON, 7, ARM, at, telephoto=True)
    back = placed(SKELETON, far, rest)
    one, other = (pose_transforms(SKELETON, p)[index("right_hand")[0]] for p in (back, at))
    np.testing.assert_allclose(one[:3, 3] - other[:3, 3], (0.0, 0.0, 0.4), atol=5e-4)


def test_a_place_out_of_reach_is_reached_for() -> None:
    at = pose()
    R = at.Rs_parent_part.copy()
    R[index("right_forearm")] = np.eye(3)
    straight = Pose(R, at.p_camera_root)
    shoulder = pose_transforms(SKELETON, straight)[index("right_upper_arm")[0], :3, 3]
    wrist = pose_transforms(SKELETON, straight)[index("right_hand")[0], :3, 3]
    away = 0.1 * (shoulder - wrist) / np.linalg.norm(shoulder - wrist)
    back = placed(SKELETON, keyed(straight), Pose(R, at.p_camera_root + away))
    found = pose_transforms(SKELETON, back)[:, :3, 3]
    reach = found[index("right_hand")[0]] - found[index("right_upper_arm")[0]]
    assert np.linalg.norm(reach) == pytest.approx(np.linalg.norm(wrist - shoulder), rel=1e-3)
    assert apart_m(back, straight, "right_hand")[0] < 0.15


def test_a_single_part_keeps_facing_its_way() -> None:
    at = pose()
    back = placed(SKELETON, keyed(at, ("right_hand",)), moved(at, 0.05, 0.01))
    hands = [pose_transforms(SKELETON, p)[index("right_hand")[0], :3, :3] for p in (back, at)]
    np.testing.assert_allclose(hands[0], hands[1], atol=1e-9)


def test_what_hangs_on_a_part_belongs_to_it_and_limbs_are_apart() -> None:
    frames = (
        KeyedParts.of(SKELETON, 12, ("left_thigh", "right_forearm"), pose()),
        KeyedParts.of(SKELETON, 5, ARM, pose()),
    )
    limbs = keyed_limbs(SKELETON, frames)
    names = [{SKELETON.body.names[i] for i in limb.parts} for limb in limbs]
    assert {*ARM} in names
    assert {"left_thigh", "left_shin", "left_foot"} in names
    (arm,) = (limb for limb in limbs if index("right_hand")[0] in limb.parts)
    assert [each.frame for each in arm.keyed] == [5, 12]
    assert index("right_upper_arm")[0] not in arm.keyed[1].parts


def test_of_a_solved_motion_the_ends_of_limbs_are_put_right_and_elbows_hardly_move() -> None:
    """A hand that was solved to a millimetre where it was set comes there exactly; the elbow stays
    where it was solved, though it was set elsewhere."""
    at = pose()
    solved = placed(SKELETON, keyed(at), moved(at, np.radians(4.0), 0.02))
    R, t = solved.writable()
    R[index("right_upper_arm")] @= exp_rotation(np.array([0.002, 0.0, 0.002]))
    near = Pose(R, t)
    found = with_exact_ends(SKELETON, keyed(at), near)
    assert apart_m(found, near, "right_hand")[0] > 5e-4
    assert off_root_m(found) == pytest.approx(off_root_m(at), abs=2e-4)
    assert apart_m(found, near, "right_forearm")[0] < 0.002
    still = [name for name in SKELETON.body.names if name not in ARM]
    np.testing.assert_array_equal(found.Rs_parent_part[index(*still)], R[index(*still)])


def test_a_hand_keyed_alone_faces_its_way_on_a_motion_that_was_solved() -> None:
    at, solved = pose(), moved(pose(), np.radians(3.0), 0.01)
    found = with_exact_ends(SKELETON, keyed(at, ("right_hand",)), solved)
    faces = [pose_transforms(SKELETON, p)[index("right_hand")[0], :3, :3] for p in (found, at)]
    np.testing.assert_allclose(faces[0], faces[1], atol=1e-9)
    assert apart_m(found, solved, "right_hand")[0] == 0
