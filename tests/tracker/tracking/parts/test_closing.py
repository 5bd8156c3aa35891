"""The drift of a limb is spread over the frames between those at which it is known."""

from __future__ import annotations

import numpy as np

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import exp_rotation, log_rotation, transpose
from keypose.tracker.tracking.parts.limb_keyframes import KeyedParts
from keypose.tracker.tracking.parts.limb_segment import closed_on
from tests.tracker.tracking.cues.people import SKELETON, moving

ARM = [SKELETON.body.index(f"right_{name}") for name in ("upper_arm", "forearm", "hand")]
NAMES = tuple(SKELETON.body.names[i] for i in ARM)
REST = [i for i in range(SKELETON.part_count) if i not in ARM]


def turned(pose: Pose, part: int, turn: tuple[float, float, float]) -> Pose:
    R, t = pose.writable()
    R[part] = R[part] @ exp_rotation(np.array(turn))
    return Pose(R, t)


def turns_rad(one: Trajectory, other: Trajectory, part: int) -> np.ndarray:
    """(N,) by which a part is turned otherwise."""
    R = transpose(one.Rs_parent_part[:, part]) @ other.Rs_parent_part[:, part]
    return np.asarray(np.linalg.norm(log_rotation(R), axis=-1))


def test_the_limb_passes_through_where_it_was_set_and_nothing_else_moves() -> None:
    motion = moving(21)
    frame = motion.first_frame + 8
    key = KeyedParts.of(SKELETON, frame, NAMES, turned(motion.pose(frame), ARM[0], (0.5, 0, 0.2)))
    found = closed_on(SKELETON, motion, (key,))
    there = found.pose(frame).Rs_parent_part[ARM]
    np.testing.assert_allclose(there, key.pose.Rs_parent_part[ARM], atol=1e-12)
    np.testing.assert_array_equal(found.Rs_parent_part[:, REST], motion.Rs_parent_part[:, REST])
    np.testing.assert_array_equal(found.ps_camera_root, motion.ps_camera_root)
    for end in (0, -1):
        np.testing.assert_array_equal(found.Rs_parent_part[end], motion.Rs_parent_part[end])


def test_the_correction_grows_evenly_from_the_keyframes_to_where_the_limb_was_set() -> None:
    still = Trajectory(3, *(np.repeat(x[:1], 21, axis=0) for x in moving(21).writable()))
    frame = still.first_frame + 8
    key = KeyedParts.of(SKELETON, frame, NAMES, turned(still.pose(frame), ARM[0], (0.5, 0, 0)))
    away = turns_rad(closed_on(SKELETON, still, (key,)), still, ARM[0])
    np.testing.assert_allclose(away[:9], 0.5 * np.arange(9) / 8, atol=1e-9)
    np.testing.assert_allclose(away[8:], 0.5 * np.arange(12, -1, -1) / 12, atol=1e-9)


def test_what_was_right_already_stays_as_it_was() -> None:
    motion = moving(21)
    frame = motion.first_frame + 8
    found = closed_on(
        SKELETON, motion, (KeyedParts.of(SKELETON, frame, NAMES, motion.pose(frame)),)
    )
    np.testing.assert_allclose(found.Rs_parent_part, motion.Rs_parent_part, atol=1e-9)


def test_limbs_set_at_different_frames_are_corrected_each_by_itself() -> None:
    motion = moving(21)
    shin = SKELETON.body.index("left_shin")
    keys = []
    for frame, part in ((8, ARM[0]), (12, shin)):
        at = motion.first_frame + frame
        pose = turned(motion.pose(at), part, (0.3, 0, 0))
        keys.append(KeyedParts.of(SKELETON, at, (SKELETON.body.names[part],), pose))
    both = closed_on(SKELETON, motion, tuple(keys))
    arm, leg = (closed_on(SKELETON, motion, (key,)) for key in keys)
    np.testing.assert_allclose(both.Rs_parent_part[:, ARM], arm.Rs_parent_part[:, ARM], atol=1e-12)
    np.testing.assert_allclose(
        both.Rs_parent_part[:, shin], leg.Rs_parent_part[:, shin], atol=1e-12
    )
