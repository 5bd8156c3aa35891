"""Names of keypoints, and the order in which detectors list them."""

from __future__ import annotations

import pytest

from keypose.tracker.formats.joint_names import plain
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.layouts import LAYOUTS, keypoint_name, layouts_of


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_layout_names_every_keypoint_once_and_the_twelve_joints(layout: str) -> None:
    names = LAYOUTS[layout]
    assert len(names) == int(layout.split("_")[-1].removesuffix("B"))
    assert len(set(names)) == len(names)
    assert set(names) >= set(JOINTS)
    assert [keypoint_name(name) for name in names] == list(names)


@pytest.mark.parametrize(
    ("layout", "places"),
    [
        ("COCO_17", {5: "left_shoulder", 10: "right_wrist", 16: "right_ankle"}),
        ("COCO_WHOLEBODY_133", {17: "left_big_toe", 22: "right_heel", 23: "face_0",
                                91: "left_hand_root", 132: "right_pinky_finger4"}),
        ("OPENPOSE_18", {1: "neck", 4: "right_wrist", 8: "right_hip", 14: "right_eye"}),
        ("BODY_25", {1: "neck", 8: "mid_hip", 11: "right_ankle", 17: "right_ear",
                     19: "left_big_toe", 24: "right_heel"}),
        ("BODY_25B", {5: "left_shoulder", 17: "upper_neck", 18: "head_top", 19: "left_big_toe",
                      22: "right_big_toe"}),
        ("HALPE_26", {17: "head_top", 18: "neck", 19: "mid_hip", 20: "left_big_toe",
                      21: "right_big_toe", 25: "right_heel"}),
        ("MEDIAPIPE_33", {2: "left_eye", 8: "right_ear", 11: "left_shoulder", 16: "right_wrist",
                          23: "left_hip", 28: "right_ankle", 29: "left_heel",
                          32: "right_foot_index"}),
    ],
)  # fmt: skip
def test_keypoints_are_where_the_projects_list_them(layout: str, places: dict[int, str]) -> None:
    assert {i: LAYOUTS[layout][i] for i in places} == places


def test_only_two_layouts_share_a_count() -> None:
    shared = [layouts_of(n) for n in range(200) if len(layouts_of(n)) > 1]
    assert shared == [("BODY_25", "BODY_25B")]


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ("LKnee", "left_knee"),
        ("right_ankle", "right_ankle"),
        ("Left Knee", "left_knee"),
        ("RBigToe", "right_big_toe"),
        ("left_bigtoe", "left_big_toe"),
        ("LEFT_FOOT_INDEX", "left_foot_index"),
        ("MOUTH_LEFT", "left_mouth"),
        ("MidHip", "mid_hip"),
        ("face-7", "face_7"),
        ("LeftUpLeg", "left_up_leg"),
        ("tail", "tail"),
    ],
)
def test_a_name_is_one_however_it_is_written(given: str, name: str) -> None:
    assert keypoint_name(given) == name


@pytest.mark.parametrize("given", ["LeftForeArm", "mixamorig:LeftArm", "HeadTop_End", "lowerneck"])
def test_a_name_of_another_convention_stays_the_same_to_it(given: str) -> None:
    assert plain(keypoint_name(given)) == plain(given)
