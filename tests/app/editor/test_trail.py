"""The trail goes through the poses that are shown, from one keyframe to the next."""

from __future__ import annotations

import numpy as np

from app.editor.shown import shown
from app.editor.state import EditorState
from app.editor.trail import way
from tests.app.editor.desk import after, desk
from tracker.body.pose import joint_names, joint_positions, pose_transforms
from tracker.geometry.rotations import Array


def joint(state: EditorState, frame: int, name: str) -> Array:
    Ts = pose_transforms(state.skeleton, shown(state, frame).pose)
    return joint_positions(state.skeleton, Ts)[joint_names(state.skeleton).index(name)]


def test_it_is_where_the_part_ends_in_every_shown_pose() -> None:
    state = after(
        desk(),
        {"do": "select", "part": "left_forearm"},
        {"do": "go", "frame": 7},
        {"do": "angles", "part": "left_forearm", "x": -70},
        {"do": "go", "frame": 12},
    )
    found = way(state)
    assert found is not None
    assert found.frames == tuple(range(25))
    assert found.keys == (0, 24)
    expected = [joint(state, frame, "left_hand") for frame in found.frames]
    np.testing.assert_allclose(found.p_camera, expected, atol=1e-9)


def test_at_a_keyframe_it_reaches_to_both_neighbours() -> None:
    found = way(after(desk(), {"do": "go", "frame": 24}))
    assert found is not None
    assert (found.frames[0], found.frames[-1], found.keys) == (0, 48, (0, 24, 48))


def test_far_from_its_keyframes_it_is_cut() -> None:
    state = after(desk(), *({"do": "delete_key", "frame": f} for f in (24, 48)))
    found = way(after(state, {"do": "go", "frame": 36}))
    assert found is not None
    assert (found.frames[0], found.frames[-1]) == (6, 66)


def test_outside_the_keyframes_there_is_none() -> None:
    state = after(desk(), {"do": "delete_key", "frame": 0}, {"do": "go", "frame": 3})
    assert way(state) is None
    assert way(desk(keyframes=False)) is None
