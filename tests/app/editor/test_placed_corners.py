"""Corners of a box that were put in their places stay there, also through undo."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.app.editor.posing import corners_placed
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import with_size
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.geometry.rotations import Array, apply_transform, exp_rotation
from tests.app.editor.desk import after, desk


@pytest.fixture
def box() -> EditorState:
    """The sample's film with a box in the place of the person, at a frame without a keyframe."""
    return after(desk(keyframes=False), {"do": "preset", "name": "box"}, {"do": "go", "frame": 7})


def seen(state: EditorState) -> Array:
    """(8, 2) pixels of its corners."""
    corners = state.doc.subject.body.parts[0].shape.corners()
    assert corners is not None
    T = pose_transforms(state.skeleton, shown_pose(state).pose)[0]
    return state.doc.view.camera.without_distortion().project(apply_transform(T, corners))


def pulled(state: EditorState, index: int, way: tuple[float, float], stroke: str) -> EditorState:
    """A corner dragged, in two moves."""
    start = seen(state)[index]
    handle = {"kind": "box_corner", "part": "box", "index": index}
    common = {"do": "drag", "view": "main", "handle": handle, "from": start.tolist()}
    for share in (0.5, 1.0):
        at = (start + share * np.array(way)).tolist()
        state = after(state, {**common, "at": at, "stroke": stroke})
    return after(state, {"do": "end_stroke", "stroke": stroke})


def placed(state: EditorState) -> list[int]:
    return [one.index for one in corners_placed(state)]


def test_each_drag_is_a_step_of_its_own_and_undo_takes_its_corner_back(box: EditorState) -> None:
    one = pulled(box, 0, (9.0, 4.0), "a")
    two = pulled(one, 6, (-5.0, 3.0), "b")
    assert (placed(box), placed(one), placed(two)) == ([], [0], [0, 6])
    np.testing.assert_allclose(seen(two)[0], seen(one)[0], atol=0.1)
    back = after(two, {"do": "undo"})
    assert placed(back) == [0]
    np.testing.assert_allclose(seen(back), seen(one), atol=1e-6)
    assert placed(after(back, {"do": "undo"})) == []
    assert placed(after(back, {"do": "redo"})) == [0, 6]
    assert two.history.past[-1].label == "move a corner of box"


def test_a_cancelled_drag_places_nothing(box: EditorState) -> None:
    one = pulled(box, 0, (9.0, 4.0), "a")
    start = seen(one)[6].tolist()
    handle = {"kind": "box_corner", "part": "box", "index": 6}
    moved = {"do": "drag", "view": "main", "handle": handle, "from": start, "at": [0.0, 0.0]}
    under_way = after(one, {**moved, "stroke": "b"})
    assert placed(under_way) == [0, 6]
    assert placed(after(under_way, {"do": "cancel_stroke", "stroke": "b"})) == [0]


def test_they_are_those_of_their_frame(box: EditorState) -> None:
    one = pulled(box, 0, (9.0, 4.0), "a")
    elsewhere = after(one, {"do": "go", "frame": 20})
    assert placed(elsewhere) == []
    assert placed(after(elsewhere, {"do": "go", "frame": 7})) == [0]


def test_a_pose_changed_in_another_way_has_none(box: EditorState) -> None:
    one = pulled(box, 0, (9.0, 4.0), "a")
    assert placed(after(one, {"do": "angles", "part": "box", "x": 5.0})) == []


def test_a_keyframe_made_of_the_pose_keeps_them(box: EditorState) -> None:
    one = pulled(box, 0, (9.0, 4.0), "a")
    assert placed(after(one, {"do": "add_key", "frame": 7})) == [0]


def test_with_other_sizes_they_stay_where_they_were_put(box: EditorState) -> None:
    one = pulled(box, 0, (9.0, 4.0), "a")
    at = corners_placed(one)[0].uv
    wider = after(one, {"do": "size", "part": "box", "key": "width", "cm": 31.0})
    assert corners_placed(wider)[0].uv == at


def test_six_corners_change_sizes_only_while_no_other_frame_was_posed_with_them(
    box: EditorState,
) -> None:
    """Both in one step, which undo takes back."""
    there = shown_pose(box).pose
    turned = Pose(exp_rotation(np.array([[0.6, 0.5, 0.1]])), there.p_camera_root)
    wider = with_size(with_size(box.doc.subject.body, "box", "width", 45.0), "box", "depth", 20.0)
    T = pose_transforms(box.skeleton, turned)[0]
    corners = wider.parts[0].shape.corners()
    assert corners is not None
    goals = box.doc.view.camera.without_distortion().project(apply_transform(T, corners))
    elsewhere = after(box, {"do": "go", "frame": 20}, {"do": "add_key", "frame": 20})
    changed = []
    for state in (box, after(elsewhere, {"do": "go", "frame": 7})):
        for index in (0, 2, 4, 6, 3, 7):
            assert state.doc.subject.body == box.doc.subject.body
            state = pulled(state, index, tuple(goals[index] - seen(state)[index]), f"c{index}")
        changed.append(state.doc.subject.body != box.doc.subject.body)
        assert len(placed(state)) == 6
        assert after(state, {"do": "undo"}).doc.subject.body == box.doc.subject.body
    assert changed == [True, False]
