"""What errors of joints, in the picture and along the view, make of angles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from keypose.tracker.body.angle_errors import (
    DEFINED_RAD,
    MEDIAN_OF_SIGMA,
    PASSED_ON,
    TURNED_RAD,
    UNSEEN_RAD,
    angle_errors,
    direction_errors,
    in_metres,
)
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.joint_angles import Joint
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation

BODY = preset("adult_male")
SKELETON = Skeleton.of(BODY)
FAR_M = 6.0
FRAMES = 300  # more than are worked on at a time


class Errors(NamedTuple):
    """Radians: of parts (N, P), and of angles (N, 3) by joint."""

    directions: Array
    angles: dict[Joint, Array]


def posed(**bent_rad: tuple[float, float, float]) -> Trajectory:
    """The body upright before the camera, some parts turned, in all frames alike."""
    pose = Pose.rest(SKELETON, (0.0, 0.0, FAR_M))
    R, _ = pose.writable()
    for name, turn in bent_rad.items():
        R[BODY.index(name)] = exp_rotation(np.array(turn))
    Rs = np.broadcast_to(R, (FRAMES, *R.shape))
    return Trajectory(0, Rs, np.broadcast_to(pose.p_camera_root, (FRAMES, 3)))


def errors_of(along_m: dict[str, float], motion: Trajectory, across_m: float = 0.0) -> Errors:
    """along_m: of the joint at the far end of some parts; the others are exact."""
    along = np.zeros((FRAMES, SKELETON.part_count))
    for name, error in along_m.items():
        along[:, BODY.index(name)] = error
    given = SKELETON, motion, np.full(along.shape, across_m), along
    directions, angles = direction_errors(*given), angle_errors(*given, np.eye(3))
    assert directions is not None
    assert angles is not None
    return Errors(directions, angles)


def direction(found: Errors, part: str) -> float:
    """The same in every frame."""
    column = found.directions[:, BODY.index(part)]
    assert np.ptp(column) == pytest.approx(0.0, abs=1e-12)
    return float(column[0])


def angle(found: Errors, joint: str, name: str) -> float:
    which = next(each for each in found.angles if each.name == joint)
    return float(found.angles[which][-1, [each.name for each in which.angles].index(name)])


def beyond_definition(error: float) -> float:
    """Without what every direction is unsure by."""
    return float(np.sqrt(max(error**2 - DEFINED_RAD**2, 0.0)))


def length(part: str) -> float:
    """Of the bone from a part's joint to the next, metres."""
    ends = {"left_thigh": "left_shin", "left_shin": "left_foot"}
    return float(np.linalg.norm(BODY.parts[BODY.index(ends[part])].joint_m))


def test_a_bone_across_the_view_is_off_by_what_its_ends_are_over_its_length() -> None:
    found = errors_of({"left_thigh": 0.06}, posed())
    assert beyond_definition(direction(found, "left_thigh")) == pytest.approx(
        0.06 / length("left_thigh"), rel=0.01
    )
    assert direction(found, "right_thigh") == pytest.approx(DEFINED_RAD)


def test_a_bone_that_points_at_the_camera_is_not_turned_by_an_error_along_the_view() -> None:
    raised = posed(left_thigh=(-np.pi / 2, 0.0, 0.0))
    deep = errors_of({"left_thigh": 0.06}, raised)
    aside = errors_of({}, raised, across_m=0.02)
    assert beyond_definition(direction(deep, "left_thigh")) < 0.2 * 0.06 / length("left_thigh")
    assert beyond_definition(direction(aside, "left_thigh")) > 0.02 / length("left_thigh")


def test_an_error_that_is_passed_on_leaves_the_next_bone_surer_than_its_ends() -> None:
    found = errors_of({"left_thigh": 0.06, "left_shin": 0.06}, posed())
    apart = 0.06 * np.sqrt(2 * (1 - PASSED_ON))
    assert beyond_definition(direction(found, "left_shin")) == pytest.approx(
        apart / length("left_shin"), rel=0.01
    )


def test_the_hips_line_is_off_by_both_hips_which_err_to_either_side_of_their_middle() -> None:
    found = errors_of({"waist": 0.01}, posed())
    hips = [BODY.parts[BODY.index(f"{side}_thigh")].joint_m[0] for side in ("left", "right")]
    assert beyond_definition(direction(found, "waist")) == pytest.approx(
        0.02 / (hips[0] - hips[1]), rel=0.02
    )
    assert angle(found, "pelvis", "rotation") == pytest.approx(direction(found, "waist"), rel=0.02)


