"""Edits change the document and nothing else, can be taken back, and lose nothing."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from keypose.app.editor.actions import ACTIONS
from keypose.app.editor.body import with_body
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.modify import has_clavicles, without_clavicles
from keypose.tracker.body.pose import Pose, joint_names, joint_positions, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeyposeError
from keypose.tracker.session import Session
from keypose.tracker.storage.files import session_json
from tests.app.editor.desk import after, angles, desk

TURN = {"do": "angles", "part": "left_forearm", "x": -40}

EDITS: list[dict[str, Any]] = [
    TURN,
    {"do": "root", "x": 0.4},
    {"do": "reset_part", "part": "chest"},
    {"do": "reset_pose"},
    {"do": "face", "way": "left"},
    {"do": "add_key", "frame": 10},
    {"do": "delete_key", "frame": 24},
    {"do": "move_key", "frame": 24, "to": 30},
    {"do": "duplicate_key", "frame": 24, "to": 31},
    {"do": "key_angle", "frame": 48, "part": "head", "axis": "x", "deg": 12},
    {"do": "copy_key", "from_frame": 48},
    {"do": "shape", "part": "left_thigh", "kind": "capsule"},
    {"do": "size", "part": "left_thigh", "key": "length", "cm": 40},
    {"do": "joint", "part": "head", "y": -12},
    {"do": "height", "cm": 150},
    {"do": "preset", "name": "adult_female"},
    {"do": "preset", "name": "box"},
    {"do": "body", "body": preset("cylinder").model_dump()},
    {"do": "add_part", "parent": "right_hand", "name": "racket"},
    {"do": "delete_part", "part": "left_forearm"},
    {"do": "rename_part", "part": "left_forearm", "name": "arm"},
    {"do": "clavicles", "on": True},
    {"do": "tracked", "part": "neck", "dofs": ["rx"]},
    {"do": "camera", "fx": 950},
    {"do": "field_of_view", "deg": 60},
    {"do": "distortion", "k1": 0.1},
    {"do": "vertical", "a": [300, 300], "b": [310, 100]},
    {"do": "horizon", "a": [0, 100], "b": [600, 110]},
    {"do": "add_mask", "polygon": [[0, 0], [50, 0], [0, 50]], "first": 0, "last": 10},
    {"do": "settings", "quality": "preview"},
]


@pytest.mark.parametrize("edit", EDITS, ids=lambda edit: edit["do"])
def test_every_edit_changes_the_document_and_undo_and_redo_are_exact(edit: dict[str, Any]) -> None:
    before = desk()
    done = after(before, edit)
    assert done.doc != before.doc
    undone = after(done, {"do": "undo"})
    assert undone.doc is before.doc
    assert after(undone, {"do": "redo"}).doc is done.doc


@pytest.mark.parametrize("edit", EDITS, ids=lambda edit: edit["do"])
def test_what_an_edit_leaves_can_be_saved_and_read_again(edit: dict[str, Any]) -> None:
    doc = after(desk(), edit).doc
    assert Session.model_validate_json(session_json(doc)) == doc


def test_a_pose_set_where_no_keyframe_is_becomes_a_draft_and_k_makes_it_a_keyframe() -> None:
    state = after(desk(), {"do": "go", "frame": 12}, TURN)
    assert [d.frame for d in state.doc.subject.drafts] == [12]
    assert state.keys == (0, 24, 48, 72)
    assert shown_pose(state).source == "draft"
    keyed = after(state, {"do": "add_key", "frame": 12})
    assert keyed.keys == (0, 12, 24, 48, 72)
    assert keyed.doc.subject.drafts == ()
    np.testing.assert_allclose(angles(keyed, "left_forearm")[0], -40, atol=1e-6)


def test_k_at_a_keyframe_that_was_corrected_keeps_it_and_is_no_step() -> None:
    corrected = after(desk(), {"do": "go", "frame": 24}, TURN)
    state = after(corrected, {"do": "add_key", "frame": 24})
    assert state.doc is corrected.doc
    assert state.history is corrected.history
    np.testing.assert_allclose(angles(state, "left_forearm")[0], -40, atol=1e-6)


def test_a_deleted_keyframe_is_brought_back_by_undo() -> None:
    state = after(desk(), {"do": "delete_key", "frame": 24})
    assert state.keys == (0, 48, 72)
    assert state.history.past[-1].label == "delete keyframe 24"  # the page's Undo looks for it
    assert after(state, {"do": "undo"}).keys == (0, 24, 48, 72)


def test_all_moves_of_one_stroke_are_one_step_and_only_the_last_one_counts() -> None:
    start = desk()
    moves = [{**TURN, "x": -x, "stroke": "s"} for x in range(1, 90)]
    state = after(start, *moves, {"do": "end_stroke", "stroke": "s"})
    assert len(state.history.past) == 1
    np.testing.assert_allclose(angles(state, "left_forearm")[0], -89, atol=1e-6)
    assert after(state, {"do": "undo"}).doc is start.doc


def test_a_cancelled_stroke_leaves_no_trace() -> None:
    start = desk()
    state = after(start, {**TURN, "stroke": "s"}, {"do": "cancel_stroke", "stroke": "s"})
    assert state.doc is start.doc
    assert state.history.past == ()


def test_a_late_end_of_another_stroke_changes_nothing() -> None:
    state = after(desk(), {**TURN, "stroke": "s"})
    assert after(state, {"do": "end_stroke", "stroke": "t"}) is state
    assert after(state, {"do": "cancel_stroke", "stroke": "t"}) is state


def test_late_moves_of_a_gesture_that_ended_count_no_more() -> None:
    state = after(desk(), {**TURN, "stroke": "s"}, {"do": "end_stroke", "stroke": "s"})
    assert after(state, {**TURN, "x": -80, "stroke": "s"}) is state


def test_of_two_gestures_at_once_the_one_that_began_last_goes_on() -> None:
    first, second = {**TURN, "stroke": "one"}, {"do": "root", "x": 0.3, "stroke": "two"}
    state = after(desk(), first, second, {**first, "x": -80}, {**second, "x": 0.4})
    np.testing.assert_allclose(angles(state, "left_forearm")[0], -40, atol=1e-6)
    assert shown_pose(state).pose.p_camera_root[0] == pytest.approx(0.4)
    assert after(state, {"do": "end_stroke", "stroke": "two"}, {"do": "undo"}, {"do": "undo"}).doc


def test_a_new_edit_forgets_what_could_be_done_again() -> None:
    state = after(desk(), TURN, {"do": "undo"}, {"do": "root", "x": 0.1})
    with pytest.raises(ActionRefused, match="Nothing to redo"):
        after(state, {"do": "redo"})


def test_a_twisted_arm_is_untwisted_and_one_that_is_not_stays() -> None:
    arm = {"part": "left_upper_arm"}
    with pytest.raises(KeyposeError, match="Left upper arm is not turned too far"):
        after(desk(), {"do": "untwist", **arm})
    twisted = after(desk(), {"do": "angles", **arm, "x": 0, "y": 170, "z": 0, "free": True})
    assert angles(twisted, "left_upper_arm")[1] == pytest.approx(170)
    mended = after(twisted, {"do": "untwist", **arm})
    assert abs(angles(mended, "left_upper_arm")[1]) < 125


def test_undo_goes_to_where_the_edit_was_made() -> None:
    state = after(desk(), {"do": "go", "frame": 24}, TURN, {"do": "go", "frame": 60})
    assert after(state, {"do": "undo"}).frame == 24


def test_an_edit_that_changes_nothing_is_no_step() -> None:
    state = after(desk(), {"do": "settings", "quality": "full"})
    assert state.history.past == ()


def test_looking_around_is_no_step() -> None:
    state = after(
        desk(),
        {"do": "go", "frame": 9},
        {"do": "select", "part": "head"},
        {"do": "display", "mode": "wire", "opacity": 0.2},
        {"do": "live", "on": True},
    )
    assert state.history.past == ()
    assert (state.frame, state.selected, state.display.mode) == (9, "head", "wire")


def test_a_frame_beyond_the_end_is_the_last_one() -> None:
    assert after(desk(), {"do": "go", "frame": 10_000}).frame == 72


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        ({"do": "move_key", "frame": 24, "to": 48}, "is already a keyframe"),
        ({"do": "move_key", "frame": 24, "to": 400}, "frames 0 to 72"),
        ({"do": "delete_key", "frame": 3}, "is not a keyframe"),
        ({"do": "delete_draft", "frame": 3}, "Frame 3 has no draft"),
        ({"do": "paste_pose"}, "Copy a pose first"),
        ({"do": "take_tracked"}, "not tracked"),
        ({"do": "angles", "part": "tail", "x": 3}, "no part 'tail'"),
        ({"do": "select", "part": "tail"}, "no part 'tail'"),
        ({"do": "root", "z": -3}, "behind the camera"),
        ({"do": "height", "cm": 0.1}, "between 1 and"),
        ({"do": "preset", "name": "centaur"}, "centaur"),
        ({"do": "vertical", "a": [5, 5], "b": [6, 6]}, "longer line"),
        ({"do": "horizon", "a": [5, 5], "b": [6, 6]}, "longer line"),
        ({"do": "horizon", "a": [300, 5], "b": [310, 400]}, "from side to side"),
        ({"do": "delete_mask", "index": 0}, "no longer exists"),
        ({"do": "camera", "fx": -1}, "fx"),
        ({"do": "undo"}, "Nothing to undo"),
    ],
    ids=lambda value: value["do"] if isinstance(value, dict) else "",
)
def test_what_cannot_be_done_is_refused_in_one_sentence(edit: dict[str, Any], words: str) -> None:
    state = desk()
    with pytest.raises(KeyposeError, match=words) as refusal:
        after(state, edit)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "message",
    [
        {"do": "format_disk"},
        {"do": "go", "frame": "one"},
        {"do": "go"},
        {"do": "settings", "quality": "best"},
        {"do": "settings", "cues": []},
        {"do": "settings", "cues": ["silhouette"]},
        "go",
        None,
        [],
    ],
    ids=str,
)
def test_what_is_no_action_is_stopped_at_the_door(message: Any) -> None:
    with pytest.raises(ValidationError):
        ACTIONS.validate_python(message)


def test_cues_are_chosen_and_undone_like_any_setting() -> None:
    state = after(desk(), {"do": "settings", "cues": ["keypoints"]})
    assert state.doc.settings.cues == ("keypoints",)
    assert after(state, {"do": "undo"}).doc == desk().doc


def test_copy_and_paste_mirrored_exchanges_the_sides() -> None:
    state = after(desk(), {"do": "copy_pose"}, {"do": "paste_pose", "mirrored": True})
    for left, right in state.doc.subject.body.mirror_pairs:
        there, here = angles(desk(), left), angles(state, right)
        np.testing.assert_allclose(here, there * (1, -1, -1), atol=1e-6)
    back = after(state, {"do": "copy_pose"}, {"do": "paste_pose", "mirrored": True})
    np.testing.assert_allclose(
        shown_pose(back).pose.Rs_parent_part, shown_pose(desk()).pose.Rs_parent_part, atol=1e-9
    )


def test_the_first_body_stands_whole_before_the_camera() -> None:
    state = desk(keyframes=False)
    standing = shown_pose(state)
    assert standing.source == "rest"
    uv = state.doc.view.camera.project(standing.pose.p_camera_root)
    assert 0 <= uv[0] < state.doc.view.camera.width
    assert 0 <= uv[1] < state.doc.view.camera.height


def test_between_keyframes_the_pose_is_interpolated_and_outside_held() -> None:
    state = after(desk(), {"do": "delete_key", "frame": 0}, {"do": "delete_key", "frame": 72})
    assert shown_pose(state, 30).source == "between"
    assert shown_pose(state, 3).source == "held"
    assert shown_pose(state, 70).source == "held"
    first = shown_pose(state, 24).pose.p_camera_root
    np.testing.assert_allclose(shown_pose(state, 3).pose.p_camera_root, first)


ANY_EDIT = st.sampled_from([*EDITS, {"do": "undo"}, {"do": "redo"}, {"do": "go", "frame": 24}])


@settings(max_examples=30)  # of a dozen edits each, some of which take a tenth of a second
@given(st.lists(ANY_EDIT, max_size=12))
def test_undoing_everything_leads_back_to_the_beginning(edits: list[dict[str, Any]]) -> None:
    start = desk()
    state = start
    for edit in edits:
        try:
            state = after(state, edit)
        except KeyposeError:
            continue
    while state.history.past:
        state = after(state, {"do": "undo"})
    assert state.doc is start.doc


def test_a_keyframe_that_comes_to_a_drafted_frame_is_what_is_shown_there() -> None:
    drafted = after(desk(), {"do": "go", "frame": 12}, TURN)
    for do in ("move_key", "duplicate_key"):
        state = after(drafted, {"do": do, "frame": 24, "to": 12})
        assert state.doc.subject.drafts == ()
        assert shown_pose(state).source == "keyframe"


def test_a_draft_is_deleted_alone_and_what_stood_behind_it_is_shown_again() -> None:
    before = after(desk(), {"do": "go", "frame": 12})
    drafted = after(before, TURN)
    state = after(drafted, {"do": "delete_draft", "frame": 12})
    assert state.doc.subject.drafts == ()
    assert state.keys == before.keys
    assert shown_pose(state).source == shown_pose(before).source == "between"
    assert state.history.past[-1].label == "delete draft 12"
    assert after(state, {"do": "undo"}).doc is drafted.doc


def test_an_edit_at_a_frame_with_a_keyframe_and_a_draft_can_be_seen() -> None:
    start = desk()
    draft = start.doc.subject.keyframes[0]
    state = after(start.with_doc(start.doc.changed({"drafts": (draft,)})), TURN)
    np.testing.assert_allclose(angles(state, "left_forearm")[0], -40, atol=1e-6)


def test_a_body_of_other_parts_stands_though_nothing_is_posed_yet() -> None:
    start = desk(keyframes=False)
    parts = start.doc.subject.body.parts[:1]
    one = start.doc.subject.body.model_copy(update={"parts": parts, "mirror_pairs": ()})
    state = after(start.with_doc(start.doc.changed({"body": one})))
    assert len(shown_pose(state).pose.Rs_parent_part) == 1
    state = after(state, {"do": "preset", "name": "adult_male"}, {"do": "add_key", "frame": 0})
    assert len(shown_pose(state).pose.Rs_parent_part) == 16


def test_a_body_behind_the_camera_is_no_keyframe_for_no_file_could_hold_it() -> None:
    state = desk(keyframes=False)
    near = Pose(state.opening.Rs_parent_part, np.array([0.0, 0.0, 0.03]))
    with pytest.raises(ActionRefused, match="behind the camera"):
        after(replace(state, opening=near), {"do": "add_key", "frame": 0})


def test_undo_says_what_it_takes_back_as_a_person_would() -> None:
    handle = {"kind": "surface", "part": "head", "tool": "move"}
    way = {"view": "main", "from": [300, 200], "at": [320, 200]}
    moved = after(desk(), {"do": "drag", "handle": handle, **way})
    assert moved.history.past[-1].label == "move the body"
    assert after(desk(), {"do": "preset", "name": "adult_female"}).history.past[-1].label == (
        "change the body to adult female"
    )


def joints_at(state: EditorState, frame: int) -> dict[str, np.ndarray]:  # type: ignore[type-arg]
    """Where a keyframe's joints are, by name."""
    skeleton = Skeleton.of(state.doc.subject.body)
    keyframe = next(k for k in state.doc.subject.keyframes if k.frame == frame)
    places = joint_positions(skeleton, pose_transforms(skeleton, keyframe.pose(skeleton)))
    return dict(zip(joint_names(skeleton), places, strict=True))


