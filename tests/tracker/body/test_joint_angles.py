"""Joint angles by their clinical names: a right angle is 90, and both sides have the same signs."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.joint_angles import (
    JOINTS,
    R_ANATOMICAL_PART,
    JointAngles,
    joint_angles,
    joint_rotations,
    joints_of,
)
from keypose.tracker.body.modify import with_clavicles
from keypose.tracker.body.pose import joint_names
from keypose.tracker.body.preset_names import PEOPLE
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation, transpose
from tests.rendering.mocap import jumping_jacks, needs_mocap, pirouette, walk
from tests.rendering.motions import throw
from tests.tracker import session_cases

BODY = preset("adult_female")
FACING = np.array([[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]])
"""The ground of a person who faces an upright camera: x from her toward it."""


def angles_of(*poses: dict[str, Array], body: str = "adult_female") -> dict[str, JointAngles]:
    """The angles of poses whose parts have these rotations, by the joint's name."""
    made = preset(body)
    Rs = np.tile(np.eye(3), (len(poses), len(made.parts), 1, 1))
    for i, pose in enumerate(poses):
        for part, R in pose.items():
            Rs[i, made.index(part)] = R
    return {found.joint.name: found for found in joint_angles(made, Rs, FACING)}


def turned(axis: str, degrees: float) -> Array:
    """About one of a part's own axes: x left, y down, z back."""
    return exp_rotation(np.radians(degrees) * np.eye(3)["xyz".index(axis)])


@pytest.mark.parametrize("body", PEOPLE)
def test_at_rest_every_angle_of_a_person_is_zero(body: str) -> None:
    found = angles_of({}, body=body)
    assert list(found) == [joint.name for joint in JOINTS]
    for one in found.values():
        np.testing.assert_allclose(one.angles_deg, 0.0, atol=1e-9)


ON_BOTH_SIDES = [
    ("forearm", "x", -90, "elbow", "flexion", 90),
    ("shin", "x", 60, "knee", "flexion", 60),
    ("thigh", "x", -40, "hip", "flexion", 40),
    ("thigh", "x", 20, "hip", "flexion", -20),
    ("upper_arm", "x", -120, "shoulder", "flexion", 120),
    ("foot", "x", -15, "ankle", "dorsiflexion", 15),
    ("foot", "x", 30, "ankle", "dorsiflexion", -30),
    ("hand", "x", -15, "wrist", "ulnar_deviation", -15),
]
"""Forward and back: a turn of a part's x means the same on both sides."""

ON_THE_RIGHT = [
    ("thigh", "z", 30, "hip", "adduction", -30),
    ("thigh", "y", 25, "hip", "internal_rotation", -25),
    ("upper_arm", "z", 80, "shoulder", "adduction", -80),
    ("upper_arm", "y", -35, "shoulder", "internal_rotation", 35),
    ("forearm", "y", -50, "elbow", "pronation", 50),
    ("hand", "z", -40, "wrist", "flexion", 40),
    ("shin", "z", 8, "knee", "adduction", -8),
    ("shin", "y", 9, "knee", "internal_rotation", -9),
    ("foot", "z", -12, "ankle", "inversion", 12),
    ("foot", "y", 10, "ankle", "internal_rotation", -10),
]
"""Sideways: a right limb that leaves the body turns about its z; a left one turns back."""


@pytest.mark.parametrize(("part", "axis", "turn", "joint", "angle", "expected"), ON_BOTH_SIDES)
@pytest.mark.parametrize("side", ["left", "right"])
def test_limbs_that_bend_alike_have_the_same_angle_on_both_sides(
    side: str, part: str, axis: str, turn: float, joint: str, angle: str, expected: float
) -> None:
    found = angles_of({f"{side}_{part}": turned(axis, turn)})
    _is_all_there_is(found, f"{side}_{joint}", angle, expected)


@pytest.mark.parametrize(("part", "axis", "turn", "joint", "angle", "expected"), ON_THE_RIGHT)
@pytest.mark.parametrize("side", ["left", "right"])
def test_limbs_that_mirror_each_other_have_the_same_angles(
    side: str, part: str, axis: str, turn: float, joint: str, angle: str, expected: float
) -> None:
    given = turn if side == "right" else -turn
    found = angles_of({f"{side}_{part}": turned(axis, given)})
    _is_all_there_is(found, f"{side}_{joint}", angle, expected)


