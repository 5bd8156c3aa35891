"""From the state to what the views show: which keyframes are ghosts, where the trail is now."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.scene.scene import Trail
from keypose.app.scene.scenery import SceneryMaker
from keypose.tracker.body.pose import pose_transforms
from tests.app.editor.desk import after, desk

POINTS = [[frame, 0.1 * frame, 0.0, 4.0] for frame in range(10, 21)]
TRAIL = {"part": "head", "points": POINTS, "keys": [10, 20]}
"""The section of the page: frames and places."""


def trail_at(frame: int, reported: Any = TRAIL) -> Trail | None:
    return SceneryMaker().of(after(desk(), {"do": "go", "frame": frame}), reported).trail


@pytest.mark.parametrize("frame", [10, 11, 14, 19, 20])
def test_the_present_point_of_the_trail_is_where_the_part_is_at_this_frame(frame: int) -> None:
    trail = trail_at(frame)
    assert trail is not None
    assert trail.present == frame - 10
    np.testing.assert_allclose(trail.p_camera[trail.present], [0.1 * frame, 0.0, 4.0])
    assert trail.p_camera.shape == (11, 3)


@pytest.mark.parametrize(("frame", "nearest"), [(3, 0), (40, 2), (13, 1), (18, 2)])
def test_where_the_trail_has_no_point_for_this_frame_the_nearest_is_the_present_one(
    frame: int, nearest: int
) -> None:
    sparse = {**TRAIL, "points": [POINTS[0], POINTS[4], POINTS[9]]}  # 10, 14, 19
    trail = trail_at(frame, sparse)
    assert trail is not None
    assert trail.present == nearest


def test_without_a_trail_there_is_none() -> None:
    assert trail_at(12, None) is None


def test_the_trail_moves_with_the_frame_though_its_points_stay() -> None:
    maker = SceneryMaker()
    at_12 = maker.of(after(desk(), {"do": "go", "frame": 12}), TRAIL).trail
    at_13 = maker.of(after(desk(), {"do": "go", "frame": 13}), TRAIL).trail
    again = maker.of(after(desk(), {"do": "go", "frame": 13}), TRAIL).trail
    assert at_12 is not None
    assert at_13 is not None
    assert (at_12.present, at_13.present) == (2, 3)
    assert again is at_13


def ghosted(frame: int) -> EditorState:
    return after(desk(), {"do": "display", "ghosts": True}, {"do": "go", "frame": frame})


@pytest.mark.parametrize(
    ("frame", "around"),
    [(0, [24]), (10, [0, 24]), (24, [0, 48]), (30, [24, 48]), (72, [48])],
)
def test_ghosts_are_the_keyframes_before_and_after_the_present_frame(
    frame: int, around: list[int]
) -> None:
    state = ghosted(frame)
    ghosts = SceneryMaker().of(state).ghosts
    assert [ghost for ghost, _ in ghosts] == around
    for ghost, Ts in ghosts:
        pose = shown_pose(state, ghost).pose
        np.testing.assert_allclose(Ts, pose_transforms(state.skeleton, pose), atol=1e-12)


def test_there_are_no_ghosts_unless_they_are_wanted() -> None:
    assert SceneryMaker().of(desk()).ghosts == ()


def test_what_is_shown_follows_the_frame_the_selection_and_the_looks() -> None:
    maker = SceneryMaker()
    before = maker.of(desk())
    state = after(
        desk(),
        {"do": "go", "frame": 30},
        {"do": "select", "part": "head"},
        {"do": "display", "mode": "wire", "opacity": 0.2},
    )
    scenery = maker.of(state)
    expected = pose_transforms(state.skeleton, shown_pose(state).pose)
    np.testing.assert_allclose(scenery.Ts_camera_part, expected)
    assert not np.allclose(scenery.Ts_camera_part, before.Ts_camera_part)
    assert (before.selected, scenery.selected) == (frozenset(), frozenset({"head"}))
    assert (scenery.mode, scenery.opacity, scenery.body) == ("wire", 0.2, state.doc.subject.body)
    assert scenery.Rs_view_camera is before.Rs_view_camera


def test_only_a_camera_of_one_distance_is_shown_as_telephoto() -> None:
    state = desk()
    assert not SceneryMaker().of(state).telephoto
    camera = state.doc.view.camera.model_copy(
        update={"projection": "telephoto", "telephoto_distance_m": 5.0}
    )
    far = state.with_doc(state.doc.changed({"camera": camera}))
    assert SceneryMaker().of(far).telephoto
