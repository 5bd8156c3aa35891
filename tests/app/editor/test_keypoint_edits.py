"""Keypoints corrected by hand: one step of undo, and never the pose."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.state import EditorState
from keypose.tracker.session.annotations import KeypointCorrection
from tests.app import surface_cases
from tests.app.editor.desk import after, desk

WRIST = {"do": "correct_keypoint", "frame": 3, "joint": "left_wrist"}
STROKE = {"stroke": "ring-1"}


def person() -> EditorState:
    return after(desk(), {"do": "preset", "name": "adult_male"})


def message(state: EditorState) -> tuple[KeypointCorrection, ...]:
    return state.doc.keypoint_corrections


def test_dragging_a_keypoint_is_one_step_and_leaves_the_pose() -> None:
    before = person()
    moves = [{**WRIST, **STROKE, "at": [100 + n, 50.123]} for n in range(4)]
    moved = after(before, *moves, {"do": "end_stroke", "stroke": "ring-1"})
    assert message(moved) == (KeypointCorrection(frame=3, joint="left_wrist", uv=(103.0, 50.12)),)
    assert moved.doc.keyframes == before.doc.keyframes
    assert moved.doc.drafts == before.doc.drafts
    assert len(moved.history.past) == len(before.history.past) + 1
    assert moved.history.past[-1].label == "correct the keypoint left wrist"
    assert after(moved, {"do": "undo"}).doc == before.doc
    assert message(after(before, *moves, {"do": "cancel_stroke", "stroke": "ring-1"})) == ()


def test_a_keypoint_is_ignored_and_put_back() -> None:
    hidden = after(person(), {**WRIST, "do": "ignore_keypoint"})
    assert message(hidden) == (KeypointCorrection(frame=3, joint="left_wrist"),)
    back = after(hidden, {**WRIST, "do": "restore_keypoint"})
    assert back.doc == person().doc
    assert [step.label for step in back.history.past[-2:]] == [
        "ignore the keypoint left wrist", "put back the keypoint left wrist",
    ]  # fmt: skip


def test_there_is_one_correction_of_each_and_they_are_in_order() -> None:
    first = {**WRIST, "frame": 1, "at": [7, 7]}
    state = after(person(), {**WRIST, "at": [9, 9]}, first, {**WRIST, "at": [8, 8]})
    assert [(each.frame, each.uv) for each in message(state)] == [(1, (7.0, 7.0)), (3, (8.0, 8.0))]


def test_of_a_bent_lens_it_is_kept_where_the_film_shows_it() -> None:
    bent = after(person(), {"do": "distortion", "k1": -0.2, "k2": 0.02})
    state = after(bent, {**WRIST, "at": [20, 30]})
    camera = state.doc.camera
    (uv,) = [each.uv for each in message(state)]
    assert np.linalg.norm(np.subtract(uv, (20, 30))) > 1
    shown = camera.without_distortion().project(camera.back_project(np.array(uv), 1.0))
    np.testing.assert_allclose(shown, (20, 30), atol=0.02)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"joint": "left_toe"}, "This body has no keypoint left toe."),
        ({"frame": 10_000}, "beyond the video"),
        ({"at": [99_999, 3]}, "far outside the picture"),
    ],
)
def test_what_cannot_be_a_keypoint_is_refused(wrong: dict[str, object], words: str) -> None:
    with pytest.raises(ActionRefused, match=words):
        after(person(), {**WRIST, "at": [9, 9], **wrong})


def test_surfaces_have_no_keypoints() -> None:
    with pytest.raises(ActionRefused, match="in a video"):
        after(person().with_doc(surface_cases.session()), {**WRIST, "at": [9, 9]})