def _is_all_there_is(
    found: dict[str, JointAngles], joint: str, angle: str, expected: float
) -> None:
    assert found[joint][angle] == pytest.approx([expected])
    for one in found.values():
        rest = one.angles_deg - (0.0 if one.joint.name != joint else one[angle][:, None])
        assert np.abs(rest).min(axis=1) == pytest.approx(0.0, abs=1e-9)
    assert np.abs(found[joint].angles_deg).sum() == pytest.approx(abs(expected))


@pytest.mark.parametrize(
    ("part", "axis", "turn", "joint", "angle"),
    [
        ("chest", "x", 30, "trunk", "flexion"),
        ("chest", "z", -20, "trunk", "bending"),
        ("chest", "y", -40, "trunk", "rotation"),
        ("head", "x", 25, "neck", "flexion"),
        ("head", "z", -15, "neck", "bending"),
        ("head", "y", -50, "neck", "rotation"),
        ("waist", "x", 12, "pelvis", "anterior_tilt"),
        ("waist", "z", 7, "pelvis", "obliquity"),
        ("waist", "y", -60, "pelvis", "rotation"),
    ],
)
def test_the_trunk_bends_forward_and_to_the_right_and_turns_to_the_left(
    part: str, axis: str, turn: float, joint: str, angle: str
) -> None:
    R = turned(axis, turn)
    _is_all_there_is(angles_of({part: R}), joint, angle, abs(turn))
    top = R @ np.array([0.0, -1.0, 0.0])  # what points up at rest; the camera sees her from front
    toes = R @ np.array([0.0, 0.0, -1.0])
    if axis == "x":
        assert top[2] < 0  # toward the camera, forward
    if axis == "z":
        assert top[0] < 0 if part != "waist" else top[0] > 0  # her right; its right side up
    if axis == "y":
        assert toes[0] > 0  # her left


def test_neck_and_head_are_one_joint_and_so_are_clavicle_and_upper_arm() -> None:
    half = turned("x", 20)
    assert angles_of({"neck": half, "head": half})["neck"]["flexion"] == pytest.approx([40])
    body = with_clavicles(BODY)
    Rs = np.tile(np.eye(3), (1, len(body.parts), 1, 1))
    Rs[0, body.index("right_clavicle")] = turned("z", 10)
    Rs[0, body.index("right_upper_arm")] = turned("z", 50)
    found = {one.joint.name: one for one in joint_angles(body, Rs, FACING)}
    assert found["right_shoulder"]["adduction"] == pytest.approx([-60])


def test_flexion_is_about_the_carrier_and_rotation_about_the_part_that_moves() -> None:
    raised = turned("x", -70) @ turned("z", 10) @ turned("y", 20)  # the right thigh
    found = angles_of({"right_thigh": raised})["right_hip"]
    np.testing.assert_allclose(found.angles_deg, [[70, -10, -20]], atol=1e-9)


def test_an_arm_swung_up_sideways_has_no_jump_beyond_a_right_angle() -> None:
    sweep = [10.0 * i for i in range(18)]
    found = angles_of(*({"left_upper_arm": turned("z", -a)} for a in sweep))["left_shoulder"]
    np.testing.assert_allclose(found["adduction"], np.negative(sweep), atol=1e-6)
    np.testing.assert_allclose(found["flexion"], 0.0, atol=1e-6)


def test_somebody_who_turns_twice_round_has_no_jump_of_a_whole_turn() -> None:
    sweep = np.arange(0.0, 720.0, 15.0)
    found = angles_of(*({"waist": turned("y", -a)} for a in sweep))["pelvis"]
    np.testing.assert_allclose(found["rotation"], sweep, atol=1e-6)


def shoulder_turned(sweep: Array) -> Array:
    """Internal rotation of a left arm that hangs and is turned about its length by so much."""
    found = angles_of(*({"left_upper_arm": turned("y", a)} for a in sweep))["left_shoulder"]
    return np.asarray(found["internal_rotation"])


