"""The trail goes through the poses that are shown, from one keyframe to the next."""

from __future__ import annotations

import numpy as np

from keypose.app.editor.motion import end_trail
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.tracker.body.pose import joint_names, joint_positions, pose_transforms
from keypose.tracker.geometry.rotations import Array
from tests.app.editor.desk import after, desk
from tests.app.editor.test_next_key import tracked_desk


def joint(state: EditorState, frame: int, name: str) -> Array:
    Ts = pose_transforms(state.skeleton, shown_pose(state, frame).pose)
    return joint_positions(state.skeleton, Ts)[joint_names(state.skeleton).index(name)]


def test_it_is_where_the_part_ends_in_every_shown_pose() -> None:
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


def test_at_a_keyframe_it_reaches_to_both_neighbours() -> None:
    found = end_trail(after(desk(), {"do": "go", "frame": 24}))
    assert found is not None
    assert (found.frames[0], found.frames[-1], found.keys) == (0, 48, (0, 24, 48))


def test_far_from_its_keyframes_it_is_cut() -> None:
    state = after(desk(), *({"do": "delete_key", "frame": f} for f in (24, 48)))
    found = end_trail(after(state, {"do": "go", "frame": 36}))
    assert found is not None
    assert (found.frames[0], found.frames[-1]) == (6, 66)


def test_outside_the_keyframes_there_is_none() -> None:
    state = after(desk(), {"do": "delete_key", "frame": 0}, {"do": "go", "frame": 3})
    assert end_trail(state) is None
    assert end_trail(desk(keyframes=False)) is None


def test_a_gesture_under_way_leaves_it_as_it_was_tracked() -> None:
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


def test_it_is_tracked_again_when_the_gesture_that_selected_the_part_is_cancelled() -> None:
    state = after(tracked_desk(), {"do": "go", "frame": 24})
    turn = {"do": "angles", "part": "left_forearm", "x": -70, "stroke": "s"}
    during = after(state, turn, {"do": "select", "part": "left_forearm"})
    before = after(state, {"do": "select", "part": "left_forearm"})
    shown, expected = end_trail(during), end_trail(before)
    assert shown is not None
    assert expected is not None
    np.testing.assert_array_equal(shown.p_camera, expected.p_camera)
