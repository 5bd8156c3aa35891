"""Hands and feet that were put somewhere stay there while the rest of the body is dragged."""

from __future__ import annotations

import math
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from keypose.app.posing import Held, Posed, drag, ends_to_hold, handles, keep_pinned, placed_ends
from keypose.app.posing.angles import with_angles
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from tests.app.posing.posing_cases import (
    ARMS,
    BOX,
    DOG,
    PERSON,
    VIEWS,
    Floats,
    bent,
    difference,
    gesture,
    points,
    rotations,
    sights,
    standing,
    tumbling,
    walking,
)
from tests.app.posing.test_steadiness import JUMP, WAYS_DEG, largest_jump
from tests.tracker.tracking_cases import deep_chain

CHAIN = deep_chain(6).body
SKELETON = Skeleton.of(PERSON)
ENDS = ("left_hand", "right_hand", "left_foot", "right_foot")
ALL = Held(placed=frozenset(ENDS))
ROOT: dict[str, Any] = {"kind": "root"}
HEAD = {"kind": "end", "name": "head"}
CHEST = {"kind": "ring", "part": "chest", "axis": "y"}
LIMB_OF = {h.name: h for h in ends_to_hold(PERSON)}
PIXEL = 0.5
RAD = math.radians(1)

way = st.tuples(st.floats(-0.25, 0.25), st.floats(-0.25, 0.25))
every_pose = pytest.mark.parametrize("pose", [walking(), tumbling()], ids=["walking", "tumbling"])


def pulled(
    body: Body,
    pose: Pose,
    handle: dict[str, Any],
    anchor: str,
    view: str,
    way_m: tuple[float, float],
    held: Held = ALL,
    **more: Any,
) -> tuple[Posed, Floats]:
    """A handle at an anchor dragged by so many metres; the result and where the pointer ended."""
    sight, p = sights()[view], points(body, pose)[anchor]
    start = sight.project(p)
    end = start + np.array(way_m) / sight.metres_per_unit(p)
    return drag(body, pose, gesture(view, handle, start, end, **more), sights(), held=held), end


def off_px(before: Pose, after: Pose, names: tuple[str, ...] = ENDS) -> float:
    """The largest way, in pixels of the picture, that any of the points has gone."""
    view = sights()["main"]
    p, q = points(PERSON, before), points(PERSON, after)
    return max(float(np.abs(view.project(p[n]) - view.project(q[n])).max()) for n in names)


def off_m(before: Pose, after: Pose, name: str) -> float:
    return float(np.linalg.norm(points(PERSON, after)[name] - points(PERSON, before)[name]))


@every_pose
@given(way=way, view=st.sampled_from(VIEWS))
def test_hands_and_feet_stay_while_the_waist_is_dragged(
    pose: Pose, way: tuple[float, float], view: str
) -> None:
    posed, end = pulled(PERSON, pose, ROOT, "waist", view, way)
    after = points(PERSON, posed.pose)
    np.testing.assert_allclose(sights()[view].project(after["waist"]), end, atol=1e-6)
    for name in ENDS:
        if name not in posed.readout.unreached:
            assert view == "main" or off_m(pose, posed.pose, name) < 0.002
            assert off_px(pose, posed.pose, (name,)) < PIXEL


@pytest.mark.parametrize("way", [(0.05, 0.02), (-0.05, 0.04), (0.0, 0.06)])
def test_a_planted_foot_stays_whole_while_the_weight_is_shifted_over_it(
    way: tuple[float, float],
) -> None:
    pose = walking()
    posed, _ = pulled(PERSON, pose, ROOT, "waist", "front", way)
    assert posed.readout.unreached == ()
    feet = tuple(n for n in points(PERSON, pose) if "foot" in n or "toe" in n or "heel" in n)
    assert len(feet) > 2
    assert off_px(pose, posed.pose, feet) < PIXEL
    turned = [rotations(PERSON, p)["left_foot"] for p in (pose, posed.pose)]
    np.testing.assert_allclose(*turned, atol=1e-9)


