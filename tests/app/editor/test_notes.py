"""Notes at frames are edits like others: kept sorted, bounded, undone."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from keypose.app.editor.actions import ACTIONS
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.state import EditorState
from keypose.tracker.session.annotations import LONGEST
from keypose.tracker.session.schema import MOST, Session
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
