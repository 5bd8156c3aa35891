"""Names that other programs give to joints."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_names import load_names, matched
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


def _found(names: list[str] | tuple[str, ...]) -> dict[str, str]:
    return {names[i]: ours for i, ours, _ in matched(SKELETON, names, "a.bvh").known}


@pytest.mark.parametrize(
    "names",
    [MIXAMO, CMU_BVH, CMU_ASF, OPENSIM, SKELETON.body.names, *LAYOUTS.values()],
    ids=["Mixamo", "CMU BVH", "CMU", "OpenSim", "own", *LAYOUTS],
)
def test_the_usual_names_find_all_limbs(names: list[str]) -> None:
    assert set(_found(names).values()) >= LIMBS


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
    assert set(result.left_out) >= {"mixamorig:Spine", "mixamorig:LeftShoulder"}
    assert result.convention == "Mixamo, MotionBuilder"


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