@pytest.mark.parametrize("bent_deg", [15.0, 40.0, 90.0])
def test_a_knees_flexion_is_off_by_what_such_joints_make_of_it(bent_deg: float) -> None:
    """Against a hundred thousand legs whose joints err so, bent by what the three joints show."""
    sigma = 0.03 / MEDIAN_OF_SIGMA
    bent = np.radians(bent_deg)
    rng = np.random.default_rng(0)
    knee = sigma * rng.normal(size=100_000)
    ankle = PASSED_ON * knee + np.sqrt(1 - PASSED_ON**2) * sigma * rng.normal(size=100_000)
    thigh, shin = length("left_thigh"), length("left_shin")
    upper = np.stack([np.full_like(knee, thigh), knee], axis=-1)
    lower = np.stack(
        [np.full_like(knee, shin * np.cos(bent)), shin * np.sin(bent) + ankle - knee], axis=-1
    )
    turned = np.arctan2(lower[:, 1], lower[:, 0]) - np.arctan2(upper[:, 1], upper[:, 0])
    measured = float(np.median(np.abs(turned - bent)))
    found = errors_of({"left_thigh": 0.03, "left_shin": 0.03}, posed(left_shin=(bent, 0.0, 0.0)))
    assert beyond_definition(angle(found, "left_knee", "flexion")) == pytest.approx(
        measured, rel=0.12
    )


def test_a_bent_knee_shows_how_the_thigh_is_turned_and_a_straight_one_does_not() -> None:
    along = {"left_thigh": 0.01, "left_shin": 0.01}
    straight = angle(errors_of(along, posed()), "left_hip", "internal_rotation")
    bent = errors_of(along, posed(left_shin=(0.0, 0.0, np.pi / 2)))
    assert straight == pytest.approx(np.hypot(MEDIAN_OF_SIGMA * TURNED_RAD, DEFINED_RAD), rel=0.02)
    assert angle(bent, "left_hip", "internal_rotation") < 0.5 * straight


@pytest.mark.parametrize(
    ("joint", "name"),
    [
        ("left_wrist", "flexion"),
        ("right_ankle", "dorsiflexion"),
        ("neck", "rotation"),
        ("left_elbow", "pronation"),
        ("right_knee", "internal_rotation"),
    ],
)
def test_what_no_keypoint_shows_is_a_guess_however_exact_joints_are(joint: str, name: str) -> None:
    assert angle(errors_of({}, posed()), joint, name) == pytest.approx(UNSEEN_RAD)


def test_an_arm_straight_sideways_leaves_flexion_and_rotation_no_surer_than_a_quarter_turn() -> (
    None
):
    found = errors_of({"left_upper_arm": 0.1}, posed(left_upper_arm=(0.0, 0.0, -np.pi / 2)))
    assert angle(found, "left_shoulder", "flexion") <= np.pi / 2
    assert angle(found, "left_shoulder", "flexion") > np.radians(45)


def test_where_nothing_was_observed_nothing_is_expected() -> None:
    along = np.zeros((FRAMES, SKELETON.part_count))
    along[7] = np.nan
    found = angle_errors(SKELETON, posed(), np.zeros_like(along), along)
    assert found is not None
    knee = next(each for each in found if each.name == "left_knee")
    assert np.isnan(found[knee][7]).all()
    assert np.isfinite(np.delete(found[knee], 7, axis=0)).all()
    assert "pelvis" not in {joint.name for joint in found}  # nothing said what is up
    only = angle_errors(SKELETON, posed(), np.zeros_like(along), along, joints=[knee])
    assert only is not None
    np.testing.assert_array_equal(only[knee], found[knee])
    assert list(only) == [knee]


@pytest.mark.parametrize("name", ["box", "without hands"])
def test_of_what_is_no_person_nothing_is_expected(name: str) -> None:
    other = Skeleton.of(_other(name))
    Rs = np.broadcast_to(np.eye(3), (2, other.part_count, 3, 3))
    motion = Trajectory(0, Rs, np.full((2, 3), 3.0))
    exact: Array = np.zeros((2, other.part_count))
    assert angle_errors(other, motion, exact, exact) is None
    assert direction_errors(other, motion, exact, exact) is None


def _other(name: str) -> Body:
    if name == "box":
        return preset("box")
    parts = tuple(part for part in BODY.parts if not part.name.endswith("hand"))
    return BODY.model_copy(update={"parts": parts})  # its wrists cannot be seen apart


def test_pixels_are_metres_at_the_bodys_depth_and_fewer_through_a_lens_that_zooms() -> None:
    camera = Camera(width=640, height=480, fx=500.0, fy=500.0, cx=320.0, cy=240.0)
    ps = np.array([[0.0, 0.0, 5.0], [0.0, 0.0, 10.0]])
    px = np.full((2, 1), 10.0)
    assert in_metres(px, camera, ps).ravel() == pytest.approx([0.1, 0.2])
    assert in_metres(px, camera, ps, np.array([1.0, 2.0])).ravel() == pytest.approx([0.1, 0.1])
