"""A limb that was posed toward the camera instead of away from it is turned with one press."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from keypose.app.editor import posing
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.tracker.body.pose import Pose, joint_names, joint_positions, pose_transforms
from keypose.tracker.geometry.rotations import Array, exp_rotation
from tests.app.editor.desk import after, desk

LIMB_PX = 3.0
BODY_PX = 5.0
"""How near the joints stay to their pixels: the worst of a limb, and the mean of the body, whose
joints do not all bend that way."""


def joints(state: EditorState) -> dict[str, Array]:
    Ts = pose_transforms(state.skeleton, shown_pose(state).pose)
    return dict(zip(joint_names(state.skeleton), joint_positions(state.skeleton, Ts), strict=True))


def pixels(state: EditorState) -> dict[str, Array]:
    found = joints(state)
    uv = state.doc.view.camera.project(np.array(list(found.values())))
    return dict(zip(found, uv, strict=True))


def depth(state: EditorState, one: str, other: str) -> float:
    """How much nearer to the camera `other` is, metres."""
    found = joints(state)
    return float(np.linalg.norm(found[one]) - np.linalg.norm(found[other]))


@pytest.mark.parametrize(
    ("frame", "part", "end"),
    [
        (0, "left_forearm", "left_hand"),
        (24, "right_thigh", "right_foot"),
        (48, "left_upper_arm", "left_forearm"),
        (72, "right_thigh", "right_foot"),
    ],
)
def test_a_limb_goes_the_other_way_in_depth_and_stays_where_it_is_seen(
    frame: int, part: str, end: str
) -> None:
    before = after(desk(), {"do": "go", "frame": frame})
    turned = after(before, {"do": "turn_in_depth", "part": part})
    assert depth(before, part, end) * depth(turned, part, end) < 0
    seen = pixels(before)
    assert max(np.linalg.norm(uv - seen[name]) for name, uv in pixels(turned).items()) < LIMB_PX
    still = [
        name
        for name in before.doc.subject.body.names
        if name.startswith(("waist", "chest", "head"))
    ]
    ways = joints(before), joints(turned)
    assert all((ways[0][name] == ways[1][name]).all() for name in still), "the rest is untouched"


def test_a_limb_that_would_be_seen_elsewhere_is_not_turned(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its joints do not bend that way, and the nearest that they do is another picture."""
    before = after(desk(), {"do": "go", "frame": 24})
    shin = before.doc.subject.body.index("right_shin")
    plain = posing.turned_in_depth

    def swung(*given: Any) -> Pose:
        found = plain(*given)
        Rs = found.Rs_parent_part.copy()
        Rs[shin] = exp_rotation(np.array([0.0, 0.0, 0.5])) @ Rs[shin]
        return Pose(Rs, found.p_camera_root)

    monkeypatch.setattr(posing, "turned_in_depth", swung)
    with pytest.raises(ActionRefused, match="Right thigh cannot bend the other way"):
        after(before, {"do": "turn_in_depth", "part": "right_thigh"})


def test_the_whole_body_is_turned_with_one_press_and_undone_with_another() -> None:
    before = after(desk(), {"do": "go", "frame": 24})
    turned = after(before, {"do": "turn_in_depth"})
    shoulders = "left_upper_arm", "right_upper_arm"
    assert depth(turned, *shoulders) == pytest.approx(-depth(before, *shoulders), abs=0.1)
    seen = pixels(before)
    off = [np.linalg.norm(uv - seen[name]) for name, uv in pixels(turned).items()]
    assert np.mean(off) < BODY_PX
    assert turned.history.past[-1].label == "turn in depth"
    assert after(turned, {"do": "undo"}).doc == before.doc


def test_a_leg_whose_knee_does_not_bend_that_way_is_refused() -> None:
    before = after(desk(), {"do": "go", "frame": 0})
    with pytest.raises(ActionRefused, match="Left thigh cannot bend the other way"):
        after(before, {"do": "turn_in_depth", "part": "left_thigh"})


def test_what_lies_across_the_view_is_not_turned() -> None:
    across = after(desk(), {"do": "go", "frame": 24}, {"do": "reset_pose"})
    with pytest.raises(ActionRefused, match="Left forearm lies across the view"):
        after(across, {"do": "turn_in_depth", "part": "left_forearm"})


def test_between_keyframes_a_limb_is_turned_and_keyed_alone() -> None:
    before = after(desk(), {"do": "go", "frame": 12})
    turned = after(before, {"do": "turn_in_depth", "part": "left_forearm", "partial": True})
    (keyed,) = turned.doc.subject.part_keyframes
    assert keyed.frame == 12
    assert keyed.parts == ("left_upper_arm", "left_forearm", "left_hand")
    assert turned.doc.subject.keyframes == before.doc.subject.keyframes
    assert turned.doc.subject.drafts == ()
    assert (
        depth(before, "left_forearm", "left_hand") * depth(turned, "left_forearm", "left_hand") < 0
    )
    with pytest.raises(ActionRefused, match="whole body was moved"):
        after(before, {"do": "turn_in_depth", "partial": True})
