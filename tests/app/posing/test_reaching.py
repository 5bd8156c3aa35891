"""Hands and feet dragged: the limb follows; and what holds for every handle."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from keypose.app.posing import BodyHandle, angles_deg, drag, handle_named, handles
from keypose.tracker.body.body import Body
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.modify import with_clavicles
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from tests.app.posing.posing_cases import (
    ARMS,
    CAMERA,
    DOG,
    PERSON,
    TELEPHOTO,
    VIEWS,
    bent,
    difference,
    gesture,
    off_axis,
    points,
    pull,
    sights,
    standing,
    tumbling,
    walking,
)
from tests.tracker.tracking_cases import deep_chain, random_body

CHAIN = deep_chain(6).body
MOVING = with_clavicles(PERSON)
SKELETON = Skeleton.of(PERSON)
ENDS = [h for h in handles(PERSON) if h.kind == "end"]
MIDDLES = [h for h in handles(PERSON) if h.kind == "middle"]
POSES = {"standing": standing(PERSON), "walking": walking(), "tumbling": tumbling()}
way = st.tuples(st.floats(-0.25, 0.25), st.floats(-0.25, 0.25))
cameras = pytest.mark.parametrize("camera", [CAMERA, TELEPHOTO], ids=["perspective", "telephoto"])
every_pose = pytest.mark.parametrize("pose", POSES.values(), ids=POSES.keys())


def cases() -> list[tuple[Body, Pose]]:
    """Bodies of many kinds, posed."""
    bodies = [PERSON, DOG, ARMS, CHAIN, *(random_body(k, 9).body for k in range(4))]
    return [(body, bent(body, k, 0.4)) for k, body in enumerate(bodies)] + [
        (body, standing(body)) for body in (PERSON, DOG, ARMS, MOVING)
    ]


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize(("body", "pose"), cases(), ids=lambda case: getattr(case, "name", ""))
def test_nothing_jumps_when_a_handle_is_grabbed(body: Body, pose: Pose, view: str) -> None:
    for handle in handles(body):
        for limits_on in (True, False):
            for more in ({}, {"depth": True}, {"axis": "y"}):
                grabbed, _, _ = pull(body, pose, handle, view, (0, 0), limits_on=limits_on, **more)
                assert difference(grabbed.pose, pose) < 1e-6, (handle.name, more)


@cameras
@every_pose
@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("handle", ENDS, ids=lambda h: h.name)
@given(way=way)
def test_a_hand_within_reach_lies_under_the_pointer_at_the_depth_it_had(
    handle: BodyHandle, view: str, pose: Pose, camera: Camera, way: tuple[float, float]
) -> None:
    before = points(PERSON, pose)
    posed, end, seen = pull(PERSON, pose, handle, view, way, camera=camera)
    p = points(PERSON, posed.pose)[handle.anchor]
    goal = sights(camera)[view].at_depth(end, before[handle.anchor])
    assert posed.readout.reach is not None
    reach = posed.readout.reach
    if np.linalg.norm(goal - reach.centre) > reach.radius_m:
        assert np.linalg.norm(p - reach.centre) == pytest.approx(reach.radius_m)
        return
    if posed.readout.out_of_reach:  # too near to its own shoulder
        assert np.linalg.norm(goal - reach.centre) < 0.5 * reach.radius_m
        return
    np.testing.assert_allclose(p, goal, atol=2e-3)
    if np.degrees(np.abs(fold(pose, handle))) > 1:  # bent as a joint bends
        np.testing.assert_allclose(p, goal, atol=1e-7)
        np.testing.assert_allclose(seen, end, atol=1e-6 * max(1.0, float(np.abs(end).max())))


def fold(pose: Pose, handle: BodyHandle) -> float:
    """How far elbow or knee is bent, radians."""
    p = points(PERSON, pose)
    upper, lower = (p[name] for name in handle.limb[:2])
    return off_axis(lower - upper, p[handle.anchor] - lower)


@every_pose
@given(way=way, view=st.sampled_from(VIEWS), handle=st.sampled_from([*ENDS, *MIDDLES]))
def test_only_the_limb_moves_and_bones_keep_their_lengths(
    pose: Pose, way: tuple[float, float], view: str, handle: BodyHandle
) -> None:
    posed, _, _ = pull(PERSON, pose, handle, view, way)
    before, after = points(PERSON, pose), points(PERSON, posed.pose)
    for part in PERSON.parts[1:]:
        assert part.parent
        bones = [np.linalg.norm(p[part.name] - p[part.parent]) for p in (before, after)]
        assert bones[0] == pytest.approx(bones[1], abs=1e-9)
    others = [i for i, name in enumerate(PERSON.names) if name not in handle.limb[:2]]
    np.testing.assert_array_equal(posed.pose.Rs_parent_part[others], pose.Rs_parent_part[others])


@every_pose
@given(way=way, view=st.sampled_from(VIEWS), handle=st.sampled_from(ENDS))
def test_an_elbow_or_knee_only_bends_and_only_as_far_as_it_can(
    pose: Pose, way: tuple[float, float], view: str, handle: BodyHandle
) -> None:
    posed, _, _ = pull(PERSON, pose, handle, view, way)
    i = PERSON.index(handle.limb[1])
    before, after = (angles_deg(SKELETON, p)[i] for p in (pose, posed.pose))
    np.testing.assert_allclose(after[1:], before[1:], atol=1e-6)
    low, high = PERSON.parts[i].limits_deg["x"]
    assert min(low, before[0]) - 1e-6 <= after[0] <= max(high, before[0]) + 1e-6


@given(st.floats(0.02, 0.3), st.sampled_from(VIEWS), st.sampled_from(ENDS))
def test_a_limb_stays_in_the_plane_it_is_bent_in_while_it_is_dragged_in_it(
    size: float, view: str, handle: BodyHandle
) -> None:
    pose = walking()
    p = points(PERSON, pose)
    shoulder, elbow, hand = (p[name] for name in (*handle.limb[:2], handle.anchor))
    plane = np.cross(elbow - shoulder, hand - elbow)
    inward = (shoulder - hand) / np.linalg.norm(shoulder - hand)
    sight = sights()[view]
    flat = sight.slope(hand) @ inward * size
    end = sight.project(hand) + flat
    goal = sight.at_depth(end, hand)
    sent = gesture(view, {"kind": "end", "name": handle.name}, sight.project(hand), end)
    after = points(PERSON, drag(PERSON, pose, sent, sights()).pose)
    normal = np.cross(after[handle.limb[1]] - shoulder, after[handle.anchor] - shoulder)
    if abs((goal - shoulder) @ plane) < 1e-4 * np.linalg.norm(plane):  # dragged inside it
        assert off_axis(normal, plane) < 0.05


def test_a_hand_out_of_reach_sticks_to_the_sphere_straight_toward_the_pointer() -> None:
    pose, handle = walking(), handle_named(PERSON, "left_hand")
    posed, end, seen = pull(PERSON, pose, handle, "main", (2.0, -1.0))
    reach = posed.readout.reach
    assert reach is not None
    assert posed.readout.out_of_reach
    p = points(PERSON, posed.pose)
    bones = [PERSON.parts[PERSON.index(name)].joint_m for name in ("left_forearm", "left_hand")]
    assert reach.radius_m == pytest.approx(sum(np.linalg.norm(bone) for bone in bones))
    np.testing.assert_allclose(reach.centre, p["left_upper_arm"], atol=1e-12)
    assert np.linalg.norm(p["left_hand"] - reach.centre) == pytest.approx(reach.radius_m)
    centre = sights()["main"].project(reach.centre)
    flat = (np.append(at - centre, 0.0) for at in (end, seen))
    assert off_axis(*flat) < 0.02


@given(st.floats(-0.3, 0.3), st.sampled_from(ENDS))
def test_depth_moves_a_hand_along_the_line_of_sight(up: float, handle: BodyHandle) -> None:
    pose = walking()
    posed, _, seen = pull(PERSON, pose, handle, "main", (0.0, -up), depth=True)
    before, after = (points(PERSON, p)[handle.anchor] for p in (pose, posed.pose))
    reach = posed.readout.reach
    assert reach is not None
    goal = before + up * before / np.linalg.norm(before)
    if np.linalg.norm(goal - reach.centre) < reach.radius_m and not posed.readout.out_of_reach:
        np.testing.assert_allclose(seen, sights()["main"].project(before), atol=1e-6)
        assert np.linalg.norm(after - before) == pytest.approx(abs(up), abs=1e-7)
        assert (after - before)[2] * up >= -1e-9


def test_a_straight_arm_bends_at_once_and_forward() -> None:
    pose, handle = standing(PERSON), handle_named(PERSON, "left_hand")
    for metres in (1e-4, 1e-3, 0.01, 0.1, 0.3):
        posed, end, seen = pull(PERSON, pose, handle, "side", (0.0, -metres))
        np.testing.assert_allclose(seen, end, atol=1e-6)
        assert angles_deg(SKELETON, posed.pose)[PERSON.index("left_forearm"), 0] < 0
        p = points(PERSON, posed.pose)
        assert p["left_forearm"][2] >= p["left_upper_arm"][2] - 1e-9  # the elbow goes back


def test_a_joint_bent_the_wrong_way_is_brought_to_the_right_side_by_the_drag() -> None:
    pose, handle = standing(PERSON), handle_named(PERSON, "left_hand")
    Rs = pose.Rs_parent_part.copy()
    i = PERSON.index("left_forearm")
    Rs[i] = Rs[i] @ np.array([[1, 0, 0], [0, 0.998, -0.0632], [0, 0.0632, 0.998]])
    wrong = Pose(np.array(Rs), pose.p_camera_root)
    assert angles_deg(SKELETON, wrong)[i, 0] > 3
    bends = []
    for metres in np.linspace(0, 0.1, 41):
        posed, end, seen = pull(PERSON, wrong, handle, "side", (0.0, -metres))
        bends.append(angles_deg(SKELETON, posed.pose)[i, 0])
        assert np.abs(end - seen).max() < 6e-3
    assert bends[0] == pytest.approx(angles_deg(SKELETON, wrong)[i, 0])
    assert bends[-1] < -30
    free, _, _ = pull(PERSON, wrong, handle, "side", (0.0, -0.1), limits_on=False)
    assert angles_deg(SKELETON, free.pose)[i, 0] > 30


@pytest.mark.parametrize(("body", "pose"), cases(), ids=lambda case: getattr(case, "name", ""))
def test_every_handle_of_every_body_can_be_dragged_anywhere(body: Body, pose: Pose) -> None:
    for handle in handles(body):
        for view in VIEWS:
            for way_m in ((0.05, 0.02), (-3.0, 1.0), (50.0, 50.0)):
                posed, _, _ = pull(body, pose, handle, view, way_m)
                R = posed.pose.Rs_parent_part
                np.testing.assert_allclose(R @ np.swapaxes(R, 1, 2) - np.eye(3), 0, atol=1e-12)
                assert np.isfinite(posed.pose.p_camera_root).all()
                assert posed.body is None
                assert posed.readout.label


def test_a_part_pulled_by_its_surface_pulls_the_end_beyond() -> None:
    pose, views = walking(), sights()
    start, end = (300.0, 180.0), (320.0, 170.0)
    for part, name in (("left_forearm", "left_hand"), ("left_upper_arm", "left_elbow")):
        by_part = {"kind": "surface", "part": part}
        by_handle = {"kind": "end", "name": name}
        one, other = (
            drag(PERSON, pose, gesture("main", handle, start, end, tool="ends"), views)
            for handle in (by_part, by_handle)
        )
        assert difference(one.pose, other.pose) == 0
    waist = {"kind": "surface", "part": "waist", "tool": "ends"}
    moved = drag(PERSON, pose, gesture("main", waist, start, end), views)
    assert moved.pose.p_camera_root[0] > pose.p_camera_root[0]


def test_the_readout_of_a_hand_says_that_its_depth_is_kept() -> None:
    readout = pull(PERSON, walking(), handle_named(PERSON, "right_hand"), "main", (0.1, 0))[
        0
    ].readout
    assert readout.label == "Right hand"
    assert readout.value.startswith("depth kept ")
    assert readout.depth_m == pytest.approx(points(PERSON, walking())["right_hand"][2])


@pytest.mark.parametrize("far", [0.02, 0.3])
@pytest.mark.parametrize("view", ["main", "side"])
def test_a_dragged_shoulder_turns_its_clavicle_alone_and_within_its_limits(
    view: str, far: float
) -> None:
    pose, handle = standing(MOVING), handle_named(MOVING, "left_shoulder")
    posed, _, _ = pull(MOVING, pose, handle, view, (0.0, -far))
    turned = {
        name
        for name, one, other in zip(
            MOVING.names, posed.pose.Rs_parent_part, pose.Rs_parent_part, strict=True
        )
        if np.abs(one - other).max() > 1e-9
    }
    assert turned == {"left_clavicle"}
    rise = points(MOVING, pose)["left_upper_arm"] - points(MOVING, posed.pose)["left_upper_arm"]
    assert rise[1] > 0.01
    outside, _ = Limits.of(MOVING).excess(posed.pose.Rs_parent_part)
    assert np.abs(outside).max() < 1e-6


def test_a_hand_of_a_body_with_clavicles_is_reached_as_that_of_one_without() -> None:
    for name in ("left_hand", "right_elbow"):
        with_, without = (
            pull(body, standing(body), handle_named(body, name), "main", (0.1, -0.1))[0].pose
            for body in (MOVING, PERSON)
        )
        for point, place in points(PERSON, without).items():
            np.testing.assert_allclose(points(MOVING, with_)[point], place, atol=1e-6)
