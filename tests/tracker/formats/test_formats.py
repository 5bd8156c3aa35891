"""Motion in other programs' formats, read back by readers that know nothing of the writers."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from keypose.tracker.body.body import Body, Part, preset
from keypose.tracker.body.pose import joint_names
from keypose.tracker.body.preset_names import PEOPLE
from keypose.tracker.body.shapes import Cylinder
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.conventions import end_site
from keypose.tracker.formats.csv import angles_csv, column_names, joints_csv
from keypose.tracker.geometry.rotations import Array, exp_rotation
from tests.tracker import session_cases as cases
from tests.tracker.formats import recordings
from tests.tracker.formats.recordings import bvh_of

TO_BVH = np.diag([1.0, -1.0, -1.0])
"""Camera frame (y down, z forward) to the world of a BVH file (y up, z toward the viewer)."""


@dataclass
class Node:
    """A joint or an end site of a BVH file."""

    name: str
    offset: tuple[float, ...] = (0.0, 0.0, 0.0)
    channels: list[str] = field(default_factory=list)
    children: list[Node] = field(default_factory=list)


def read_bvh(text: str) -> tuple[Node, float, list[list[float]]]:
    """The root, the time of a frame, and the values of each frame."""
    words = iter(text.split())
    assert [next(words), next(words)] == ["HIERARCHY", "ROOT"]
    root = _read_node(next(words), words)
    assert [next(words), next(words)] == ["MOTION", "Frames:"]
    count = int(next(words))
    assert [next(words), next(words)] == ["Frame", "Time:"]
    frame_time = float(next(words))
    values = [float(word) for word in words]
    width = len(values) // count
    assert len(values) == count * width
    return root, frame_time, [values[i * width : (i + 1) * width] for i in range(count)]


def _read_node(name: str, words: Any) -> Node:
    node = Node(name)
    assert next(words) == "{"
    while (word := next(words)) != "}":
        if word == "OFFSET":
            node.offset = (float(next(words)), float(next(words)), float(next(words)))
        elif word == "CHANNELS":
            node.channels = [next(words) for _ in range(int(next(words)))]
        elif word == "JOINT":
            node.children.append(_read_node(next(words), words))
        else:
            assert [word, next(words)] == ["End", "Site"]
            node.children.append(_read_node(f"{name} end", words))
    return node


def bvh_positions(root: Node, values: list[float]) -> dict[str, Array]:
    """Where every node is in one frame."""
    places: dict[str, Array] = {}
    supply = iter(values)

    def visit(node: Node, R: Array, p: Array) -> None:
        p, R = p + R @ np.array(node.offset), R.copy()
        for channel in node.channels:
            axis, kind = "XYZ".index(channel[0]), channel[1:]
            if kind == "position":
                p[axis] += next(supply)
            else:
                R = R @ _turn(axis, math.radians(next(supply)))
        places[node.name] = p
        for child in node.children:
            visit(child, R, p)

    visit(root, np.eye(3), np.zeros(3))
    assert next(supply, None) is None
    return places


def _turn(axis: int, angle: float) -> Array:
    """A rotation about one axis, right-handed."""
    i, k = (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[i, i] = R[k, k] = math.cos(angle)
    R[k, i] = math.sin(angle)
    R[i, k] = -math.sin(angle)
    return R


@pytest.mark.parametrize("name", ["small", *PEOPLE])
def test_a_bvh_reader_finds_the_joints_where_they_are(name: str) -> None:
    body = cases.body() if name == "small" else preset(name)
    skeleton = Skeleton.of(body)
    trajectory = cases.motion(skeleton)
    root, frame_time, frames = read_bvh(bvh_of(skeleton, trajectory, 1 / 30))
    assert frame_time == pytest.approx(1 / 30)
    assert len(frames) == len(trajectory)
    expected_m = trajectory.joints(skeleton) @ TO_BVH.T
    for values, joints in zip(frames, expected_m, strict=True):
        places = bvh_positions(root, values)
        for part, p in zip(body.names, joints, strict=False):
            np.testing.assert_allclose(places[part], p, atol=1e-5)


def test_limbs_end_at_their_landmarks_or_at_the_end_of_their_shape() -> None:
    skeleton = cases.SKELETON
    trajectory = cases.motion(skeleton)
    root, _, frames = read_bvh(bvh_of(skeleton, trajectory, 0.04))
    tip = joint_names(skeleton).index("tip")
    Ts = trajectory.transforms(skeleton)
    for i, values in enumerate(frames):
        places = bvh_positions(root, values)
        p_tip = trajectory.joints(skeleton)[i, tip]
        np.testing.assert_allclose(places["left_hand end"], TO_BVH @ p_tip, atol=1e-5)
        T = Ts[i, skeleton.body.index("right_arm")]
        p_end = (T @ (0.0, -0.4, 0.0, 1.0))[:3]
        np.testing.assert_allclose(places["right_arm end"], TO_BVH @ p_end, atol=1e-5)
    assert end_site(skeleton.body.parts[0]) == pytest.approx((0.0, 0.3, 0.0))


def test_a_standing_body_stands_upright_in_bvh() -> None:
    skeleton = Skeleton.of(preset("adult_male"))
    rest = Trajectory(0, np.tile(np.eye(3), (1, 16, 1, 1)), np.array([[0.0, 0.0, 5.0]]))
    root, _, frames = read_bvh(bvh_of(skeleton, rest, 0.04))
    places = bvh_positions(root, frames[0])
    assert places["head"][1] > places["waist"][1] > places["left_foot"][1]
    assert places["waist"][2] == pytest.approx(-5)
    assert frames[0][3:] == [0.0] * 48


def test_names_with_blanks_stay_one_word_and_different_in_bvh() -> None:
    parts = [
        Part(name=name, parent=parent, shape=Cylinder(end_m=0.3, radius_m=0.1))
        for name, parent in (("the trunk", None), ("an arm", "the trunk"), ("an_arm", "the trunk"))
    ]
    skeleton = Skeleton.of(Body(name="odd", parts=tuple(parts)))
    root, _, _ = read_bvh(bvh_of(skeleton, cases.motion(skeleton), 0.1))
    assert [root.name, *(child.name for child in root.children)] == [
        "the_trunk",
        "an_arm",
        "an_arm_",
    ]


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), float("inf")])
def test_bvh_needs_a_time_between_frames(seconds: float) -> None:
    with pytest.raises(FormatError, match="positive time"):
        bvh_of(cases.SKELETON, cases.motion(cases.SKELETON), seconds)


def rows(text: str) -> list[dict[str, float]]:
    return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(io.StringIO(text))]


def test_the_table_of_joints_holds_metres_in_the_camera_frame() -> None:
    trajectory = cases.motion(cases.SKELETON)
    times = [0.0, 0.04, 0.08, 0.12, 0.16]
    table = rows(joints_csv(cases.SKELETON, trajectory, times))
    joints = trajectory.joints(cases.SKELETON)
    assert [row["frame"] for row in table] == [7, 8, 9, 10, 11]
    assert [row["time_s"] for row in table] == pytest.approx(times)
    for i, name in enumerate(joint_names(cases.SKELETON)):
        found = [[row[f"{name}_{axis}_m"] for axis in "xyz"] for row in table]
        np.testing.assert_allclose(found, joints[:, i], atol=1e-6)


def test_the_table_of_angles_turns_back_into_the_rotations() -> None:
    trajectory = cases.motion(cases.SKELETON)
    table = rows(angles_csv(cases.SKELETON, trajectory, [0.0] * 5))
    for frame, row in enumerate(table):
        for i, name in enumerate(cases.SKELETON.body.names):
            z, y, x = (math.radians(row[f"{name}_r{axis}_deg"]) for axis in "zyx")
            R = _turn(2, z) @ _turn(1, y) @ _turn(0, x)
            np.testing.assert_allclose(R, trajectory.Rs_parent_part[frame, i], atol=1e-7)


def test_angles_of_the_table_run_on_where_the_body_turns_round() -> None:
    turns = np.radians(np.arange(0.0, 720.0, 15.0))
    Rs = np.tile(np.eye(3), (len(turns), 4, 1, 1))
    leaning = exp_rotation(np.array([0.1, 0.0, 0.05]))
    Rs[:, 0] = exp_rotation(turns[:, None] * [0.0, 1.0, 0.0]) @ leaning
    Rs[:, 1] = exp_rotation(turns[:, None] * [1.0, 0.0, 0.0])
    motion = Trajectory(0, Rs, np.zeros((len(turns), 3)))
    table = rows(angles_csv(cases.SKELETON, motion, np.arange(len(turns)) / 30))
    for name in ("trunk_heading_deg", f"{cases.SKELETON.body.names[1]}_rx_deg"):
        np.testing.assert_allclose(np.diff([row[name] for row in table]), 15.0, atol=1e-4)
    for name in ("trunk_roll_deg", "trunk_pitch_deg"):
        assert np.ptp([row[name] for row in table]) < 1e-4


def test_a_table_has_one_header_and_no_minus_zero() -> None:
    rest = Trajectory(0, np.tile(np.eye(3), (2, 4, 1, 1)), np.full((2, 3), -1e-9))
    text = angles_csv(cases.SKELETON, rest, [0.0, 0.04])
    assert text.splitlines()[0].startswith("frame,time_s,trunk_rz_deg,trunk_ry_deg,trunk_rx_deg")
    assert "-0.000000" not in text + joints_csv(cases.SKELETON, rest, [0.0, 0.04])
    assert text.count("\r\n") == 3


def test_where_depth_was_lifted_clinical_angles_have_what_they_are_expected_to_be_off_by() -> None:
    made = recordings.with_depth(recordings.recording("person"))
    knee = next(each for each in made.joint_angles if each.joint.name == "left_knee")
    table = rows(angles_csv(made.skeleton, made.trajectory, made.times_s, made.joint_angles))
    for name in ("left_knee_flexion_deg", "left_knee_flexion_expected_error_deg"):
        assert name in table[0]
    errors = [row["left_knee_flexion_expected_error_deg"] for row in table]
    assert errors == pytest.approx(list(np.asarray(knee.error_deg("flexion"))), abs=1e-6)
    plain = recordings.recording("person")
    without = angles_csv(plain.skeleton, plain.trajectory, plain.times_s, plain.joint_angles)
    assert "expected_error" not in without


def test_landmarks_of_the_same_name_carry_their_part() -> None:
    trunk, right, left, hand = cases.body().parts
    right = right.model_copy(update={"landmarks": {"tip": (0.0, -0.4, 0.0)}})
    skeleton = Skeleton.of(Body(name="two tips", parts=(trunk, right, left, hand)))
    assert column_names(skeleton)[4:] == ("right_arm.tip", "thumb", "left_hand.tip")


def test_a_table_needs_a_time_for_every_frame() -> None:
    with pytest.raises(FormatError, match="2 times were given for a motion of 5 frames"):
        joints_csv(cases.SKELETON, cases.motion(cases.SKELETON), [0.0, 1.0])