@every_pose
@given(way=way, view=st.sampled_from(VIEWS), handle=st.sampled_from([HEAD, CHEST]))
def test_hands_stay_while_head_or_chest_are_dragged_and_the_legs_do_not_move(
    pose: Pose, way: tuple[float, float], view: str, handle: dict[str, Any]
) -> None:
    anchor = "head_top" if handle is HEAD else "left_upper_arm"
    posed, _ = pulled(PERSON, pose, handle, anchor, view, way)
    for name in ("left_hand", "right_hand"):
        if name not in posed.readout.unreached:
            assert off_px(pose, posed.pose, (name,)) < PIXEL
    before, after = rotations(PERSON, pose), rotations(PERSON, posed.pose)
    for name in ("left_thigh", "left_shin", "left_foot", "right_thigh", "right_foot"):
        np.testing.assert_array_equal(before[name], after[name])


@every_pose
@given(way=way, view=st.sampled_from(VIEWS), side=st.sampled_from(["left", "right"]))
def test_an_elbow_or_knee_goes_round_the_line_to_its_held_end_where_depth_is_seen_or_it_is_pinned(
    pose: Pose, way: tuple[float, float], view: str, side: str
) -> None:
    held = Held(pinned=frozenset(ENDS)) if view == "main" else ALL
    for joint, part, end in (("elbow", "forearm", "hand"), ("knee", "shin", "foot")):
        handle = {"kind": "joint", "name": f"{side}_{joint}"}
        posed, _ = pulled(PERSON, pose, handle, f"{side}_{part}", view, way, held)
        p, q = points(PERSON, pose), points(PERSON, posed.pose)
        np.testing.assert_allclose(q[f"{side}_{end}"], p[f"{side}_{end}"], atol=1e-9)
        circle = around(p, LIMB_OF[f"{side}_{end}"].limb[0], f"{side}_{part}", f"{side}_{end}")
        assert np.linalg.norm(circle - q[f"{side}_{part}"], axis=1).min() < 1e-3


def around(p: dict[str, Floats], first: str, middle: str, end: str) -> Floats:
    """(N, 3) where the middle joint can be while both ends stay."""
    axis = (p[end] - p[first]) / np.linalg.norm(p[end] - p[first])
    foot = p[first] + ((p[middle] - p[first]) @ axis) * axis
    spoke = p[middle] - foot
    angles = np.linspace(0, 2 * np.pi, 720)[:, None]
    return np.asarray(foot + np.cos(angles) * spoke + np.sin(angles) * np.cross(axis, spoke))


@pytest.mark.parametrize("view", VIEWS)
@every_pose
def test_an_elbow_dragged_along_its_circle_lies_under_the_pointer(pose: Pose, view: str) -> None:
    for joint, part, end in (("elbow", "forearm", "hand"), ("knee", "shin", "foot")):
        p, name = points(PERSON, pose), f"left_{part}"
        circle = around(p, LIMB_OF[f"left_{end}"].limb[0], name, f"left_{end}")
        sight = sights()[view]
        for k in (20, 60, 660, 700):  # of 720: up to 30°
            ends = sight.project(p[name]), sight.project(circle[k])
            sent = gesture(view, {"kind": "joint", "name": f"left_{joint}"}, *ends)
            q = points(PERSON, drag(PERSON, pose, sent, sights(), held=ALL).pose)
            size = np.ptp(sight.project(circle), axis=0).max()
            assert np.linalg.norm(sight.project(q[name]) - ends[1]) < 0.05 * size, (joint, k)


def test_what_cannot_be_reached_is_stretched_toward_straight_and_said() -> None:
    pose = walking()
    posed, _ = pulled(PERSON, pose, ROOT, "waist", "front", (0.0, -0.9))
    assert set(posed.readout.unreached) == set(ENDS)
    p, q = points(PERSON, pose), points(PERSON, posed.pose)
    for name in ENDS:
        first, middle = (q[part] for part in LIMB_OF[name].limb[:2])
        line = (p[name] - first) / np.linalg.norm(p[name] - first)
        for bone in (middle - first, q[name] - middle):
            assert bone @ line / np.linalg.norm(bone) > math.cos(RAD)
    near, _ = pulled(PERSON, pose, ROOT, "waist", "front", (0.0, 0.01))
    assert near.readout.unreached == ()


