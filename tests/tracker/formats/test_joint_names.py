"""Names that other programs give to joints."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.conventions import flipped
from keypose.tracker.formats.joint_names import load_names, matched
from keypose.tracker.formats.rigs import RIGS
from keypose.tracker.formats.rigs.rig import rig_of
from keypose.tracker.keypoints.layouts import LAYOUTS

SKELETON = Skeleton.of(preset("adult_male"))
LIMBS = {
    f"{side}_{part}"
    for side in ("left", "right")
    for part in ("upper_arm", "forearm", "hand", "thigh", "shin", "foot")
}

MIXAMO = [
    f"mixamorig:{name}"
    for name in (
        *("Hips", "Spine", "Spine1", "Neck", "Head", "HeadTop_End", "LeftShoulder", "LeftArm"),
        *("LeftForeArm", "LeftHand", "RightShoulder", "RightArm", "RightForeArm", "RightHand"),
        *("LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase"),
        *("RightUpLeg", "RightLeg", "RightFoot", "RightToeBase"),
    )
]
CMU_BVH = [
    "Hips", "Chest", "Neck", "Head", *(
        f"{side}{joint}" for side in ("Left", "Right")
        for joint in ("Hip", "Knee", "Ankle", "Toe", "Collar", "Shoulder", "Elbow", "Wrist")
    ),
]  # fmt: skip
CMU_ASF = [
    "root", "lowerneck", "head", *(
        f"{side}{bone}" for side in "lr"
        for bone in ("femur", "tibia", "foot", "toes", "humerus", "radius", "wrist")
    ),
]  # fmt: skip
OPENSIM = [
    "C7", *(f"{s}{m}" for s in "LR" for m in ("SHO", "ELB", "WJC", "HJC", "KNE", "ANK", "HEE")),
]  # fmt: skip

BOTH = ("Left", "Right")
MAKERS = {
    "Biped": [f"Bip01 {n}" for n in ("Pelvis", "Neck", "Head")]
    + [f"Bip01 {s} {n}" for s in "LR" for n in ("Clavicle", "UpperArm", "Forearm", "Hand")]
    + [f"Bip01 {s} {n}" for s in "LR" for n in ("Thigh", "Calf", "Foot", "Toe0")],
    "ARKit": [f"{s}_{n}_joint" for s in ("left", "right") for n in (
        "shoulder_1", "arm", "forearm", "hand", "upLeg", "leg", "foot", "toes",
    )] + ["root_joint", "hips_joint", "spine_1_joint", "neck_1_joint", "head_joint"],
    "Unity": [f"{n}_{s}" for s in "LR" for n in (
        "Shoulder", "UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot", "Toes",
    )] + ["Hips", "Spine", "Chest", "Neck", "Head"],
    "Motive": [f"{s}{n}" for s in "LR" for n in (
        "Shoulder", "UArm", "FArm", "Hand", "Thigh", "Shin", "Foot", "Toe",
    )] + ["Hip", "Ab", "Chest", "Neck", "Head"],
    "Kinect": [f"{n}{s}" for s in BOTH for n in (
        "Shoulder", "Elbow", "Wrist", "Hand", "Hip", "Knee", "Ankle", "Foot",
    )] + ["SpineBase", "SpineMid", "Neck", "Head"],
    "Azure Kinect": [f"{n}_{s.upper()}" for s in BOTH for n in (
        "CLAVICLE", "SHOULDER", "ELBOW", "WRIST", "HAND", "HIP", "KNEE", "ANKLE", "FOOT", "EYE",
    )] + ["PELVIS", "SPINE_NAVEL", "NECK", "HEAD", "NOSE"],
    "DeepMotion": [f"{s}_{n}_JNT" for s in "lr" for n in (
        "shoulder", "arm", "forearm", "hand", "upleg", "leg", "foot", "toebase",
    )] + ["hips_JNT", "spine_JNT", "neck_JNT", "head_JNT"],
    "MakeHuman": [f"{n}.{s}" for s in "LR" for n in (
        "clavicle", "upperarm01", "upperarm02", "lowerarm01", "wrist",
        "upperleg01", "upperleg02", "lowerleg01", "foot", "toe1-1",
    )] + ["root", "spine05", "neck01", "head"],
    "SOMA": [f"{s}{n}" for s in BOTH for n in (
        "Shoulder", "Arm", "ForeArm", "Hand", "Leg", "Shin", "Foot", "ToeBase",
    )] + ["Hips", "Spine1", "Chest", "Neck1", "Head", "HeadEnd"],
    "MHR": [f"{s}_{n}" for s in "lr" for n in (
        "upleg", "lowleg", "foot", "ball", "clavicle", "uparm", "lowarm", "wrist_twist", "wrist",
    )] + ["root", "c_spine0", "c_neck", "c_head"],
    "MikuMikuDance": [f"{s}{n}" for s in "左右" for n in (
        "肩", "腕", "ひじ", "手首", "足", "ひざ", "足首", "つま先",
    )] + ["センター", "首", "頭"],
    "MikuMikuDance in English": [f"{n}_{s}" for s in "LR" for n in (
        "shoulder", "arm", "elbow", "wrist", "leg", "knee", "ankle", "toe",
    )],
    "Rokoko": [f"{s}{n}" for s in BOTH for n in (
        "Shoulder", "Arm", "ForeArm", "Hand", "Thigh", "Shin", "Foot", "Toe",
    )] + ["Hips", "Spine", "Neck", "Head"],
    "Xsens": [f"{s}{n}" for s in BOTH for n in (
        "Shoulder", "UpperArm", "Forearm", "Hand", "UpperLeg", "LowerLeg", "Foot", "Toe",
    )] + ["Pelvis", "L5", "T8", "Neck", "Head"],
    "Xsens joints": [f"j{s}{n}" for s in BOTH for n in (
        "Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle", "BallFoot",
    )],
    "Perception Neuron": [f"Robot_{s}{n}" for s in BOTH for n in (
        "Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot",
    )] + ["Robot_Hips", "Robot_Spine", "Robot_Neck", "Robot_Head"],
    "Human3.6M": ["Hip", "Spine", "Thorax", "Nose", "Head"] + [f"{s}{n}" for s in "RL" for n in (
        "Hip", "Knee", "Foot", "Shoulder", "Elbow", "Wrist",
    )],
    "MocapNET": [f"{s}{n}" for s in "lr" for n in (
        "Collar", "Shoulder", "Elbow", "Hand", "Buttock", "Hip", "Knee", "Foot",
    )] + ["hip", "abdomen", "chest", "neck", "head"],
    "DAZ Genesis": [f"{s}{n}" for s in "lr" for n in (
        "Collar", "ShldrBend", "ForearmBend", "Hand", "ThighBend", "Shin", "Foot", "Toe",
    )],
    "iPi": [f"{s}{n}" for s in "LR" for n in (
        "Clavicle", "Shoulder", "Forearm", "Hand", "Thigh", "Shin", "Foot", "Toe",
    )],
    "OpenSim bodies": [f"{n}_{s}" for s in "rl" for n in (
        "femur", "tibia", "talus", "calcn", "toes", "humerus", "ulna", "radius", "hand",
    )],
}  # fmt: skip
"""Names as other makers' files have them."""


