"""Poses and keyframes that are copied: to other frames, sessions and bodies, by way of text."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from keypose.app.editor.actions import ACTIONS
from keypose.app.editor.copied import Copied
from keypose.app.editor.documents import ActionRefused, keyframe_of
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeyposeError
from keypose.tracker.storage.files import load_session
from tests.app.editor.desk import SAMPLE, after, angles, desk


def text_of(*frames: int, at: int = 0) -> dict[str, Any]:
    """What stands on the clipboard after these keyframes, or the pose at a frame, were copied."""
    state = after(desk(), {"do": "go", "frame": at}, {"do": "copy_pose", "frames": list(frames)})
    assert state.clipboard is not None
    found: dict[str, Any] = json.loads(state.clipboard.text)
    return found


def pasted(state: EditorState, copied: dict[str, Any], at: int, **how: Any) -> EditorState:
    paste = {"do": "paste_pose", "copied": copied, **how}
    return after(state, {"do": "go", "frame": at}, paste)


def without_keys(*frames: int) -> EditorState:
    return after(desk(), {"do": "delete_keys", "frames": list(frames)})


def test_keyframes_are_pasted_from_the_playhead_on_as_far_apart_as_they_were() -> None:
    state = pasted(desk(), text_of(0, 24, 48), 10)
    assert state.keys == (0, 10, 24, 34, 48, 58, 72)
    for was, now in ((0, 10), (24, 34), (48, 58)):
        there, here = shown_pose(desk(), was).pose, shown_pose(state, now).pose
        np.testing.assert_allclose(here.Rs_parent_part, there.Rs_parent_part, atol=1e-7)
        np.testing.assert_allclose(here.p_camera_root, there.p_camera_root, atol=1e-8)
    assert state.history.past[-1].label == "paste 3 keyframes"
    assert after(state, {"do": "undo"}).keys == desk().keys


def test_one_keyframe_is_a_pose_and_needs_no_keyframe_where_it_goes() -> None:
    assert text_of(24)["keypose"] == "pose"
    state = pasted(desk(), text_of(24), 30)
    assert [draft.frame for draft in state.doc.subject.drafts] == [30]
    assert state.keys == desk().keys
    assert state.history.past[-1].label == "paste the pose"


def test_what_stands_in_the_way_is_named_and_replaced_only_when_asked() -> None:
    with pytest.raises(ActionRefused, match="Frames 24 and 48 are already keyframes"):
        pasted(desk(), text_of(0, 24), 24)
    state = pasted(desk(), text_of(0, 24), 24, replace=True)
    assert state.keys == desk().keys
    np.testing.assert_allclose(angles(state, "head"), angles(desk(), "head"), atol=1e-5)


def test_keyframes_that_would_end_after_the_video_say_where_they_fit() -> None:
    with pytest.raises(
        ActionRefused, match=r"reach frame 78, the video ends at 72\. Go to frame 24 or"
    ):
        pasted(desk(), text_of(0, 48), 30)
    long = text_of(0, 48)
    long["keys"][1]["after"] = 90
    with pytest.raises(ActionRefused, match="span 91 frames, this video has 73"):
        pasted(desk(), long, 0)


def test_onto_the_body_here_the_way_begins_where_the_body_stands() -> None:
    moved = after(without_keys(48, 72), {"do": "go", "frame": 40}, {"do": "root", "x": 0.4})
    here = shown_pose(moved, 40).pose.p_camera_root
    state = pasted(moved, text_of(0, 24), 40, onto_body=True)
    first, second = (shown_pose(state, frame).pose.p_camera_root for frame in (40, 64))
    way = shown_pose(desk(), 24).pose.p_camera_root - shown_pose(desk(), 0).pose.p_camera_root
    np.testing.assert_allclose(first, here, atol=1e-8)
    np.testing.assert_allclose(second - first, way, atol=1e-8)


def test_parts_that_were_not_copied_stand_as_they_do_here() -> None:
    copied = text_of(24)
    kept = copied["keys"][0]["rotations_wxyz"]
    copied["keys"][0]["rotations_wxyz"] = {"head": kept["head"], "tail": [1, 0, 0, 0]}
    state = pasted(desk(), copied, 0)
    before = desk()
    np.testing.assert_allclose(angles(state, "chest"), angles(before, "chest"), atol=1e-9)
    there = after(before, {"do": "go", "frame": 24})
    np.testing.assert_allclose(angles(state, "head"), angles(there, "head"), atol=1e-5)


def test_a_body_without_any_of_the_parts_takes_nothing_and_says_so() -> None:
    copied = text_of(24)
    copied["body"] = "box"
    copied["keys"][0]["rotations_wxyz"] = {"lid": [1, 0, 0, 0]}
    with pytest.raises(ActionRefused, match="The copied body, box, has no part that this body has"):
        pasted(desk(), copied, 0)


def test_another_session_whose_body_is_a_box_takes_no_person() -> None:
    box = load_session(SAMPLE.parents[1] / "box" / "session.json")
    other = replace(
        desk(),
        doc=box,
        skeleton=Skeleton.of(box.subject.body),
        file_times_s=np.arange(200) / 30,
        frame=0,
    )
    with pytest.raises(ActionRefused, match="no part that this body has"):
        pasted(other, text_of(24), 0)


@pytest.mark.parametrize(
    "change",
    [
        {"keypose": "poem"},
        {"version": 2},
        {"keys": []},
        {"keys": [{"after": 3, "root_m": [0, 0, 3], "rotations_wxyz": {"head": [1, 0, 0, 0]}}]},
        {"keys": [{"after": 0, "root_m": [0, 0, 3], "rotations_wxyz": {"head": [9, 0, 0, 0]}}]},
        {"keys": [{"after": 0, "root_m": [0, 0, 1e9], "rotations_wxyz": {"head": [1, 0, 0, 0]}}]},
        {"keys": [{"after": 0, "root_m": [0, 0, None], "rotations_wxyz": {"head": [1, 0, 0, 0]}}]},
        {"keys": 2 * text_of(24)["keys"]},
    ],
)
def test_what_nobody_copied_here_is_refused_at_the_door(change: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        ACTIONS.validate_python({"do": "paste_pose", "copied": {**text_of(24), **change}})


def test_a_text_is_as_small_as_a_message_may_be() -> None:
    key = text_of(24)["keys"][0]
    most = Copied.model_validate(
        {"keypose": "keyframes", "keys": [{**key, "after": i} for i in range(500)]}
    )
    assert len(most.text) < 1_000_000


def test_softness_is_copied_with_a_keyframe() -> None:
    state = after(desk(), {"do": "soften_key", "frame": 24}, {"do": "copy_pose", "frames": [0, 24]})
    state = after(state, {"do": "go", "frame": 40}, {"do": "paste_pose"})
    assert [k.frame for k in state.doc.subject.keyframes if k.soft] == [24, 64]


def far_away(metres: float) -> EditorState:
    """The body so far before the camera at frame 24."""
    state = after(desk(), {"do": "go", "frame": 24})
    keyframes = [
        k.model_copy(update={"root_m": (*k.root_m[:2], metres)}) if k.frame == 24 else k
        for k in state.doc.subject.keyframes
    ]
    return state.with_doc(state.doc.changed({"keyframes": tuple(keyframes)}))


@pytest.mark.parametrize("metres", [9e3, 1.1e4, 9.9e4])
def test_a_pose_is_copied_from_and_to_as_far_away_as_a_keyframe_may_be(metres: float) -> None:
    state = after(far_away(metres), {"do": "copy_pose"}, {"do": "paste_pose", "mirrored": True})
    assert state.clipboard is not None
    again = Copied.model_validate_json(state.clipboard.text)
    assert again.keys[0].root_m[2] == pytest.approx(metres)
    state = after(state, {"do": "go", "frame": 30}, {"do": "paste_pose"}, {"do": "copy_pose"})
    assert shown_pose(state).pose.p_camera_root[2] == pytest.approx(metres)


def test_no_edit_moves_a_body_farther_away_than_a_keyframe_may_be() -> None:
    state = far_away(9e4)
    with pytest.raises(KeyposeError, match="farther than 100 km away"):
        after(state, {"do": "lens", "mm": 2000})
    farther = Pose(shown_pose(state).pose.Rs_parent_part, np.array([0.0, 0.0, 1.1e5]))
    for use in (
        lambda: Copied.pose_of(state.skeleton, farther),
        lambda: keyframe_of(state.skeleton, farther, 0, state.times_s),
    ):
        with pytest.raises(ActionRefused, match=r"farther than 100 km away\."):
            use()