def test_carried_along_they_move_as_if_nothing_held_them() -> None:
    pose = walking()
    for handle, anchor in (
        (ROOT, "waist"), (HEAD, "head_top"), (CHEST, "left_upper_arm"),
        ({"kind": "joint", "name": "left_elbow"}, "left_forearm"),
    ):  # fmt: skip
        for view in VIEWS:
            free, _ = pulled(PERSON, pose, handle, anchor, view, (0.1, 0.05), Held())
            along, _ = pulled(PERSON, pose, handle, anchor, view, (0.1, 0.05), ALL, carry=True)
            assert difference(free.pose, along.pose) == 0
            if handle is ROOT:
                assert off_px(pose, along.pose) > 4


def test_a_limb_turned_by_its_own_ring_takes_its_end_along_unless_that_is_pinned() -> None:
    pose = walking()
    for part in ("left_thigh", "left_shin"):
        ring = {"kind": "ring", "part": part, "axis": "x"}
        turned, _ = pulled(PERSON, pose, ring, "left_foot", "side", (0.2, 0.05))
        assert off_m(pose, turned.pose, "left_foot") > 0.02
        pinned = Held(pinned=frozenset({"left_foot"}))
        for carry in (False, True):
            stays, _ = pulled(
                PERSON, pose, ring, "left_foot", "side", (0.2, 0.05), pinned, carry=carry
            )
            assert off_m(pose, stays.pose, "left_foot") < 0.002
    foot = {"kind": "ring", "part": "left_foot", "axis": "x"}
    turned, _ = pulled(PERSON, pose, foot, "left_toes" if "left_toes" in points(PERSON, pose)
                       else "left_foot", "side", (0.1, 0.1), pinned)  # fmt: skip
    assert off_m(pose, turned.pose, "left_foot") < 1e-12
    assert difference(turned.pose, pose) > 0.01


def test_a_pinned_end_stays_when_the_whole_body_is_carried_but_can_be_dragged_itself() -> None:
    pose, pinned = walking(), Held(pinned=frozenset({"left_foot"}))
    posed, _ = pulled(PERSON, pose, ROOT, "waist", "front", (0.03, 0.04), pinned, carry=True)
    assert off_px(pose, posed.pose, ("left_foot",)) < PIXEL
    assert off_px(pose, posed.pose, ("right_foot",)) > 4
    itself, end = pulled(
        PERSON, pose, {"kind": "end", "name": "left_foot"}, "left_foot", "main", (0.0, -0.1), pinned
    )
    seen = sights()["main"].project(points(PERSON, itself.pose)["left_foot"])
    np.testing.assert_allclose(seen, end, atol=1e-6)


def test_a_pinned_end_stays_when_numbers_change() -> None:
    pose, pinned = walking(), frozenset({"left_foot", "right_hand"})
    leant = with_angles(SKELETON, pose, "chest", x=10.0)
    moved = Pose(pose.Rs_parent_part, pose.p_camera_root + np.array([0.02, 0.03, 0.04]))
    bent_knee = with_angles(SKELETON, pose, "left_thigh", x=-30.0)
    for after, part in ((leant, "chest"), (moved, "waist"), (bent_knee, "left_thigh")):
        kept = keep_pinned(SKELETON, pose, after, pinned, part)
        assert off_m(pose, kept, "left_foot") < 1e-6
        assert off_m(pose, kept, "right_hand") < 1e-6
        if part != "left_thigh":
            assert off_m(pose, kept, "left_hand") == off_m(pose, after, "left_hand")


def test_knees_keep_their_place_when_the_hips_turn_over_planted_feet() -> None:
    pose = walking()
    waist = {"kind": "ring", "part": "waist", "axis": "y"}
    posed, _ = pulled(PERSON, pose, waist, "left_thigh", "top", (0.0, 0.3))
    assert off_m(pose, posed.pose, "left_thigh") > 0.01
    assert off_px(pose, posed.pose, ("left_foot", "right_foot")) < PIXEL
    for side in ("left", "right"):
        hip, knee = (off_m(pose, posed.pose, f"{side}_{name}") for name in ("thigh", "shin"))
        assert knee < 1.2 * hip


