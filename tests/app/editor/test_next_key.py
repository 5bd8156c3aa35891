"""Where tracking has been, editing begins with what it found."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.app.editor.documents import with_drafts
from keypose.app.editor.motion import angle_curve
from keypose.app.editor.shown import find, shown_pose
from keypose.app.editor.state import EditorState
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import Pass, Trajectory, interpolate
from keypose.tracker.storage.results import Results, segment_keys
from keypose.tracker.tracking.result import SegmentResult
from tests.app.editor.desk import after, angles, desk

MIDDLE = 12


def tracked_desk() -> EditorState:
    """The sample with 0–24 tracked: 10 cm to the side of where interpolation has the body."""
    state = desk()
    start, end = (find(state.doc.subject.keyframes, f).pose(state.skeleton) for f in (0, 24))  # type: ignore[union-attr]
    path = interpolate(start, end, 0, 24)
    moved = Trajectory(0, path.Rs_parent_part, path.ps_camera_root + np.array([0.1, 0, 0]))
    key = segment_keys(state.doc)[0, 24]
    results = Results().with_result(SegmentResult.on_the_way(Pass("pass", moved, 1.0), key))
    return after(state.with_results(results), {"do": "go", "frame": MIDDLE})


def tracked_pose(state: EditorState) -> Pose:
    found = state.tracked(MIDDLE)
    assert found is not None
    return found


def test_at_a_frame_without_a_pose_of_its_own_the_tracked_one_stands() -> None:
    state = tracked_desk()
    assert shown_pose(state).source == "tracked"
    assert (
        shown_pose(state).pose.p_camera_root.tolist() == tracked_pose(state).p_camera_root.tolist()
    )


def test_an_edit_there_begins_with_the_tracked_pose() -> None:
    state = tracked_desk()
    turned = after(state, {"do": "angles", "part": "left_forearm", "x": -50})
    assert shown_pose(turned).source == "draft"
    np.testing.assert_allclose(angles(turned, "left_forearm")[0], -50)
    others = [name for name in state.doc.subject.body.names if name != "left_forearm"]
    for name in others:
        np.testing.assert_allclose(angles(turned, name), angles(state, name), atol=1e-3)
    np.testing.assert_allclose(
        shown_pose(turned).pose.p_camera_root, tracked_pose(state).p_camera_root, atol=1e-9
    )


def test_a_drag_of_the_body_there_begins_with_the_tracked_pose() -> None:
    state = tracked_desk()
    before = tracked_pose(state).p_camera_root
    grip = {"do": "drag", "view": "main", "handle": {"kind": "root"}, "stroke": "d"}
    held = after(state, {**grip, "from": [300, 200], "at": [310, 200]})
    x, y, z = shown_pose(held).pose.p_camera_root - before
    assert x > 0.01
    np.testing.assert_allclose([y, z], 0, atol=1e-6)


def test_k_keeps_the_tracked_pose() -> None:
    state = tracked_desk()
    kept = after(state, {"do": "add_key", "frame": MIDDLE})
    assert shown_pose(kept).source == "keyframe"
    np.testing.assert_allclose(
        shown_pose(kept).pose.p_camera_root, tracked_pose(state).p_camera_root, atol=1e-9
    )


def found_in_the_film(posed: EditorState, found_by: str = "drafted") -> EditorState:
    """Its only draft as one that no person posed."""
    (draft,) = posed.doc.subject.drafts
    return posed.with_doc(with_drafts(posed.doc, [draft.model_copy(update={found_by: True})]))


@pytest.mark.parametrize("found_by", ["drafted", "followed"])
def test_what_was_found_in_the_film_gives_way_to_what_is_tracked_later(found_by: str) -> None:
    state = tracked_desk()
    posed = after(state, {"do": "angles", "part": "left_forearm", "x": -50})
    found = found_in_the_film(posed, found_by)
    assert shown_pose(posed).source == "draft"
    assert shown_pose(found).source == "tracked"
    untracked = found.with_results(Results())
    assert shown_pose(untracked).source == "draft"
    corrected = after(untracked, {"do": "angles", "part": "left_forearm", "x": -40})
    assert shown_pose(corrected.with_results(found.results)).source == "draft"


def test_the_curve_of_angles_shows_the_pose_that_is_shown() -> None:
    state = tracked_desk()
    forearm = state.doc.subject.body.index("left_forearm")
    posed = after(state, {"do": "angles", "part": "left_forearm", "x": -50})
    np.testing.assert_allclose(angle_curve(posed, forearm)[MIDDLE], angles(posed, "left_forearm"))
    found = found_in_the_film(posed)
    tracked = angles(found, "left_forearm")
    assert abs(tracked[0] + 50) > 1
    np.testing.assert_allclose(angle_curve(found, forearm)[MIDDLE], tracked, atol=1e-3)
    untracked = found.with_results(Results())
    np.testing.assert_allclose(angle_curve(untracked, forearm)[MIDDLE][0], -50, atol=1e-3)


LEANING = {0: 0.0, 24: -60.0, 48: -120.0}
"""Degrees at keyframes, about x and about z."""


def test_a_key_dragged_on_the_curve_of_a_body_in_profile_leaves_its_other_angles() -> None:
    turns = [
        {"do": "key_angle", "frame": frame, "part": "waist", "axis": axis, "deg": deg}
        for frame, lean in LEANING.items()
        for axis, deg in (("x", lean), ("y", 84.0), ("z", lean))
    ]
    edit = after(desk(), *turns)
    np.testing.assert_allclose(angle_curve(edit, 0)[list(LEANING)], [
        [lean, 84.0, lean] for lean in LEANING.values()
    ], atol=1e-6)  # fmt: skip
    edit = after(edit, {"do": "key_angle", "frame": 48, "part": "waist", "axis": "x", "deg": -121})
    np.testing.assert_allclose(angle_curve(edit, 0)[48], [-121, 84, -120], atol=1e-6)