def _found(names: list[str] | tuple[str, ...]) -> dict[str, str]:
    return {names[i]: ours for i, ours, _ in matched(SKELETON, names, "a.bvh").known}


@pytest.mark.parametrize(
    "names",
    [
        *(MIXAMO, CMU_BVH, CMU_ASF, OPENSIM, SKELETON.body.names),
        *LAYOUTS.values(),
        *MAKERS.values(),
    ],
    ids=["Mixamo", "CMU BVH", "CMU", "OpenSim", "own", *LAYOUTS, *MAKERS],
)
def test_the_usual_names_find_all_limbs(names: list[str]) -> None:
    assert set(_found(names).values()) >= LIMBS


@pytest.mark.parametrize("rig", RIGS)
def test_the_bones_that_are_exported_are_known_where_they_are(rig: str) -> None:
    bones = rig_of(SKELETON, rig)
    known = matched(SKELETON, bones.names, "a.bvh")
    assert {place[0][0] for place in known.places} >= {SKELETON.body.index(p) for p in LIMBS}
    for index, _, ((part, p_part),) in known.known:
        T_world_part = bones.Ts_world_part[part]
        p_world = T_world_part[:3, :3] @ flipped(np.array(p_part)) + T_world_part[:3, 3]
        assert np.allclose(p_world, bones.Ts_world_bone[index, :3, 3], atol=1e-9)


SIDED = [f"{s}{n}" for s in BOTH for n in ("UpLeg", "Leg", "ForeArm", "Hand", "Arm")]
KNOWN = {
    "six of ten begin so": ([*(f"qq {name}" for name in SIDED[:6]), *SIDED[6:]], 10),
    "five of ten begin so": ([*(f"qq {name}" for name in SIDED[:5]), *SIDED[5:]], 5),
    "six of ten end so": ([*(f"{name} qq" for name in SIDED[:6]), *SIDED[6:]], 10),
    "two of three begin so": (["qq LeftKnee", "qq RightKnee", "LeftElbow"], 1),
    "all begin so, and all are left": ([f"qq left_{n}" for n in ("knee", "elbow", "wrist")], 3),
}


