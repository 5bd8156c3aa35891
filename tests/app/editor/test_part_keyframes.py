"""Limbs are keyed alone: the rest of the body stays with the tracker."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.app.editor.body import with_body
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.part_keyframes import limbs_of
from keypose.app.editor.shown import pose_behind, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.state.app_state import AppState
from keypose.app.store.sections import body_values
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.session import Session
from keypose.tracker.storage import changes
from tests.app.editor.desk import after, desk

RIGHT_ARM = ("right_upper_arm", "right_forearm", "right_hand")
LEFT_LEG = ("left_thigh", "left_shin", "left_foot")
AT_12 = ({"do": "go", "frame": 12},)
KEY_12 = {"do": "key_parts", "frame": 12}


def pull(handle: str, by: tuple[float, float], **more: Any) -> dict[str, Any]:
    """A drag of a handle by pixels of the main view, at frame 12."""
    state = after(desk(), *AT_12)
    body = state.doc.subject.body
    Ts = pose_transforms(state.skeleton, shown_pose(state).pose)
    u, v = state.doc.view.camera.project(Ts[body.index(handle), :3, 3]).tolist()
    at = [u + by[0], v + by[1]]
    held = {"kind": "end", "name": handle}
    return {"do": "drag", "handle": held, "view": "main", "from": [u, v], "at": at, **more}


def keyed(*messages: dict[str, Any]) -> EditorState:
    return after(desk(), *AT_12, *messages)


ARM_KEYED = (pull("right_hand", (20, -15), stroke="a"), {"do": "end_stroke", "stroke": "a"}, KEY_12)


def test_the_limb_that_was_posed_is_keyed_alone_and_its_draft_is_gone() -> None:
    state = keyed(*ARM_KEYED)
    (part,) = state.doc.subject.part_keyframes
    assert (part.frame, part.parts) == (12, RIGHT_ARM)
    assert state.doc.subject.drafts == ()
    assert state.keys == (0, 24, 48, 72)
    assert state.history.undo(state.doc) is not None
    assert after(state, {"do": "undo"}).doc.subject.drafts[0].frame == 12


def test_a_drag_may_key_its_limb_at_once_as_one_step_of_undo() -> None:
    moves = [pull("right_hand", (k, -k), stroke="a", partial=True) for k in (4, 9)]
    state = keyed(*moves, {"do": "end_stroke", "stroke": "a"})
    assert [part.parts for part in state.doc.subject.part_keyframes] == [RIGHT_ARM]
    back = after(state, {"do": "undo"})
    assert back.doc == desk().doc
    assert state.history.past[-1].label == "move right hand"


def test_a_drag_that_moves_the_whole_body_keys_no_limb() -> None:
    moved = pull("right_hand", (9, 9), partial=True) | {"handle": {"kind": "root"}}
    with pytest.raises(ActionRefused, match="Press K to key all of it"):
        keyed(moved)


def test_limbs_are_keyed_beside_those_that_are_keyed_already() -> None:
    state = keyed(*ARM_KEYED, {**KEY_12, "parts": ["left_shin"]})
    assert set(state.doc.subject.part_keyframes[0].parts) == {*RIGHT_ARM, *LEFT_LEG}
    arm = after(state, {"do": "unkey_parts", "frame": 12, "parts": ["left_foot"]})
    assert arm.doc.subject.part_keyframes[0].parts == RIGHT_ARM
    none = after(arm, {"do": "unkey_parts", "frame": 12, "parts": ["right_hand"]})
    assert none.doc.subject.part_keyframes == ()


def test_the_selected_limb_is_keyed_where_nothing_was_posed() -> None:
    state = keyed({"do": "select", "part": "left_shin"}, KEY_12)
    assert state.doc.subject.part_keyframes[0].parts == LEFT_LEG
    stands = state.doc.subject.part_keyframes[0].pose(state.skeleton)
    known = pose_behind(desk(), 12).pose
    assert np.allclose(stands.Rs_parent_part, known.Rs_parent_part, atol=1e-9)


def test_a_limb_posed_again_at_its_keyframe_changes_the_keyframe() -> None:
    state = keyed(*ARM_KEYED, pull("right_hand", (-30, 4)))
    assert state.doc.subject.drafts == ()
    (part,) = state.doc.subject.part_keyframes
    assert part.parts == RIGHT_ARM
    assert part != keyed(*ARM_KEYED).doc.subject.part_keyframes[0]
    other = keyed(*ARM_KEYED, pull("left_hand", (-3, 4)))
    assert len(other.doc.subject.part_keyframes[0].parts) == 6


def test_the_whole_body_posed_at_a_part_keyframe_waits_as_a_draft_until_k() -> None:
    moved = pull("right_hand", (9, 9)) | {"handle": {"kind": "root"}}
    state = keyed(*ARM_KEYED, moved)
    assert [draft.frame for draft in state.doc.subject.drafts] == [12]
    whole = after(state, {"do": "add_key", "frame": 12})
    assert whole.keys == (0, 12, 24, 48, 72)
    assert whole.doc.subject.part_keyframes == ()


def test_k_makes_a_part_keyframe_whole_as_it_is_shown() -> None:
    state = keyed(*ARM_KEYED)
    whole = after(state, {"do": "add_key", "frame": 12})
    assert whole.keys == (0, 12, 24, 48, 72)
    assert whole.doc.subject.part_keyframes == ()
    shown, pose = shown_pose(state).pose, whole.doc.subject.keyframes[1].pose(state.skeleton)
    assert np.allclose(shown.Rs_parent_part, pose.Rs_parent_part, atol=1e-9)


def test_part_keyframes_are_moved_copied_and_deleted_like_keyframes() -> None:
    state = keyed(*ARM_KEYED)
    moved = after(state, {"do": "move_key", "frame": 12, "to": 15})
    assert [part.frame for part in moved.doc.subject.part_keyframes] == [15]
    assert moved.doc.subject.part_keyframes[0].time_s == 0.5
    both = after(state, {"do": "duplicate_key", "frame": 12, "to": 15})
    assert [part.frame for part in both.doc.subject.part_keyframes] == [12, 15]
    assert after(both, {"do": "delete_key", "frame": 12}).doc.subject.part_keyframes[0].frame == 15
    with pytest.raises(ActionRefused, match="Frame 24 is already a keyframe"):
        after(state, {"do": "move_key", "frame": 12, "to": 24})
    alone = after(state, {"do": "delete_key", "frame": 72})
    with pytest.raises(ActionRefused, match="between two keyframes"):
        after(alone, {"do": "move_key", "frame": 12, "to": 60})


def test_a_keyframe_that_comes_to_its_frame_takes_its_place() -> None:
    state = after(keyed(*ARM_KEYED), {"do": "go", "frame": 12}, {"do": "reset_pose"})
    assert after(state, {"do": "add_key", "frame": 12}).doc.subject.part_keyframes == ()


@pytest.mark.parametrize(
    ("messages", "words"),
    [
        ([{**KEY_12, "frame": 24}], "already a keyframe of the whole body"),
        (
            [{"do": "delete_key", "frame": 72}, {**KEY_12, "frame": 60, "parts": ["left_shin"]}],
            "between two keyframes",
        ),
        ([KEY_12], "Select a limb"),
        ([{**KEY_12, "parts": ["waist"]}], "Press K"),
        ([{"do": "unkey_parts", "frame": 12, "parts": ["left_shin"]}], "not a part keyframe"),
    ],
)
def test_what_cannot_be_keyed_is_said_in_one_sentence(
    messages: list[dict[str, Any]], words: str
) -> None:
    with pytest.raises(ActionRefused, match=words):
        keyed(*messages)


def test_a_part_belongs_to_its_limb_and_takes_along_what_hangs_on_it() -> None:
    body = desk().doc.subject.body
    assert limbs_of(body, ["right_forearm"]) == RIGHT_ARM
    assert limbs_of(body, ["head"]) == ("neck", "head")
    assert {*RIGHT_ARM, "neck", "left_hand"} <= set(limbs_of(body, ["chest"]))
    with_clavicles = after(desk(), {"do": "clavicles", "on": True}).doc.subject.body
    assert limbs_of(with_clavicles, ["right_hand"]) == RIGHT_ARM
    assert limbs_of(with_clavicles, ["right_clavicle"]) == ("right_clavicle", *RIGHT_ARM)


def test_a_part_that_the_body_loses_leaves_the_keyframe_and_the_rest_of_it_stays() -> None:
    jointed = after(desk(), {"do": "clavicles", "on": True}, *AT_12)
    state = after(jointed, {**KEY_12, "parts": ["right_clavicle"]})
    without = after(state, {"do": "clavicles", "on": False})
    assert without.doc.subject.part_keyframes[0].parts == RIGHT_ARM
    stub = state.doc.subject.body.model_copy(
        update={"parts": state.doc.subject.body.parts[:1], "mirror_pairs": ()}
    )
    assert with_body(state, stub).subject.part_keyframes == ()


def test_a_longer_lens_moves_part_keyframes_away_with_the_keyframes() -> None:
    state = keyed(*ARM_KEYED)
    longer = after(state, {"do": "lens", "mm": 2 * state.doc.view.camera.focal_mm})
    assert longer.doc.subject.part_keyframes[0].root_m[2] == pytest.approx(
        2 * state.doc.subject.part_keyframes[0].root_m[2], rel=1e-6
    )


def test_what_is_keyed_comes_back_from_file_and_journal_as_it_was() -> None:
    state = keyed(*ARM_KEYED)
    assert Session.model_validate_json(state.doc.model_dump_json()) == state.doc
    reported = changes.changes(desk().doc, state.doc)
    assert reported.keys() == {"part_keyframes"}
    assert changes.apply_changes(desk().doc, reported) == state.doc
    assert "part_keyframes" not in desk().doc.model_dump(mode="json")


def test_the_page_receives_frames_limbs_and_sides() -> None:
    state = keyed(*ARM_KEYED, {**KEY_12, "parts": ["left_shin"]})
    (reported,) = body_values.keys(AppState(edit=state))["parts"]
    assert reported["frame"] == 12
    assert reported["limbs"] == [
        {"label": "Right arm", "side": "R", "parts": list(RIGHT_ARM)},
        {"label": "Left leg", "side": "L", "parts": list(LEFT_LEG)},
    ]
    assert reported["words"] == "right arm and left leg only"
    head = keyed({**KEY_12, "parts": ["head"]})
    (reported,) = body_values.keys(AppState(edit=head))["parts"]
    assert [(limb["label"], limb["side"]) for limb in reported["limbs"]] == [("Head", "C")]


def test_a_part_keyframe_not_tracked_yet_shows_the_pose_it_was_set_with() -> None:
    state = keyed(*ARM_KEYED)
    assert shown_pose(state).source == "part"
    assert shown_pose(replace(state, frame=13)).source == "between"