def test_an_angle_runs_on_past_half_a_turn() -> None:
    there_and_back = np.concatenate([np.arange(20.0, 220.0, 10.0), np.arange(220.0, 0.0, -10.0)])
    np.testing.assert_allclose(shoulder_turned(there_and_back), there_and_back, atol=1e-6)
    once_round = np.arange(20.0, 370.0, 10.0)
    np.testing.assert_allclose(np.diff(shoulder_turned(once_round)), 10.0, atol=1e-6)


def pointing(*ways: tuple[float, float]) -> Array:
    """(N, 3, 3) of a left upper arm that goes from one direction to the next in 30 frames each.

    ways: degrees from straight ahead to its own side, and from hanging upward.
    """
    places = np.concatenate(
        [np.linspace(a, b, 30, endpoint=False) for a, b in itertools.pairwise(ways)]
    )
    side, up = np.radians(places).T
    along = np.stack([np.sin(up) * np.sin(side), np.cos(up), -np.sin(up) * np.cos(side)], axis=-1)
    Rs = [np.eye(3)]
    for before, after in itertools.pairwise(np.vstack([[0.0, 1.0, 0.0], along])):
        axis = np.cross(before, after)
        sine = max(float(np.linalg.norm(axis)), 1e-12)
        Rs.append(exp_rotation(axis / sine * np.arctan2(sine, before @ after)) @ Rs[-1])
    return np.array(Rs[1:])


def circled(aside_deg: float) -> Array:
    """(N, 3, 3) of an arm that goes round twice in a plane so far from straight ahead."""
    axis = exp_rotation(np.radians([0.0, aside_deg, 0.0]))[:, 0]
    return exp_rotation(np.linspace(0.0, -4 * np.pi, 60)[:, None] * axis)


def shaken_sideways() -> Array:
    """(N, 3, 3) of an arm that is held straight sideways and shakes by some degrees."""
    shaking = exp_rotation(np.random.default_rng(0).normal(0, np.radians(2), (90, 3)))
    return np.asarray(exp_rotation(np.array([0.0, 0.0, -np.pi / 2])) @ shaking)


SMOOTH_WAYS = {
    "forward, then overhead through sideways": (
        pointing((0, 0), (0, 90), (90, 90), (90, 170)),
        1.5,
    ),
    "the same beside straight sideways": (pointing((0, 0), (0, 90), (80, 90), (80, 170)), 1.5),
    "jumping jacks a little before the body": (pointing((85, 5), (85, 175), (85, 5)), 5.5),
    "a serve": (
        pointing((0, 20), (60, 110), (150, 100), (120, 150), (0, 100), (-30, 40)),
        1.0,
    ),
    "circles overhead, ahead": (circled(0), 1e-6),
    "circles overhead, aslant": (circled(30), 1e-6),
    "circles overhead, farther aslant": (circled(60), 1e-6),
    "circles overhead, at the side": (circled(90), 1e-6),
    "held straight sideways": (shaken_sideways(), 5.0),
}
"""By what an arm does its rotations, and how far its angles may leave them, degrees."""


@pytest.mark.parametrize("way", SMOOTH_WAYS)
def test_angles_of_an_arm_do_not_jump_and_put_it_where_it_is(way: str) -> None:
    Rs, off_deg = SMOOTH_WAYS[way]
    found = angles_of(*({"left_upper_arm": R} for R in Rs))["left_shoulder"]
    assert np.abs(np.diff(found.angles_deg, axis=0)).max() < 30.0
    of_all = np.tile(np.eye(3), (len(Rs), len(BODY.parts), 1, 1))
    of_all[:, BODY.index("left_upper_arm")] = Rs
    given = joint_rotations(BODY, found.joint, of_all, FACING)
    lost = log_rotation(transpose(given) @ made_of(found))
    assert np.degrees(np.linalg.norm(lost, axis=-1)).max() < off_deg


@pytest.mark.parametrize(
    ("motion", "most_deg"),
    [
        (throw, 30.0),
        pytest.param(pirouette, 30.0, marks=needs_mocap),
        pytest.param(jumping_jacks, 45.0, marks=needs_mocap),
    ],
)
def test_angles_of_rendered_motions_do_not_jump(
    motion: Callable[[Skeleton], Trajectory], most_deg: float
) -> None:
    Rs = motion(Skeleton.of(BODY)).Rs_parent_part
    for found in joint_angles(BODY, Rs, FACING):
        assert np.abs(np.diff(found.angles_deg, axis=0)).max() < most_deg, found.joint.name


