"""Posing and picking in the free view, whose eye stands anywhere."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from keypose.app.editor.frames import pointer_views
from keypose.app.posing import (
    Eye,
    Gesture,
    PointerView,
    drag,
    eye_rotation,
    outline,
    parts_at,
    view_rotations,
)
from keypose.tracker.body.skeleton import Skeleton
from tests.app.editor.desk import desk
from tests.app.posing.posing_cases import CAMERA, PERSON, points, sights, walking

TARGET = np.array([0.1, 0.0, 5.0])


def free(azimuth: float, elevation: float, distance: float = 4.0) -> PointerView:
    R = eye_rotation(azimuth, elevation) @ view_rotations()["front"]
    return PointerView.free(R, TARGET - distance * R[2])


numbers = st.floats(-1, 1)


@given(azimuth=st.floats(-180, 180), elevation=st.floats(2, 88), x=numbers, y=numbers, z=numbers)
def test_rays_slopes_and_depths_belong_together(
    azimuth: float, elevation: float, x: float, y: float, z: float
) -> None:
    view, p = free(azimuth, elevation), TARGET + np.array([x, y, z])
    origin, direction = view.ray(view.project(p))
    off = (p - origin) - ((p - origin) @ direction) * direction
    np.testing.assert_allclose(off, 0, atol=1e-9)
    np.testing.assert_allclose(view.ray_through(p), direction, atol=1e-9)
    np.testing.assert_allclose(view.at_depth(view.project(p), p), p, atol=1e-9)
    ways = 1e-6 * np.eye(3)
    measured = (view.project(p + ways) - view.project(p - ways)).T / 2e-6
    np.testing.assert_allclose(view.slope(p), measured, atol=1e-3)
    assert view.depth(p) == pytest.approx((p - origin) @ view.away)


def test_from_where_the_camera_stands_it_sees_as_the_camera() -> None:
    eye = PointerView.free(np.eye(3), np.zeros(3))
    p = np.array([0.3, -0.2, 4.0])
    seen = (sights(CAMERA)["main"].project(p) - (CAMERA.cx, CAMERA.cy)) / (CAMERA.fx, CAMERA.fy)
    np.testing.assert_allclose(eye.project(p) / 1000, seen)


@pytest.mark.parametrize("azimuth", [0, 70, 160, -100])
def test_a_part_is_picked_where_it_is_seen(azimuth: float) -> None:
    view, skeleton = free(azimuth, 15), Skeleton.of(PERSON)
    chest = points(PERSON, walking())["chest"]
    found = parts_at(skeleton, walking(), view, view.project(chest))
    assert "chest" in found or "waist" in found
    edge = outline(skeleton, walking(), view, "chest")
    assert (edge.min(axis=0) < view.project(chest) + 60).all()
    assert parts_at(skeleton, walking(), view, (5000.0, 5000.0)) == ()


@pytest.mark.parametrize("azimuth", [0, 60, 110, -140])
def test_a_hand_comes_under_the_pointer_from_wherever_one_looks(azimuth: float) -> None:
    view = free(azimuth, 25)
    views = {**sights(), "free": view}
    before = points(PERSON, walking())["left_hand"]
    start = view.project(before)
    end = start + np.array([12.0, -9.0])
    eye = Eye(azimuth_deg=azimuth, elevation_deg=25, at_m=tuple(view.p_camera_eye.tolist()))
    gesture = Gesture.model_validate(
        {
            "view": "free",
            "eye": eye,
            "handle": {"kind": "end", "name": "left_hand"},
            "from": tuple(start.tolist()),
            "at": tuple(end.tolist()),
        }
    )
    after = drag(PERSON, walking(), gesture, views).pose
    np.testing.assert_allclose(view.project(points(PERSON, after)["left_hand"]), end, atol=0.5)


def test_the_body_is_carried_across_the_line_of_sight() -> None:
    view = free(90, 2)
    before = walking().p_camera_root
    gesture = Gesture.model_validate(
        {
            "view": "free",
            "eye": {"azimuth_deg": 90, "elevation_deg": 2, "at_m": view.p_camera_eye.tolist()},
            "handle": {"kind": "root"},
            "from": (0.0, 0.0),
            "at": (50.0, 0.0),
        }
    )
    moved = drag(PERSON, walking(), gesture, {**sights(), "free": view})
    way = moved.pose.p_camera_root - before
    assert way[2] == pytest.approx(50 / 1000 * float(view.depth(before)), rel=1e-6)
    assert abs(way @ view.away) < 1e-9
    assert "kept" not in moved.readout.value  # nearer or farther from the film's camera it is


def test_an_eye_goes_with_the_free_view_alone() -> None:
    given = {"handle": {"kind": "root"}, "from": (0, 0), "at": (1, 1)}
    eye = {"azimuth_deg": 0, "elevation_deg": 5, "at_m": (0, 0, 0)}
    for message in ({"view": "free", **given}, {"view": "top", "eye": eye, **given}):
        with pytest.raises(ValidationError, match="free view"):
            Gesture.model_validate(message)


def test_the_eye_of_a_message_looks_as_the_page_s() -> None:
    eye = Eye(azimuth_deg=90, elevation_deg=0, at_m=(3.0, 0.0, 5.0))
    view = pointer_views(desk().doc, 0, eye)["free"]
    np.testing.assert_allclose(view.away, view_rotations()["side"][2], atol=1e-12)
    assert "free" not in pointer_views(desk().doc, 0)
