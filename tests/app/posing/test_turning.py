"""Rings: the part turns with the pointer, from where it was grabbed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from keypose.app.posing import Posed, angles_deg, drag
from keypose.app.posing.limits import JointRange
from keypose.app.posing.turning import furthest
from keypose.app.posing.vectors import any_across
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation, log_rotation
from tests.app.posing.posing_cases import (
    CAMERA,
    PERSON,
    TELEPHOTO,
    VIEWS,
    Floats,
    bent,
    difference,
    gesture,
    points,
    rotations,
    sights,
    standing,
    walking,
)

SKELETON = Skeleton.of(PERSON)
PARTS = ("waist", "chest", "left_upper_arm", "right_forearm", "left_foot")


def ring_axis(pose: Pose, part: str, axis: str, frame: str, view: str) -> Floats:
    """The ring's axis in the camera frame."""
    Rs, k = rotations(PERSON, pose), "xyz".index(axis)
    parent = PERSON.parts[PERSON.index(part)].parent
    R = {
        "part": Rs[part],
        "parent": Rs[parent] if parent else np.eye(3),
        "view": sights()[view].R_view_camera.T,
    }[frame]
    return np.array(R[:, k])


def turn_ring(
    pose: Pose,
    part: str,
    axis: str,
    angle: float,
    *,
    frame: str = "part",
    view: str = "main",
    camera: Camera = TELEPHOTO,
    begin: float = 0.3,
    radius_m: float = 0.1,
    limits_on: bool = False,
    angle_before: float | None = None,
    **more: Any,
) -> Posed:
    """A point of the ring dragged along the ring by an angle."""
    sight = sights(camera)[view]
    a, centre = ring_axis(pose, part, axis, frame, view), points(PERSON, pose)[part]
    spoke = radius_m * any_across(a)
    start, end = (
        sight.project(centre + exp_rotation(t * a) @ spoke) for t in (begin, begin + angle)
    )
    sent = gesture(view, {"kind": "ring", "part": part, "axis": axis}, start, end, **more)
    return drag(
        PERSON,
        pose,
        sent,
        sights(camera),
        limits_on=limits_on,
        axes_frame=frame,  # type: ignore[arg-type]
        angle_before=angle_before,
    )


def made_turn(before: Pose, after: Pose, part: str) -> Floats:
    """The rotation vector (3,) by which a part has turned in the camera frame."""
    R = rotations(PERSON, after)[part] @ rotations(PERSON, before)[part].T
    return np.asarray(log_rotation(R))


@pytest.mark.parametrize("frame", ["part", "parent", "view"])
@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("part", PARTS)
def test_a_point_of_the_ring_dragged_along_it_turns_the_part_by_that_angle(
    part: str, view: str, frame: str
) -> None:
    pose = bent(PERSON, 3)
    for axis in "xyz":
        a = ring_axis(pose, part, axis, frame, view)
        if abs(a @ sights()[view].away) < 0.3:
            continue  # seen from the edge
        for angle in (0.02, -0.5, 1.4, -2.9):
            posed = turn_ring(pose, part, axis, angle, frame=frame, view=view)
            np.testing.assert_allclose(made_turn(pose, posed.pose, part), angle * a, atol=1e-7)
            assert posed.readout.angle_rad == pytest.approx(angle)
            assert (posed.readout.part, posed.readout.axis) == (part, axis)


def test_in_perspective_a_small_ring_is_followed_to_a_hundredth() -> None:
    pose = walking()
    posed = turn_ring(pose, "chest", "z", 0.8, frame="view", camera=CAMERA)
    assert posed.readout.angle_rad == pytest.approx(0.8, rel=0.01)


@given(st.floats(-3, 3), st.sampled_from(PARTS), st.sampled_from("xyz"), st.sampled_from(VIEWS))
def test_only_the_part_and_what_it_carries_move_and_its_joint_stays(
    angle: float, part: str, axis: str, view: str
) -> None:
    pose = walking()
    after = turn_ring(pose, part, axis, angle, view=view).pose
    np.testing.assert_allclose(after.p_camera_root, pose.p_camera_root)
    others = [i for i, name in enumerate(PERSON.names) if name != part]
    np.testing.assert_array_equal(after.Rs_parent_part[others], pose.Rs_parent_part[others])
    np.testing.assert_allclose(points(PERSON, after)[part], points(PERSON, pose)[part], atol=1e-12)


@pytest.mark.parametrize("view", VIEWS)
def test_nothing_jumps_when_a_ring_is_grabbed(view: str) -> None:
    for part in PARTS:
        for axis in "xyz":
            pose = walking()
            assert difference(turn_ring(pose, part, axis, 0.0, view=view).pose, pose) < 1e-12
            near = turn_ring(pose, part, axis, 1e-4, view=view).pose
            assert difference(near, pose) < 2e-3


def test_a_ring_seen_from_its_edge_follows_its_near_side() -> None:
    # The person faces the camera: its own y ring is seen from the edge, and the near side of it
    # goes to the right when the body turns to its left, as the pointer does.
    pose = standing(PERSON)
    view = sights(TELEPHOTO)["main"]
    centre = points(PERSON, pose)["waist"]
    start = view.project(centre)
    for metres in (0.05, -0.3, 0.4):
        end = start + np.array([metres / view.metres_per_unit(centre), 0])
        sent = gesture("main", {"kind": "ring", "part": "waist", "axis": "y"}, start, end)
        posed = drag(PERSON, pose, sent, sights(TELEPHOTO))
        turned = made_turn(pose, posed.pose, "waist")
        near_side = exp_rotation(turned * 1e-3) @ [0.0, 0.0, -1.0]
        assert np.sign(near_side[0]) == np.sign(metres)
        assert posed.readout.angle_rad == pytest.approx(-metres / 0.15)
        across = start + np.array([0, metres / view.metres_per_unit(centre)])
        sent = gesture("main", {"kind": "ring", "part": "waist", "axis": "y"}, start, across)
        assert drag(PERSON, pose, sent, sights(TELEPHOTO)).readout.angle_rad == pytest.approx(0)


