"""Elbows, knees, heads and long chains dragged: who follows, and who stays."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from keypose.app.posing import BodyHandle, angles_deg, drag, handle_named, handles
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from tests.app.posing.posing_cases import (
    PERSON,
    VIEWS,
    bent,
    gesture,
    points,
    pull,
    rotations,
    sights,
    standing,
    tumbling,
    walking,
)
from tests.tracker.tracking_cases import deep_chain

CHAIN = deep_chain(6).body
SKELETON = Skeleton.of(PERSON)
MIDDLES = [h for h in handles(PERSON) if h.kind == "middle"]
POSES = {"standing": standing(PERSON), "walking": walking(), "tumbling": tumbling()}
way = st.tuples(st.floats(-0.25, 0.25), st.floats(-0.25, 0.25))
every_pose = pytest.mark.parametrize("pose", POSES.values(), ids=POSES.keys())


@pytest.mark.parametrize("handle", MIDDLES, ids=lambda h: h.name)
@given(way=way)
def test_an_elbow_follows_the_pointer_on_the_picture(
    handle: BodyHandle, way: tuple[float, float]
) -> None:
    pose = walking()
    posed, end, seen = pull(PERSON, pose, handle, "main", way)
    if not posed.readout.out_of_reach:
        np.testing.assert_allclose(seen, end, atol=0.5)
    reach, view = posed.readout.reach, sights()["main"]
    assert reach is not None
    origin, ray = view.ray(end)
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
    view = sights()["main"]
    for angle in np.radians([-60, -30, -5, 5, 30, 60]):
        across = np.cross(axis, spoke)
        goal = foot + np.cos(angle) * spoke + np.sin(angle) * across
        ends = view.project(p["left_forearm"]), view.project(goal)
        sent = gesture("main", {"kind": "joint", "name": elbow.name}, *ends)
        after = points(PERSON, drag(PERSON, folded, sent, sights()).pose)
        if np.linalg.norm(after["left_forearm"] - goal) < 1e-6:  # not on the other side
            np.testing.assert_allclose(after["left_hand"], at_hand, atol=0.02)


@every_pose
@given(way=st.tuples(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4)), view=st.sampled_from(VIEWS))
@example(way=(-0.32203131, 0.14337758), view="main")  # just within reach of the tumbling one
@example(way=(-0.09521411, 0.02023838), view="main")
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
    assert turned[0] <= turned[1] + 1e-6 <= turned[2] + 2e-6  # as exact as arccos is near 1
    if turned[2] > 1e-3:
        assert 0.5 < turned[0] / turned[2] < 0.7
    if view == "main" and not posed.readout.out_of_reach and np.hypot(*way) > 0.06:
        np.testing.assert_allclose(seen, end, atol=0.5)  # 2 mm past its outline, or exactly
        assert np.abs(seen - end).max() < 1e-6 or past_outline(posed.pose, end)


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
