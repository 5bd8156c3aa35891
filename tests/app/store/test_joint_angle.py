"""The page receives a joint's angle by its clinical name, as files of angles have it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.app.state.app_state import AppState
from keypose.app.store.sections.angle_values import joint_angle
from keypose.tracker.body.body import preset
from keypose.tracker.body.joint_angles import joint_angles
from keypose.tracker.body.skeleton import Skeleton
from tests.app.editor.desk import after, desk


def shown(joint: str | None, angle: str = "") -> Any:
    edit = after(desk(), {"do": "joint_angle", "joint": joint, "angle": angle})
    return joint_angle(AppState(edit=edit))


@pytest.mark.parametrize(
    ("joint", "angle"),
    [("knee", "flexion"), ("hip", "adduction"), ("shoulder", "flexion"), ("trunk", "bending")],
)
def test_it_is_that_of_the_poses(joint: str, angle: str) -> None:
    edit, found = desk(), shown(joint, angle)
    skeleton = Skeleton.of(edit.doc.subject.body)
    poses = {k.frame: k.pose(skeleton) for k in edit.doc.subject.keyframes}
    Rs = np.stack([pose.Rs_parent_part for pose in poses.values()])
    true = {one.joint.part: one[angle] for one in joint_angles(edit.doc.subject.body, Rs, np.eye(3))
            if one.joint.name.endswith(joint)}  # fmt: skip
    assert {side["part"] for side in found["sides"]} == {*true}
    for side in found["sides"]:
        known = {frame: value for frame, value in side["values"]}  # no two follow one another
        assert known.keys() == {*poses}
        values = [known[frame] for frame in poses]
        assert values == pytest.approx(true[side["part"]], abs=0.06)


def test_without_a_name_its_first_angle_is_meant() -> None:
    found = shown("knee")
    assert (found["angle"], found["label"]) == ("flexion", "Knee flexion")
    assert [side["side"] for side in found["sides"]] == ["L", "R"]
    choices = [(each["joint"], each["angle"]) for each in found["choices"]]
    assert len(choices) == len({*choices})
    assert ("trunk", "bending") in choices


@pytest.mark.parametrize("joint", [None, "knuckle"])
def test_no_joint_has_none(joint: str | None) -> None:
    assert shown(joint) is None


def test_what_is_no_person_has_none() -> None:
    edit = after(desk(), {"do": "joint_angle", "joint": "knee"})
    blank = {"keyframes": (), "body": preset("box")}
    thing = replace(edit, doc=edit.doc.changed(blank))
    assert joint_angle(AppState(edit=thing)) is None