@pytest.mark.parametrize(
    ("handle", "anchor"),
    [
        (ROOT, "waist"),
        (HEAD, "head_top"),
        ({"kind": "joint", "name": "left_knee"}, "left_shin"),
        ({"kind": "joint", "name": "left_elbow"}, "left_forearm"),
        ({"kind": "end", "name": "left_hand"}, "left_hand"),
        ({"kind": "joint", "name": "left_shoulder"}, "left_upper_arm"),
        ({"kind": "joint", "name": "left_hip"}, "left_thigh"),
    ],
    ids=["waist", "head", "knee", "elbow", "hand", "shoulder", "hip"],
)
@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("pose", [standing(PERSON), walking()], ids=["standing", "walking"])
def test_no_limb_jumps_while_its_end_is_held(
    pose: Pose, view: str, handle: dict[str, Any], anchor: str
) -> None:
    still, _ = pulled(PERSON, pose, handle, anchor, view, (0.0, 0.0))
    assert difference(still.pose, pose) < 1e-6
    for degrees in WAYS_DEG[view]:
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))

        def at(metres: float, c: float = c, s: float = s) -> Floats:
            posed, _ = pulled(PERSON, pose, handle, anchor, view, (c * metres, s * metres))
            return np.stack(list(rotations(PERSON, posed.pose).values()))

        assert largest_jump(at) < JUMP, (degrees, math.degrees(largest_jump(at)))


@pytest.mark.parametrize("body", [DOG, ARMS, CHAIN], ids=lambda body: body.name)
def test_limbs_of_two_or_more_bones_hold_their_ends_on_any_body(body: Body) -> None:
    held = ends_to_hold(body)
    names = Held(pinned=frozenset(handle.name for handle in held))
    for seed in range(3):
        pose = bent(body, seed, 0.3)
        root = body.parts[0].name
        posed, _ = pulled(body, pose, ROOT, root, "main", (0.01, 0.01), names)
        p, q = points(body, pose), points(body, posed.pose)
        for handle in held:
            if handle.name not in posed.readout.unreached:
                np.testing.assert_allclose(q[handle.anchor], p[handle.anchor], atol=2e-3)
        assert len(posed.readout.unreached) < max(1, len(held))


def test_a_box_has_no_end_to_hold_and_moves_whole() -> None:
    assert ends_to_hold(BOX) == ()
    pose = standing(BOX)
    root = BOX.parts[0].name
    posed, _ = pulled(BOX, pose, ROOT, root, "main", (0.1, 0.0), Held(frozenset({root})))
    np.testing.assert_array_equal(posed.pose.Rs_parent_part, pose.Rs_parent_part)
    assert posed.pose.p_camera_root[0] > pose.p_camera_root[0] + 0.09


def test_an_end_is_placed_once_its_limb_is_no_longer_at_rest() -> None:
    pose = standing(PERSON)
    assert placed_ends(PERSON, pose) == frozenset()
    hand = {"kind": "end", "name": "left_hand"}
    posed, _ = pulled(PERSON, pose, hand, "left_hand", "main", (0.1, -0.2))
    assert placed_ends(PERSON, posed.pose) == {"left_hand"}
    assert placed_ends(PERSON, walking()) == set(ENDS)


def test_holding_all_four_is_still_little_work() -> None:
    """Calls are counted: a time would depend on the computer and on what else it does."""
    pose = walking()
    knee = {"kind": "joint", "name": "left_knee"}
    for handle, anchor in ((ROOT, "waist"), (HEAD, "head_top"), (knee, "left_shin")):
        count = 0

        def counted(frame: Any, event: str, argument: Any) -> None:
            nonlocal count
            count += event == "call"

        pulled(PERSON, pose, handle, anchor, "main", (0.05, 0.02))
        sys.setprofile(counted)
        try:
            pulled(PERSON, pose, handle, anchor, "main", (0.05, 0.02))
        finally:
            sys.setprofile(None)
        assert count < 6000, handle


def test_every_handle_can_be_dragged_anywhere_with_all_ends_held() -> None:
    for body, pose in ((PERSON, standing(PERSON)), (PERSON, tumbling()), (DOG, bent(DOG, 1, 0.4))):
        held = Held(placed=frozenset(handle.name for handle in ends_to_hold(body)))
        for handle in handles(body):
            kind = {"root": "root", "middle": "joint"}.get(handle.kind, "end")
            sent = {"kind": kind} if kind == "root" else {"kind": kind, "name": handle.name}
            for way_m in ((-3.0, 1.0), (50.0, 50.0)):
                posed, _ = pulled(body, pose, sent, handle.anchor, "main", way_m, held)
                assert np.isfinite(posed.pose.Rs_parent_part).all()
