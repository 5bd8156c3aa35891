"""The trail of a part through the poses that are shown, and the ways of the feet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.app.editor.motion import end_trail, feet_paths
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.state.app_state import AppState
from keypose.app.store.sections import Sections
from keypose.tracker.body.body import load_body
from keypose.tracker.body.pose import joint_names, joint_positions, pose_transforms
from keypose.tracker.geometry.rotations import Array, apply_transform
from tests.app.editor.desk import after, desk
from tests.app.editor.test_next_key import tracked_desk
from tests.app.posing.posing_cases import SAMPLES
from tests.app.store.test_sections import seen


def joint(state: EditorState, frame: int, name: str) -> Array:
    Ts = pose_transforms(state.skeleton, shown_pose(state, frame).pose)
    return joint_positions(state.skeleton, Ts)[joint_names(state.skeleton).index(name)]


def test_the_trail_is_where_the_part_ends_in_every_shown_pose() -> None:
    state = after(
        desk(),
        {"do": "select", "part": "left_forearm"},
        {"do": "go", "frame": 7},
        {"do": "angles", "part": "left_forearm", "x": -70},
        {"do": "go", "frame": 12},
    )
    found = end_trail(state)
    assert found is not None
    assert found.frames == tuple(range(25))
    assert found.keys == (0, 24)
    expected = [joint(state, frame, "left_hand") for frame in found.frames]
    np.testing.assert_allclose(found.p_camera, expected, atol=1e-9)


def test_at_a_keyframe_the_trail_reaches_to_both_neighbours() -> None:
    found = end_trail(after(desk(), {"do": "go", "frame": 24}))
    assert found is not None
    assert (found.frames[0], found.frames[-1], found.keys) == (0, 48, (0, 24, 48))


def test_far_from_its_keyframes_the_trail_is_cut() -> None:
    state = after(desk(), *({"do": "delete_key", "frame": f} for f in (24, 48)))
    found = end_trail(after(state, {"do": "go", "frame": 36}))
    assert found is not None
    assert (found.frames[0], found.frames[-1]) == (6, 66)


def test_outside_the_keyframes_there_is_no_trail() -> None:
    state = after(desk(), {"do": "delete_key", "frame": 0}, {"do": "go", "frame": 3})
    assert end_trail(state) is None
    assert end_trail(desk(keyframes=False)) is None


def test_a_gesture_under_way_leaves_the_trail_as_it_was_tracked() -> None:
    before = after(tracked_desk(), {"do": "go", "frame": 24}, {"do": "select", "part": "chest"})
    tracked = end_trail(before)
    turn = {"do": "angles", "part": "left_forearm", "x": -70, "stroke": "s"}
    during = end_trail(after(before, turn))
    assert tracked is not None
    assert during is not None
    np.testing.assert_array_equal(during.p_camera, tracked.p_camera)
    ended = end_trail(after(before, turn, {"do": "end_stroke", "stroke": "s"}))
    assert ended is not None
    assert np.abs(ended.p_camera - tracked.p_camera).max() > 0.05  # it is not tracked any more


def test_the_trail_is_tracked_again_when_the_gesture_that_selected_the_part_is_cancelled() -> None:
    state = after(tracked_desk(), {"do": "go", "frame": 24})
    turn = {"do": "angles", "part": "left_forearm", "x": -70, "stroke": "s"}
    during = after(state, turn, {"do": "select", "part": "left_forearm"})
    before = after(state, {"do": "select", "part": "left_forearm"})
    shown, expected = end_trail(during), end_trail(before)
    assert shown is not None
    assert expected is not None
    np.testing.assert_array_equal(shown.p_camera, expected.p_camera)


def test_both_feet_are_followed_over_all_segments_tracked_or_not() -> None:
    found = feet_paths(seen().edit)  # type: ignore[arg-type]
    assert list(found.paths) == ["left_foot", "right_foot"]
    assert found.frames.tolist() == list(range(73))
    for path in found.paths.values():
        assert path.shape == (73, 3)
        assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() < 0.2


def test_the_floor_lies_under_the_soles_and_where_it_is_set() -> None:
    found = feet_paths(desk())
    lowest = min(-path[:, 1].max() for path in found.paths.values())
    assert found.floor_m == pytest.approx(lowest, abs=0.06)
    state = desk()
    doc = state.doc.changed({"floor_m": -2.5})
    assert feet_paths(state.with_doc(doc)).floor_m == -2.5


def test_without_a_keyframe_there_is_a_floor_and_no_way() -> None:
    found = feet_paths(desk(keyframes=False))
    assert found.paths == {}
    assert -1.5 < found.floor_m < -0.3


def test_a_body_without_feet_is_followed_by_the_ends_of_its_limbs() -> None:
    arms = load_body(SAMPLES / "bodies" / "three_arms.json")
    doc = desk().doc.changed({"body": arms, "keyframes": ()})
    posed = after(
        replace(desk(keyframes=False)).with_doc(doc),
        {"do": "root", "x": 0.1},
        {"do": "add_key", "frame": 0},
    )
    found = feet_paths(posed)
    assert 1 <= len(found.paths) <= 4
    assert found.frames.tolist() == [0]


def test_a_long_film_is_reported_in_a_thousand_moments_with_every_keyframe() -> None:
    state = desk()
    last = state.doc.subject.keyframes[-1].model_copy(update={"frame": 7201, "time_s": 240.0})
    video = state.doc.view.video.model_copy(update={"frame_count": 9000})
    doc = state.doc.changed({"keyframes": (*state.doc.subject.keyframes, last), "video": video})
    frames = feet_paths(state.with_doc(doc)).frames
    assert len(frames) < 1100
    assert {0, 24, 48, 72, 7201} <= set(frames.tolist())


def test_the_page_receives_neighbouring_keyframes_and_of_the_solids() -> None:
    edit = after(desk(), {"do": "display", "ghosts": True}, {"do": "go", "frame": 30})
    reported = Sections().changed(AppState(edit=edit))
    assert [ghost["frame"] for ghost in reported["ghosts"]] == [24, 48]
    assert reported["ghosts"][0]["T"].keys() == reported["solids"].keys()
    T = np.reshape(reported["ghosts"][0]["T"]["left_foot"], (3, 4))
    p = apply_transform(
        np.vstack([T, [0, 0, 0, 1]]), np.array(reported["solids"]["left_foot"]["points"])
    )
    assert -p[:, 1].max() == pytest.approx(reported["feet"]["floor_m"], abs=0.2)
    assert Sections().changed(AppState(edit=desk()))["ghosts"] == []