def test_adding_clavicles_moves_no_joint_and_removing_them_turns_no_arm() -> None:
    before = desk()
    moving = after(before, {"do": "clavicles", "on": True})
    for name, place in joints_at(before, 24).items():
        np.testing.assert_allclose(joints_at(moving, 24)[name], place, atol=1e-9)
    shrug = [{"do": "go", "frame": 24}, {"do": "angles", "part": "left_clavicle", "z": -30}]
    shrugged = after(moving, *shrug)
    raised, was = joints_at(shrugged, 24), joints_at(moving, 24)
    assert np.linalg.norm(raised["left_upper_arm"] - was["left_upper_arm"]) > 0.05
    plain = after(shrugged, {"do": "clavicles", "on": False})
    assert plain.doc.subject.body == before.doc.subject.body
    left = joints_at(plain, 24)
    for one, other in (("left_upper_arm", "left_forearm"), ("left_forearm", "left_hand")):
        np.testing.assert_allclose(left[other] - left[one], raised[other] - raised[one], atol=1e-6)


def test_a_preset_keeps_the_clavicles_that_were_asked_for() -> None:
    state = after(desk(), {"do": "clavicles", "on": True}, {"do": "preset", "name": "elderly_male"})
    assert has_clavicles(state.doc.subject.body)
    assert without_clavicles(state.doc.subject.body) == preset("elderly_male")