@pytest.mark.parametrize("case", KNOWN)
def test_words_that_most_names_have_are_no_part_of_them_but_for_sides(case: str) -> None:
    names, known = KNOWN[case]
    assert len(_found(names)) == known


def test_a_foot_is_the_ankle_where_no_other_name_is() -> None:
    found = _found(MAKERS["Human3.6M"])
    assert (found["LKnee"], found["LFoot"]) == ("left_shin", "left_foot")
    assert _found(MAKERS["Kinect"])["FootLeft"] == "left_toe"
    assert _found(MAKERS["MocapNET"])["rHand"] == "right_hand"


def test_joints_count_for_whose_names_they_are_and_not_the_ends_of_parts() -> None:
    arms = [
        f"{s}{n}" for s in ("left", "right") for n in ("UpperArm", "LowerArm", "Hand", "Hand_end")
    ]
    known = matched(
        SKELETON, ["hips", "spine", "chest", "neck", "head", "head_end", *arms], "a.bvh"
    )
    assert known.convention == "VRM"
    assert "chest" in known.left_out


def test_a_wrist_lies_between_its_markers() -> None:
    names = ["LSHO", "LELB", "LWRA", "LWRB", "LKNE", "LWRA+LWRB"]
    assert _found(names)["LWRA+LWRB"] == "left_hand"


def test_a_shoulder_is_a_collar_bone_where_the_arm_has_its_own_name() -> None:
    assert _found(MIXAMO)["mixamorig:LeftArm"] == "left_upper_arm"
    assert "mixamorig:LeftShoulder" not in _found(MIXAMO)
    assert _found(CMU_BVH)["LeftShoulder"] == "left_upper_arm"


def test_left_stays_left_however_the_name_is_written() -> None:
    names = ["LEFT.KNEE", "right knee", "Left_Hip", "R-Hip", "lankle", "RAnkle"]
    found = _found(names)
    assert found["LEFT.KNEE"] == "left_shin"
    assert found["right knee"] == "right_shin"
    assert found["R-Hip"] == "right_thigh"


def test_what_has_no_place_is_left_out_and_reported() -> None:
    result = matched(SKELETON, MIXAMO, "a.bvh")
    assert set(result.left_out) >= {"mixamorig:Spine1", "mixamorig:LeftShoulder"}
    assert result.convention == "Mixamo"


def test_the_nose_is_before_the_head_and_the_left_ear_on_its_left() -> None:
    places = {ours: place for _, ours, place in matched(SKELETON, LAYOUTS["COCO_17"], "a").known}
    (_, nose), (_, ear) = places["nose"][0], places["left_ear"][0]
    assert nose[2] < -0.05
    assert ear[0] > 0.05


def test_the_heads_top_and_the_necks_upper_end_are_where_their_names_say() -> None:
    found = _found(LAYOUTS["BODY_25B"])
    assert found["head_top"] == "head_top"
    assert found["upper_neck"] == "head"
    assert _found(LAYOUTS["MEDIAPIPE_33"])["left_foot_index"] == "left_toe"


def test_a_list_of_names_alone_counts_and_is_checked(tmp_path: Path) -> None:
    path = tmp_path / "names.json"
    path.write_text(json.dumps({"a": "left_shin", "b": "head_top", "c": "LWrist"}))
    result = matched(SKELETON, ["a", "b", "c", "left_foot"], "x.csv", load_names(path))
    assert [ours for _, ours, _ in result.known] == ["left_shin", "head_top", "LWrist"]
    assert result.left_out == ("left_foot",)
    with pytest.raises(FormatError, match="has no joint 'b'"):
        matched(SKELETON, ["a", "c"], "x.csv", load_names(path))
    with pytest.raises(FormatError, match="'wing'"):
        matched(SKELETON, ["a"], "x.csv", {"a": "wing"})


@pytest.mark.parametrize("content", ["[1]", '{"a": 1}', "{", '{"a": null}'])
def test_a_list_of_names_that_is_none_is_refused(tmp_path: Path, content: str) -> None:
    (tmp_path / "names.json").write_text(content)
    with pytest.raises(FormatError, match=r"names\.json"):
        load_names(tmp_path / "names.json")
