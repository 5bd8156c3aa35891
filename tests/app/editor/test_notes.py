"""Notes at frames and keypoints set right by hand are edits like others, and never the pose."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from keypose.app.editor.actions import ACTIONS
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.state import EditorState
from keypose.tracker.session.annotations import LONGEST, KeypointCorrection
from keypose.tracker.session.schema import MOST, Session
from tests.app import surface_cases
from tests.app.editor.desk import after, desk


def noted(state: EditorState) -> list[tuple[int, str]]:
    return [(note.frame, note.text) for note in state.doc.notes]


def a_note(frame: int, text: str = "") -> dict[str, object]:
    return {"do": "set_note", "frame": frame, "text": text}


def test_notes_stand_in_the_order_of_their_frames_one_a_frame() -> None:
    state = after(desk(), a_note(40, " elbow hidden "), a_note(12), a_note(40, "elbow back"))
    assert noted(state) == [(12, ""), (40, "elbow back")]
    assert state.history.past[-1].label == "write the note at 40"


def test_the_same_words_once_more_are_no_step() -> None:
    state = after(desk(), a_note(12, "look"))
    assert after(state, a_note(12, "look")) is state


def test_a_note_moves_and_goes_and_comes_back_by_undo() -> None:
    state = after(desk(), a_note(12, "one"), a_note(20, "two"))
    moved = after(state, {"do": "move_note", "frame": 12, "to": 30})
    assert noted(moved) == [(20, "two"), (30, "one")]
    with pytest.raises(ActionRefused, match="Frame 20 has a note already"):
        after(moved, {"do": "move_note", "frame": 30, "to": 20})
    gone = after(moved, {"do": "delete_note", "frame": 30})
    assert noted(gone) == [(20, "two")]
    assert noted(after(gone, {"do": "undo"}, {"do": "undo"})) == noted(state)
    with pytest.raises(ActionRefused, match="Frame 5 has no note"):
        after(gone, {"do": "delete_note", "frame": 5})


def test_a_note_is_within_the_video_and_not_endless() -> None:
    with pytest.raises(ActionRefused, match="frames 0 to"):
        after(desk(), a_note(100_000))
    with pytest.raises(ValidationError):
        ACTIONS.validate_python(a_note(3, "x" * (LONGEST + 1)))
    with pytest.raises(ValidationError):
        ACTIONS.validate_python(a_note(3, "\ud800"))
    full = [{"frame": frame} for frame in range(MOST["notes"] + 1)]
    with pytest.raises(ValidationError, match="more than the 1000"):
        Session.model_validate({**desk().doc.model_dump(), "notes": full})


@pytest.mark.parametrize(
    ("frames", "words"),
    [((3, 3), "two notes"), ((4, 3), "sort them by frame"), ((0, 9999), "beyond the video")],
)
def test_a_file_with_notes_that_do_not_fit_says_which(frames: list[int], words: str) -> None:
    notes = [{"frame": frame, "text": "a"} for frame in frames]
    with pytest.raises(ValidationError, match=words):
        Session.model_validate({**desk().doc.model_dump(), "notes": notes})


def test_notes_change_neither_old_files_nor_what_was_tracked() -> None:
    assert "notes" not in desk().doc.model_dump(mode="json")
    state = after(desk(), a_note(10, "x"))
    again = Session.model_validate_json(state.doc.model_dump_json())
    assert again.notes == state.doc.notes
    assert Session.model_json_schema()["properties"]["notes"]["description"]


WRIST = {"do": "correct_keypoint", "frame": 3, "joint": "left_wrist"}
STROKE = {"stroke": "ring-1"}


def person() -> EditorState:
    return after(desk(), {"do": "preset", "name": "adult_male"})


def corrections(state: EditorState) -> tuple[KeypointCorrection, ...]:
    return state.doc.view.keypoint_corrections


def test_dragging_a_keypoint_is_one_step_and_leaves_the_pose() -> None:
    before = person()
    moves = [{**WRIST, **STROKE, "at": [100 + n, 50.123]} for n in range(4)]
    moved = after(before, *moves, {"do": "end_stroke", "stroke": "ring-1"})
    assert corrections(moved) == (
        KeypointCorrection(frame=3, joint="left_wrist", uv=(103.0, 50.12)),
    )
    assert moved.doc.subject.keyframes == before.doc.subject.keyframes
    assert moved.doc.subject.drafts == before.doc.subject.drafts
    assert len(moved.history.past) == len(before.history.past) + 1
    assert moved.history.past[-1].label == "correct the keypoint left wrist"
    assert after(moved, {"do": "undo"}).doc == before.doc
    assert corrections(after(before, *moves, {"do": "cancel_stroke", "stroke": "ring-1"})) == ()


def test_a_keypoint_is_ignored_and_put_back() -> None:
    hidden = after(person(), {**WRIST, "do": "ignore_keypoint"})
    assert corrections(hidden) == (KeypointCorrection(frame=3, joint="left_wrist"),)
    back = after(hidden, {**WRIST, "do": "restore_keypoint"})
    assert back.doc == person().doc
    assert [step.label for step in back.history.past[-2:]] == [
        "ignore the keypoint left wrist", "put back the keypoint left wrist",
    ]  # fmt: skip


def test_there_is_one_correction_of_each_and_they_are_in_order() -> None:
    first = {**WRIST, "frame": 1, "at": [7, 7]}
    state = after(person(), {**WRIST, "at": [9, 9]}, first, {**WRIST, "at": [8, 8]})
    assert [(each.frame, each.uv) for each in corrections(state)] == [
        (1, (7.0, 7.0)),
        (3, (8.0, 8.0)),
    ]


def test_of_a_bent_lens_it_is_kept_where_the_film_shows_it() -> None:
    bent = after(person(), {"do": "distortion", "k1": -0.2, "k2": 0.02})
    state = after(bent, {**WRIST, "at": [20, 30]})
    camera = state.doc.view.camera
    (uv,) = [each.uv for each in corrections(state)]
    assert np.linalg.norm(np.subtract(uv, (20, 30))) > 1
    shown = camera.without_distortion().project(camera.back_project(np.array(uv), 1.0))
    np.testing.assert_allclose(shown, (20, 30), atol=0.02)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"joint": "left_toe"}, "This body has no keypoint left toe."),
        ({"frame": 10_000}, "The video has frames 0 to 72"),
        ({"at": [99_999, 3]}, "far outside the picture"),
    ],
)
def test_what_cannot_be_a_keypoint_is_refused(wrong: dict[str, object], words: str) -> None:
    with pytest.raises(ActionRefused, match=words):
        after(person(), {**WRIST, "at": [9, 9], **wrong})


def test_surfaces_have_no_keypoints() -> None:
    with pytest.raises(ActionRefused, match="in a video"):
        after(person().with_doc(surface_cases.session()), {**WRIST, "at": [9, 9]})