@needs_mocap
def test_a_pirouette_turns_the_pelvis_on_beyond_one_turn() -> None:
    Rs = pirouette(Skeleton.of(BODY)).Rs_parent_part
    pelvis = next(one for one in joint_angles(BODY, Rs, FACING) if one.joint.name == "pelvis")
    assert np.ptp(pelvis["rotation"]) > 700
    for name in ("anterior_tilt", "obliquity"):
        assert np.ptp(pelvis[name]) < 45


def made_of(found: JointAngles) -> Array:
    """(N, 3, 3) Rz · Rx · Ry of a joint's angles."""
    signs = [angle.sign for angle in found.joint.angles]
    z, x, y = (np.radians(found.angles_deg) * signs).T[..., None]
    e = np.eye(3)
    return np.asarray(exp_rotation(z * e[2]) @ exp_rotation(x * e[0]) @ exp_rotation(y * e[1]))


def test_frames_that_are_not_known_have_no_angle_and_change_no_other() -> None:
    known = {"left_shin": turned("x", 30)}
    found = angles_of(known, {"left_shin": np.full((3, 3), np.nan)}, known)
    assert found["left_knee"]["flexion"] == pytest.approx([30, np.nan, 30], nan_ok=True)
    assert found["right_knee"]["flexion"] == pytest.approx([0, 0, 0])


def test_a_body_that_is_no_person_has_no_clinical_angles() -> None:
    assert joints_of(session_cases.body()) == ()


def test_angles_make_their_rotation_again_away_from_the_pole() -> None:
    for R in exp_rotation(np.random.default_rng(3).normal(size=(50, 3))):
        found = angles_of({"right_thigh": R})["right_hip"]
        if abs(found["adduction"][0]) < 70:
            given = R_ANATOMICAL_PART @ R @ R_ANATOMICAL_PART.T
            np.testing.assert_allclose(made_of(found)[0], given, atol=1e-12)


@needs_mocap
def test_elbows_and_knees_of_recorded_motion_bend_as_far_as_their_bones_do() -> None:
    skeleton = Skeleton.of(BODY)
    for motion in (walk(skeleton, constrained=False), jumping_jacks(skeleton)):
        found = {one.joint.name: one for one in joint_angles(BODY, motion.Rs_parent_part, FACING)}
        p = dict(zip(joint_names(skeleton), motion.joints(skeleton).swapaxes(0, 1), strict=True))
        for side in ("left", "right"):
            for joint, parts in (
                ("knee", ("thigh", "shin", "foot")),
                ("elbow", ("upper_arm", "forearm", "hand")),
            ):
                near, middle, far = (p[f"{side}_{part}"] for part in parts)
                upper, lower = middle - near, far - middle
                across = np.linalg.norm(np.cross(upper, lower), axis=-1)
                bend = np.degrees(np.arctan2(across, (upper * lower).sum(axis=-1)))
                one = found[f"{side}_{joint}"]
                np.testing.assert_allclose(np.abs(one["flexion"]), bend, atol=1.0)
                aside = np.cos(np.radians([one["flexion"], one["adduction"]])).prod(axis=0)
                np.testing.assert_allclose(np.degrees(np.arccos(aside)), bend, atol=1e-4)


@needs_mocap
def test_legs_of_a_recorded_walk_swing_forward_and_back_in_turn_within_what_is_healthy() -> None:
    skeleton = Skeleton.of(BODY)
    motion = walk(skeleton)
    found = {one.joint.name: one for one in joint_angles(BODY, motion.Rs_parent_part, FACING)}
    left, right = (found[f"{side}_hip"]["flexion"] for side in ("left", "right"))
    assert np.corrcoef(left, right)[0, 1] < -0.6
    for hip in (left, right):
        assert -25 < hip.min() < -5
        assert 20 < hip.max() < 40
    for side in ("left", "right"):
        assert 50 < found[f"{side}_knee"]["flexion"].max() < 80
        assert found[f"{side}_knee"]["flexion"].min() > -5
