"""Hands, feet, elbows, knees and heads dragged: the limb follows."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.posing import BodyHandle, angles_deg, drag, handle_named, handles
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
    rotations,
    sights,
    standing,
    tumbling,
    walking,
)
from tests.tracker.tracking_cases import deep_chain, random_body
from tracker.body import Body
from tracker.camera import Camera
from tracker.pose import Pose
from tracker.skeleton import Skeleton

CHAIN = deep_chain(6).body
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
        (body, standing(body)) for body in (PERSON, DOG, ARMS)
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


@pytest.mark.parametrize("handle", MIDDLES, ids=lambda h: h.name)
@given(way=way)
def test_an_elbow_follows_the_pointer_on_the_picture(
    handle: BodyHandle, way: tuple[float, float]
) -> None:
    pose = walking()
    posed, end, seen = pull(PERSON, pose, handle, "main", way)
    if not posed.readout.out_of_reach:
        np.testing.assert_allclose(seen, end, atol=0.5)
    reach, sight = posed.readout.reach, sights()["main"]
    assert reach is not None
    origin, ray = sight.ray(end)
    beside = np.linalg.norm(np.cross(reach.centre - origin, ray))
    if beside < reach.radius_m and np.hypot(*way) > 0.06:  # past where it changes sides
        np.testing.assert_allclose(seen, end, atol=1e-6)
    if beside > reach.radius_m + 0.003:
        assert posed.readout.out_of_reach


def test_a_hand_stays_where_it_is_while_its_bent_elbow_is_dragged_around() -> None:
    pose = walking()
    hand, elbow = handle_named(PERSON, "left_hand"), handle_named(PERSON, "left_elbow")
    folded = pull(PERSON, pose, hand, "side", (-0.25, -0.3))[0].pose
    p = points(PERSON, folded)
    shoulder, at_hand = p["left_upper_arm"], p["left_hand"]
    axis = (at_hand - shoulder) / np.linalg.norm(at_hand - shoulder)
    foot = shoulder + ((p["left_forearm"] - shoulder) @ axis) * axis
    spoke = p["left_forearm"] - foot
    assert np.linalg.norm(spoke) > 0.1
    sight = sights()["main"]
    for angle in np.radians([-60, -30, -5, 5, 30, 60]):
        across = np.cross(axis, spoke)
        goal = foot + np.cos(angle) * spoke + np.sin(angle) * across
        ends = sight.project(p["left_forearm"]), sight.project(goal)
        sent = gesture("main", {"kind": "joint", "name": elbow.name}, *ends)
        after = points(PERSON, drag(PERSON, folded, sent, sights()).pose)
        if np.linalg.norm(after["left_forearm"] - goal) < 1e-6:  # not on the other side
            np.testing.assert_allclose(after["left_hand"], at_hand, atol=0.02)


@every_pose
@given(way=st.tuples(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4)), view=st.sampled_from(VIEWS))
def test_neck_and_chest_take_their_shares_when_the_head_is_dragged(
    pose: Pose, way: tuple[float, float], view: str
) -> None:
    head = handle_named(PERSON, "head")
    posed, end, seen = pull(PERSON, pose, head, view, way, limits_on=False)
    before, after = rotations(PERSON, pose), rotations(PERSON, posed.pose)
    turned = [
        np.arccos(np.clip((np.trace(after[name] @ before[name].T) - 1) / 2, -1, 1))
        for name in ("chest", "neck", "head")
    ]
    assert turned[0] <= turned[1] + 1e-9 <= turned[2] + 2e-9
    if turned[2] > 1e-3:
        assert 0.5 < turned[0] / turned[2] < 0.7
    if view == "main" and not posed.readout.out_of_reach and np.hypot(*way) > 0.06:
        np.testing.assert_allclose(seen, end, atol=0.3)  # 2 mm past its outline, or exactly
        assert np.abs(seen - end).max() < 1e-4 or past_outline(posed.pose, end)


def past_outline(after: Pose, end: np.ndarray) -> bool:
    """Whether the pointer is farther from the lowest joint than the head can be."""
    p = points(PERSON, after)
    origin, ray = sights()["main"].ray(end)
    beside = np.linalg.norm(np.cross(p["chest"] - origin, ray))
    return bool(beside > np.linalg.norm(p["head_top"] - p["chest"]))


def test_the_head_keeps_the_limits_of_neck_and_chest() -> None:
    pose, head = standing(PERSON), handle_named(PERSON, "head")
    for view in VIEWS:
        for way_m in ((0.4, 0.2), (-0.3, 0.3), (0.6, 0.6)):
            posed, _, _ = pull(PERSON, pose, head, view, way_m)
            now = angles_deg(SKELETON, posed.pose)
            for name in head.movers:
                limits = PERSON.parts[PERSON.index(name)].limits_deg
                for k, axis in enumerate("xyz"):
                    low, high = limits[axis]
                    assert low - 1e-3 <= now[PERSON.index(name), k] <= high + 1e-3


@pytest.mark.parametrize("view", VIEWS)
@given(way=st.tuples(st.floats(-0.12, 0.12), st.floats(-0.12, 0.12)), seed=st.integers(0, 30))
def test_a_chain_of_many_bones_follows_too(view: str, way: tuple[float, float], seed: int) -> None:
    pose = bent(CHAIN, seed, 0.35)
    handle = next(h for h in handles(CHAIN) if h.kind == "end")
    posed, end, seen = pull(CHAIN, pose, handle, view, way)
    reach = posed.readout.reach
    assert reach is not None
    goal = sights()[view].at_depth(end, points(CHAIN, pose)[handle.anchor])
    share = np.linalg.norm(goal - reach.centre) / reach.radius_m
    if share < 0.999:
        np.testing.assert_allclose(seen, end, atol=1e-5)
    assert share > 0.999 or not posed.readout.out_of_reach


def test_a_straight_chain_can_be_folded() -> None:
    pose = standing(CHAIN)
    handle = next(h for h in handles(CHAIN) if h.kind == "end")
    for metres in (0.001, 0.02, 0.1, 0.2):
        _, end, seen = pull(CHAIN, pose, handle, "side", (0.0, -metres))
        np.testing.assert_allclose(seen, end, atol=1e-5)


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
