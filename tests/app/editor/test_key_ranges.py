"""Several keyframes at once: moved, stretched, copied and deleted, each one step of undo."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from keypose.app.editor.actions import ACTIONS
from keypose.app.editor.documents import ActionRefused
from tests.app.editor.desk import after, desk

KEYS = (0, 24, 48, 72)


def retime(frames: list[int], to: list[int], **more: object) -> dict[str, object]:
    return {"do": "retime_keys", "frames": frames, "to": to, **more}


def test_several_keyframes_move_together_with_their_poses_as_one_step() -> None:
    before = desk()
    moved = after(before, retime([24, 48], [30, 54]))
    assert moved.keys == (0, 30, 54, 72)
    was, now = before.doc.subject.keyframes[1], moved.doc.subject.keyframes[1]
    assert (now.root_m, now.rotations_wxyz) == (was.root_m, was.rotations_wxyz)
    assert now.time_s == moved.times_s[30]
    assert moved.history.past[-1].label == "move 2 keyframes"
    assert after(moved, {"do": "undo"}).keys == KEYS


def test_a_range_may_move_onto_frames_that_it_leaves() -> None:
    moved = after(desk(), retime([0, 24, 48], [24, 48, 71]))
    assert moved.keys == (24, 48, 71, 72)


def test_stretching_keeps_every_pose_and_is_called_so() -> None:
    before = desk()
    stretched = after(before, retime([24, 48], [24, 60]))
    assert stretched.keys == (0, 24, 60, 72)
    assert (
        stretched.doc.subject.keyframes[2].rotations_wxyz
        == before.doc.subject.keyframes[2].rotations_wxyz
    )
    assert stretched.history.past[-1].label == "stretch 2 keyframes"


def test_copies_leave_the_keyframes_where_they_are() -> None:
    copied = after(desk(), retime([0, 24], [10, 34], copy_them=True))
    assert copied.keys == (0, 10, 24, 34, 48, 72)
    assert copied.history.past[-1].label == "copy 2 keyframes"


def test_another_keyframe_is_never_swallowed() -> None:
    with pytest.raises(ActionRefused, match="Frame 72 is already a keyframe"):
        after(desk(), retime([24, 48], [48, 72]))
    with pytest.raises(ActionRefused, match="Frames 24 and 48 are already keyframes"):
        after(desk(), retime([0, 24], [24, 48], copy_them=True))


def test_a_limb_that_is_keyed_alone_is_never_swallowed() -> None:
    state = after(
        desk(), {"do": "go", "frame": 12}, {"do": "key_parts", "frame": 12, "parts": ["left_hand"]}
    )
    with pytest.raises(ActionRefused, match="Frame 12 is already a keyframe"):
        after(state, retime([0, 24], [12, 30]))
    copied = after(state, {"do": "copy_pose", "frames": [0, 24]})
    with pytest.raises(ActionRefused, match="Frame 12 is already a keyframe"):
        after(copied, {"do": "paste_pose"})
    replaced = after(copied, {"do": "go", "frame": 12}, {"do": "paste_pose", "replace": True})
    assert replaced.keys == (0, 12, 24, 36, 48, 72)
    assert replaced.doc.subject.part_keyframes == ()


def test_frames_outside_the_video_and_those_without_a_keyframe_are_refused() -> None:
    with pytest.raises(ActionRefused, match="The video has frames 0 to 72"):
        after(desk(), retime([48, 72], [50, 74]))
    with pytest.raises(ActionRefused, match="Frame 25 is not a keyframe"):
        after(desk(), retime([24, 25], [30, 31]))


@pytest.mark.parametrize(
    ("frames", "to"), [([24, 48], [30]), ([48, 24], [30, 31]), ([24, 48], [30, 30]), ([], [])]
)
def test_a_message_has_one_frame_for_each_in_order(frames: list[int], to: list[int]) -> None:
    with pytest.raises(ValidationError):
        ACTIONS.validate_python(retime(frames, to))


def test_a_draft_where_a_keyframe_goes_does_not_hide_it() -> None:
    drafted = after(desk(), {"do": "go", "frame": 30}, {"do": "root", "x": 0.1})
    assert [draft.frame for draft in drafted.doc.subject.drafts] == [30]
    moved = after(drafted, retime([24, 48], [30, 54]))
    assert moved.doc.subject.drafts == ()


def test_several_keyframes_are_deleted_as_one_step() -> None:
    left = after(desk(), {"do": "delete_keys", "frames": [24, 72]})
    assert left.keys == (0, 48)
    assert left.history.past[-1].label == "delete 2 keyframes"
    with pytest.raises(ActionRefused, match="Frame 24 is not a keyframe"):
        after(left, {"do": "delete_keys", "frames": [24]})