def test_turns_beyond_half_a_circle_are_counted_on() -> None:
    pose, before = walking(), 0.0
    for step in range(1, 90):
        angle = 0.1 * step
        posed = turn_ring(pose, "waist", "z", angle, frame="view", angle_before=before)
        before = posed.readout.angle_rad or 0.0
        assert before == pytest.approx(angle)
    assert "+" in posed.readout.value or "+" in posed.readout.change


@given(st.floats(-3, 3))
def test_snapping_takes_steps_of_five_degrees(angle: float) -> None:
    posed = turn_ring(walking(), "waist", "z", angle, frame="view", snap=True)
    made = math.degrees(posed.readout.angle_rad or 0.0)
    assert made == pytest.approx(5 * round(made / 5), abs=1e-9)
    assert abs(made - math.degrees(angle)) <= 2.5 + 1e-6


@given(st.floats(-3, 3), st.sampled_from("xyz"), st.sampled_from(["part", "parent", "view"]))
def test_a_turn_stops_where_it_meets_a_limit_and_never_leaps_it(
    angle: float, axis: str, frame: str
) -> None:
    pose = walking()
    posed = turn_ring(pose, "right_forearm", axis, angle, frame=frame, limits_on=True)
    i = PERSON.index("right_forearm")
    limits = PERSON.parts[i].limits_deg
    after = angles_deg(SKELETON, posed.pose)[i]
    for k, name in enumerate("xyz"):
        assert limits[name][0] - 1e-3 <= after[k] <= limits[name][1] + 1e-3
    made = posed.readout.angle_rad or 0.0
    free = turn_ring(pose, "right_forearm", axis, angle, frame=frame).readout.angle_rad or 0.0
    assert abs(made) <= abs(free) + 1e-9
    assert made * free >= 0


def test_the_limit_is_reached_to_a_hundredth_of_a_degree_and_can_be_lifted() -> None:
    pose = walking()
    i = PERSON.index("right_forearm")
    bend = angles_deg(SKELETON, pose)[i, 0]
    view = sights(TELEPHOTO)["side"]
    assert abs(ring_axis(pose, "right_forearm", "x", "part", "side") @ view.away) > 0.3
    stopped = turn_ring(pose, "right_forearm", "x", 2.0, view="side", limits_on=True)
    assert angles_deg(SKELETON, stopped.pose)[i, 0] == pytest.approx(0.0, abs=0.01)
    for more in ({"limits_on": True, "free": True}, {"limits_on": False}):
        freed = turn_ring(pose, "right_forearm", "x", 2.0, view="side", **more)
        assert angles_deg(SKELETON, freed.pose)[i, 0] == pytest.approx(bend + math.degrees(2.0))


def test_what_is_beyond_a_limit_already_stays_and_may_come_back() -> None:
    pose = walking()
    i = PERSON.index("right_forearm")
    beyond = turn_ring(pose, "right_forearm", "x", 1.0, view="side").pose
    start = angles_deg(SKELETON, beyond)[i, 0]
    assert start > 10
    for angle, made in ((0.0, 0.0), (0.3, 0.0), (-0.2, -0.2)):
        posed = turn_ring(beyond, "right_forearm", "x", angle, view="side", limits_on=True)
        assert posed.readout.angle_rad == pytest.approx(made, abs=1e-3)


def test_the_readout_names_the_angle_and_how_much_it_changed() -> None:
    pose = walking()
    bend = angles_deg(SKELETON, pose)[PERSON.index("right_forearm"), 0]
    readout = turn_ring(pose, "right_forearm", "x", -0.5, view="side").readout
    assert readout.label == "Bend"
    assert readout.value == f"−{abs(bend - math.degrees(0.5)):.1f}°"
    assert readout.change == "−28.6"


def test_a_part_taken_by_its_surface_turns_as_the_pointer_goes_round_its_joint() -> None:
    pose, view = walking(), sights(TELEPHOTO)["main"]
    joint = view.project(points(PERSON, pose)["left_upper_arm"])
    start, end = joint + np.array([40, 0]), joint + np.array([0, 40])
    sent = gesture("main", {"kind": "surface", "part": "left_upper_arm"}, start, end)
    posed = drag(PERSON, pose, sent, sights(TELEPHOTO), limits_on=False)
    np.testing.assert_allclose(
        made_turn(pose, posed.pose, "left_upper_arm"), [0, 0, math.pi / 2], atol=0.03
    )
    about_x = drag(
        PERSON, pose, sent.model_copy(update={"axis": "x"}), sights(TELEPHOTO), limits_on=False
    )
    turned = made_turn(pose, about_x.pose, "left_upper_arm")
    own = ring_axis(pose, "left_upper_arm", "x", "part", "main")
    np.testing.assert_allclose(np.cross(turned, own), 0, atol=1e-9)


def test_an_angle_of_a_million_turns_is_looked_at_for_one_turn_only() -> None:
    box = JointRange(np.radians([[-30.0, 30.0], [-30.0, 30.0], [-30.0, 30.0]]))
    axis = np.array([1.0, 0.0, 0.0])
    far = furthest(np.eye(3), axis, 2e6 * np.pi, box)
    assert far == pytest.approx(furthest(np.eye(3), axis, 2.0, box), abs=1e-4)
    free = JointRange(np.array([[-np.pi, np.pi]] * 3))
    assert furthest(np.eye(3), axis, 2e6 * np.pi, free) == 2e6 * np.pi
