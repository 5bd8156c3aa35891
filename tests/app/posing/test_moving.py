"""The whole body carried along the picture, in depth, or along one axis."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from keypose.app.posing import drag, handle_named
from keypose.tracker.geometry.camera import Camera
from tests.app.posing.posing_cases import (
    CAMERA,
    PERSON,
    TELEPHOTO,
    VIEWS,
    difference,
    gesture,
    pull,
    sights,
    walking,
)

ROOT = handle_named(PERSON, "root")
ways = st.tuples(st.floats(-1, 1), st.floats(-1, 1))
cameras = pytest.mark.parametrize("camera", [CAMERA, TELEPHOTO], ids=["perspective", "telephoto"])


@cameras
@pytest.mark.parametrize("view", VIEWS)
@given(way=ways)
def test_the_root_follows_the_pointer_and_keeps_its_depth_in_the_view(
    view: str, camera: Camera, way: tuple[float, float]
) -> None:
    pose = walking()
    posed, end, seen = pull(PERSON, pose, ROOT, view, way, camera=camera)
    np.testing.assert_allclose(seen, end, atol=1e-6)
    away = sights(camera)[view].away
    moved = posed.pose.p_camera_root - pose.p_camera_root
    assert moved @ away == pytest.approx(0, abs=1e-12)
    np.testing.assert_array_equal(posed.pose.Rs_parent_part, pose.Rs_parent_part)
    if view in ("top", "side", "front"):
        assert np.linalg.norm(moved) == pytest.approx(np.hypot(*way))


@cameras
def test_a_grab_beside_the_diamond_moves_nothing(camera: Camera) -> None:
    pose = walking()
    for view, sight in sights(camera).items():
        beside = sight.project(pose.p_camera_root) + 0.01
        sent = gesture(view, {"kind": "root"}, beside, beside)
        assert difference(drag(PERSON, pose, sent, sights(camera)).pose, pose) < 1e-12


@given(st.floats(-2, 2))
def test_depth_goes_up_for_farther_and_keeps_the_root_where_it_is_seen(up: float) -> None:
    pose = walking()
    posed, _, seen = pull(PERSON, pose, ROOT, "main", (0.4, -up), depth=True)
    np.testing.assert_allclose(seen, sights()["main"].project(pose.p_camera_root), atol=1e-9)
    way = posed.pose.p_camera_root - pose.p_camera_root
    assert way[2] * up >= 0


def test_equal_ways_of_the_pointer_change_the_bodys_size_in_the_picture_by_equal_ratios() -> None:
    depths = [
        pull(PERSON, walking(), ROOT, "main", (0.0, -up), depth=True)[0].pose.p_camera_root[2]
        for up in (0.0, 0.5, 1.0, 1.5)
    ]
    ratios = np.divide(depths[1:], depths[:-1])
    np.testing.assert_allclose(ratios, ratios[0], atol=1e-9)
    assert 1.2 < ratios[0] < 3


def test_nothing_is_dragged_behind_the_camera() -> None:
    for more in ({"depth": True}, {"axis": "z"}):
        posed, _, _ = pull(PERSON, walking(), ROOT, "main", (0.0, 300.0), **more)
        assert posed.pose.p_camera_root[2] >= 0.3 - 1e-9
    posed, _, _ = pull(PERSON, walking(), ROOT, "top", (0.0, 300.0))
    assert posed.pose.p_camera_root[2] >= 0.3 - 1e-9


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_held_to_one_axis_the_root_moves_along_it_to_the_pointer(view: str, axis: str) -> None:
    pose, k = walking(), "xyz".index(axis)
    others = [i for i in range(3) if i != k]
    posed, end, seen = pull(PERSON, pose, ROOT, view, (0.2, -0.15), axis=axis)
    way = posed.pose.p_camera_root - pose.p_camera_root
    np.testing.assert_allclose(way[others], 0, atol=1e-12)
    assert way[k] != 0
    sight = sights()[view]
    if abs(sight.away[k]) < 0.9:  # the pointer lies straight beside the place on the axis
        shown = sight.slope(posed.pose.p_camera_root)[:, k]
        assert abs((end - seen) @ shown) < 0.02 * np.linalg.norm(end - seen) * np.linalg.norm(shown)


@given(ways)
def test_snapping_takes_steps_of_a_centimetre(way: tuple[float, float]) -> None:
    pose = walking()
    for view in VIEWS:
        posed, _, _ = pull(PERSON, pose, ROOT, view, way, snap=True)
        moved = 100 * sights()[view].R_view_camera @ (posed.pose.p_camera_root - pose.p_camera_root)
        if view == "main":  # rows of pixels that are not square are not whole centimetres apart
            moved[1] *= CAMERA.fy / CAMERA.fx
        np.testing.assert_allclose(moved, np.round(moved), atol=1e-6)


def test_the_readout_says_how_deep_the_body_stands_and_how_far_it_went() -> None:
    kept = pull(PERSON, walking(), ROOT, "main", (0.3, 0.4))[0].readout
    assert (kept.label, kept.value, kept.depth_m) == ("Body", "depth kept 5.00 m", 5.0)
    assert kept.change.endswith(" cm")
    nearer = pull(PERSON, walking(), ROOT, "main", (0.0, 0.5), depth=True, snap=True)[0].readout
    assert nearer.depth_m is not None
    assert nearer.value == f"depth {nearer.depth_m:.2f} m"
    assert nearer.change.startswith("−")