def test_a_preset_without_arms_takes_no_clavicles() -> None:
    state = after(desk(), {"do": "clavicles", "on": True}, {"do": "preset", "name": "box"})
    assert state.doc.subject.body == preset("box")


def test_a_renamed_part_is_renamed_wherever_the_session_names_it() -> None:
    before = desk()
    state = after(before, {"do": "rename_part", "part": "left_forearm", "name": "arm"})
    for old, new in zip(before.doc.subject.keyframes, state.doc.subject.keyframes, strict=True):
        rotations = dict(old.rotations_wxyz)
        if "left_forearm" in rotations:
            rotations["arm"] = rotations.pop("left_forearm")
        assert new.rotations_wxyz == rotations
    assert "left_forearm" not in state.doc.model_dump_json()


def test_the_first_part_stays() -> None:
    with pytest.raises(ActionRefused, match="The first part carries all others"):
        after(desk(), {"do": "delete_part", "part": "waist"})


def test_a_body_without_arms_has_no_clavicles() -> None:
    state = desk()
    trunk = Body(name="trunk", parts=state.doc.subject.body.parts[:4])
    bare = replace(state, doc=with_body(state, trunk))
    with pytest.raises(ActionRefused, match="Clavicles need a chest with two upper arms"):
        after(bare, {"do": "clavicles", "on": True})
