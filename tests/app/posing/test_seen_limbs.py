"""On the picture, elbow and hand each stay where they are seen while the other is dragged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.app.posing import Held, PointerView, Posed, drag, ends_to_hold, handle_named, handles
from keypose.app.posing.gesture import GestureContext
from keypose.app.posing.seen_limbs import SeenLimb
from keypose.app.posing.two_bones import TwoBones
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.solver.depth_turn import turned_in_depth
from tests.app.posing.posing_cases import (
    CAMERA,
    PERSON,
    TELEPHOTO,
    Floats,
    as_sent,
    gesture,
    points,
    pull,
    sights,
    standing,
    tumbling,
    walking,
)
from tests.app.posing.test_holding import ALL, ENDS, off_m, off_px, pulled
from tests.app.posing.test_steadiness import JUMP, drawn, largest_jump

SEEN_PX = 0.5
MIDDLE_OF = {
    "left_hand": "left_elbow",
    "right_hand": "right_elbow",
    "left_foot": "left_knee",
    "right_foot": "right_knee",
}
LIMB_OF = {h.name: (*h.movers, h.anchor) for h in ends_to_hold(PERSON)}
REST = points(PERSON, standing(PERSON))
UPPER_M, LOWER_M = (
    {end: float(np.linalg.norm(REST[a[k + 1]] - REST[a[k]])) for end, a in LIMB_OF.items()}
    for k in (0, 1)
)
every_end = pytest.mark.parametrize("end", ENDS)


def bent() -> Pose:
    """Walking with hands and feet drawn well toward the trunk."""
    pose = walking()
    for name in ENDS:
        handle = handle_named(PERSON, name)
        way = (0.1, -0.12) if "hand" in name else (0.15, -0.2)
        pose = pull(PERSON, pose, handle, "side", way)[0].pose
    return pose


def bent_in_depth() -> list[tuple[Pose, str]]:
    """Limbs whose upper bone points clearly nearer or farther: its length decides how far."""
    found = []
    for pose in (walking(), tumbling(), bent()):
        p = points(PERSON, pose)
        for end in ENDS:
            first, middle = (p[name] for name in LIMB_OF[end][:2])
            away = sights()["main"].ray_through(middle)
            if abs(float((middle - first) @ away)) > 0.2 * UPPER_M[end]:
                found.append((pose, end))
    assert len(found) >= 6
    return found


def within_reach(pose: Pose, end: str, seed: int) -> tuple[Floats, Floats]:
    """Where (3,) a limb's middle joint could be, on the side where it is, and where (3,) its end
    is: the lower bone can reach the end's line of sight from there."""
    view, p = sights()["main"], points(PERSON, pose)
    first, middle, at_end = (p[name] for name in LIMB_OF[end])
    rng = np.random.default_rng(seed)
    for _ in range(1000):
        goal = first + exp_rotation(rng.normal(0.0, 0.12, 3)) @ (middle - first)
        away, ray = (view.ray_through(at) for at in (goal, at_end))
        sides = [float((at - first) @ away) / UPPER_M[end] for at in (middle, goal)]
        reaches = np.linalg.norm(np.cross(goal, ray)) < 0.9 * LOWER_M[end]
        if sides[0] * sides[1] > 0 and min(map(abs, sides)) > 0.09 and reaches:
            return goal, at_end
    raise AssertionError(f"{end} lies level")


def dragged(pose: Pose, name: str, way_m: tuple[float, float], **more: object) -> Posed:
    handle = handle_named(PERSON, name)
    return pulled(PERSON, pose, as_sent(handle), handle.anchor, "main", way_m, **more)[0]  # type: ignore[arg-type]


def anchor_of(name: str) -> str:
    return handle_named(PERSON, name).anchor


@pytest.mark.parametrize(("pose", "end"), bent_in_depth())
def test_an_elbow_or_knee_is_dragged_and_its_hand_or_foot_stays_where_it_is_seen(
    pose: Pose, end: str
) -> None:
    """Unless the limb would have to turn about itself by far, or its hinge aside by more than the
    4° that a knee yields: that is done in part only."""
    view, handle = sights()["main"], handle_named(PERSON, MIDDLE_OF[end])
    off = []
    for seed in range(7):
        goal, at_end = within_reach(pose, end, seed)
        at = view.project(points(PERSON, pose)[handle.anchor]), view.project(goal)
        sent = gesture("main", as_sent(handle), *at)
        posed = drag(PERSON, pose, sent, sights(), held=ALL).pose
        p = points(PERSON, posed)
        np.testing.assert_allclose(p[handle.anchor], goal, atol=1e-6)
        beyond, _ = Limits.of(PERSON).excess(posed.Rs_parent_part)
        assert np.degrees(np.abs(beyond[PERSON.index(handle.part)])).max() < 1.0
        off.append(np.linalg.norm(view.project(p[end]) - view.project(at_end)))
    assert np.median(off) < 1e-3
    assert max(off) < 8.0


@every_end
@pytest.mark.parametrize("way_m", [(0.03, 0.0), (0.0, 0.03), (-0.03, 0.0), (0.0, -0.03)])
def test_a_hand_or_foot_is_dragged_and_its_elbow_or_knee_stays_where_it_is(
    end: str, way_m: tuple[float, float]
) -> None:
    pose = bent()
    posed = dragged(pose, end, way_m)
    assert not posed.readout.out_of_reach
    if off_m(pose, posed.pose, anchor_of(MIDDLE_OF[end])) > 1e-9:  # it had to come along
        lower = [points(PERSON, posed.pose)[name] for name in LIMB_OF[end][1:]]
        level = (lower[1] - lower[0]) @ sights()["main"].ray_through(lower[1])
        assert abs(level) < 1e-6 * LOWER_M[end]


def test_a_hand_dragged_farther_than_its_forearm_reaches_takes_the_elbow_along() -> None:
    pose = bent()
    for way_m in ((0.2, 0.0), (0.15, -0.15), (-0.2, 0.0)):
        posed = dragged(pose, "left_hand", way_m)
        assert not posed.readout.out_of_reach
        assert off_m(pose, posed.pose, "left_forearm") > 0.01


def test_beyond_the_reach_of_both_bones_a_limb_is_straight_and_says_so() -> None:
    posed = dragged(walking(), "left_hand", (1.5, -0.4))
    p, reach = points(PERSON, posed.pose), posed.readout.reach
    assert posed.readout.out_of_reach
    assert reach is not None
    away = np.linalg.norm(p["left_hand"] - p["left_upper_arm"])
    assert away == pytest.approx(reach.radius_m, abs=2e-3)


@pytest.mark.parametrize("name", ["left_elbow", "left_hand"])
def test_alt_drags_a_limb_as_if_nothing_stayed(name: str) -> None:
    pose = walking()
    along = dragged(pose, name, (0.06, -0.05), carry=True)
    free = dragged(pose, name, (0.06, -0.05), held=Held())
    np.testing.assert_array_equal(along.pose.Rs_parent_part, free.pose.Rs_parent_part)
    stays = dragged(pose, name, (0.06, -0.05))
    assert np.abs(stays.pose.Rs_parent_part - along.pose.Rs_parent_part).max() > 0.01


def test_a_pinned_hand_stays_in_its_place_in_space_while_its_elbow_is_dragged() -> None:
    pose = bent()
    held = Held(ALL.placed, frozenset({"left_hand"}))
    posed = dragged(pose, "left_elbow", (0.03, 0.02), held=held)
    assert off_m(pose, posed.pose, "left_hand") < 1e-6


@pytest.mark.parametrize("pose", [bent(), tumbling()], ids=["bent", "tumbling"])
def test_elbows_and_knees_stay_where_they_are_seen_too_while_the_trunk_is_dragged(
    pose: Pose,
) -> None:
    """As far as bones reach: most of them, and the others nearly."""
    joints = (*ENDS, *(anchor_of(name) for name in MIDDLE_OF.values()))
    for name, way_m in (("root", (0.02, -0.01)), ("root", (-0.015, 0.015)), ("head", (0.02, 0.0))):
        posed = dragged(pose, name, way_m)
        off = [off_px(pose, posed.pose, (joint,)) for joint in joints]
        assert np.median(off) < SEEN_PX
        assert max(off) < 4.0


def test_the_body_taken_nearer_leaves_hands_and_feet_where_they_are_seen() -> None:
    pose = bent()
    for up in (0.05, -0.05):
        stays, along = (
            dragged(pose, "root", (0.0, up), depth=True, carry=carry) for carry in (False, True)
        )
        assert abs(stays.pose.p_camera_root[2] - pose.p_camera_root[2]) > 0.1
        off = [[off_px(pose, made.pose, (end,)) for end in ENDS] for made in (stays, along)]
        assert np.median(off[0]) < np.median(off[1]) / 3


def test_a_body_taken_far_nearer_leaves_its_limbs_behind() -> None:
    """They point to where they were: feet stay farther away than the hips that are taken nearer."""
    pose = walking()
    posed = dragged(pose, "root", (0.0, 0.15), depth=True)
    p = points(PERSON, posed.pose)
    assert posed.pose.p_camera_root[2] < pose.p_camera_root[2] - 0.3
    for end in ("left_foot", "right_foot"):
        assert p[end][2] > p["waist"][2] + 0.1
        assert off_px(pose, posed.pose, (end,)) < SEEN_PX


@pytest.mark.parametrize("up", [0.055, -0.055])
@pytest.mark.parametrize(("pose", "end"), bent_in_depth())
def test_a_limb_keeps_its_side_when_its_body_was_seen_too_large_or_too_small(
    pose: Pose, end: str, up: float
) -> None:
    posed = dragged(pose, "root", (0.0, up), depth=True).pose
    assert abs(posed.p_camera_root[2] - pose.p_camera_root[2]) > 0.2
    assert side_of(posed, end) * side_of(pose, end) > 0


@pytest.mark.parametrize("nearer_m", [0.3, -0.3])
@pytest.mark.parametrize(("pose", "end"), bent_in_depth())
def test_a_limb_points_to_where_it_was_when_what_carries_it_is_turned_as_well(
    pose: Pose, end: str, nearer_m: float
) -> None:
    Rs = pose.Rs_parent_part.copy()
    Rs[0] = exp_rotation(np.array([0.0, 0.0, 0.05])) @ Rs[0]
    place = pose.p_camera_root - np.array([0.0, 0.0, nearer_m])
    before = GestureContext.of(Skeleton.of(PERSON), pose, True)
    for turns, sign in ((pose.Rs_parent_part, side_of(pose, end)), (Rs, nearer_m)):
        carried = GestureContext.of(before.skeleton, Pose(turns, place), True)
        limb = TwoBones.of(carried, *indices(*LIMB_OF[end][:2]), tip(end))
        middle = SeenLimb.of(limb, sights()["main"], before).with_end(*seen_at(pose, end))
        side = side_of(carried.turned(middle.rotations), end) * np.sign(sign)
        assert side > -0.01  # 0 where the bone does not reach its line of sight


def seen_at(pose: Pose, end: str) -> tuple[Floats, Floats]:
    """(2,) where the middle joint of a limb is seen, and its end."""
    p, view = points(PERSON, pose), sights()["main"]
    middle, last = (view.project(p[name]) for name in LIMB_OF[end][1:])
    return middle, last


@pytest.mark.parametrize(("pose", "end"), bent_in_depth())
def test_a_level_elbow_or_knee_goes_to_the_side_where_it_is_at_the_frames_beside(
    pose: Pose, end: str
) -> None:
    """It was dragged out until its bone lay level, and is dragged back to where it was seen."""
    handle, view = handle_named(PERSON, MIDDLE_OF[end]), sights()["main"]
    level = levelled(pose, end)
    assert abs(side_of(level, end)) < 0.05
    at, back = (view.project(points(PERSON, each)[handle.anchor]) for each in (level, pose))
    sent = gesture("main", as_sent(handle), at, back)
    for beside in (pose, the_other_way(pose, end)):
        if abs(side_of(beside, end)) < 0.1:
            continue  # its joint cannot bend the other way
        posed = drag(PERSON, level, sent, sights(), held=replace(ALL, beside=(beside,))).pose
        assert side_of(posed, end) * side_of(beside, end) > 0


@pytest.mark.parametrize(("pose", "end"), bent_in_depth())
def test_a_level_joint_goes_to_its_side_at_the_frames_beside_without_a_jump(
    pose: Pose, end: str
) -> None:
    level, handle = levelled(pose, end), handle_named(PERSON, MIDDLE_OF[end])
    for beside in (pose, the_other_way(pose, end)):
        held = replace(ALL, beside=(beside,))
        for degrees in (15, 100, 190, 280):
            worst = largest_jump(drawn(PERSON, level, handle, "main", degrees, True, held))
            assert worst < JUMP, (degrees, np.degrees(worst))


def levelled(pose: Pose, end: str) -> Pose:
    """The middle joint of a limb dragged out until its upper bone lies level."""
    view, p = sights()["main"], points(PERSON, pose)
    first, middle = (view.project(p[name]) for name in LIMB_OF[end][:2])
    px = UPPER_M[end] / view.metres_per_unit(p[LIMB_OF[end][0]])
    out = first + px * (middle - first) / np.linalg.norm(middle - first)
    sent = gesture("main", as_sent(handle_named(PERSON, MIDDLE_OF[end])), middle, out)
    return drag(PERSON, pose, sent, sights(), held=ALL).pose


def the_other_way(pose: Pose, end: str) -> Pose:
    """The limb turned in depth, as far as its joints bend that way."""
    top = PERSON.index(LIMB_OF[end][0])
    return turned_in_depth(Skeleton.of(PERSON), CAMERA, pose, top)


def side_of(pose: Pose, end: str) -> float:
    """How far beyond the first joint of a limb the middle one lies, in lengths of the bone."""
    p = points(PERSON, pose)
    first, middle = (p[name] for name in LIMB_OF[end][:2])
    return float((middle - first) @ sights()["main"].ray_through(middle)) / UPPER_M[end]


def test_a_level_limb_bends_as_its_joint_can() -> None:
    """An upright straight leg whose knee is dragged sideways bends forward, not backward."""
    view = PointerView.of(TELEPHOTO)
    context = GestureContext.of(Skeleton.of(PERSON), walking(), True)
    limb = TwoBones.of(context, *indices("left_thigh", "left_shin"), tip("left_foot"))
    seen = SeenLimb.of(limb, view, context)
    level = SeenLimb(limb, view, (0.01, -0.01), -0.9)
    for one in (seen, level):
        reached = one.with_end(one.middle_at, one.end_at + np.array([0.0, -8.0]))
        pose = context.turned(reached.rotations)
        bend = GestureContext.of(context.skeleton, pose, True).angles(limb.lower)[0]
        assert 0.0 <= bend <= np.radians(135) + 1e-6


def indices(*names: str) -> tuple[int, int]:
    upper, lower = (PERSON.index(name) for name in names)
    return upper, lower


def tip(name: str) -> Floats:
    return np.array(PERSON.parts[PERSON.index(name)].joint_m)


def test_nothing_changes_when_a_joint_is_grabbed() -> None:
    for pose in (walking(), tumbling(), bent()):
        for handle in handles(PERSON):
            still = dragged(pose, handle.name, (0.0, 0.0)).pose
            assert np.abs(still.Rs_parent_part - pose.Rs_parent_part).max() < 1e-6, handle.name


@every_end
def test_an_end_comes_under_the_pointer_wherever_its_limb_can_bring_it(end: str) -> None:
    handle, sight = handle_named(PERSON, end), sights()["main"]
    rng = np.random.default_rng(7)
    for pose in (walking(), tumbling(), bent(), standing(PERSON)):
        for _ in range(20):
            angle, drawn = rng.uniform(0, 2 * np.pi), rng.uniform(0.02, 0.4)
            way = (float(drawn * np.cos(angle)), float(drawn * np.sin(angle)))
            start = sight.project(points(PERSON, pose)[handle.anchor])
            goal = start + np.array(way) / sight.metres_per_unit(
                points(PERSON, pose)[handle.anchor]
            )
            sent = gesture("main", as_sent(handle), start, goal)
            alone, others = (
                drag(PERSON, pose, sent, sights(), held=held).pose for held in (Held(), ALL)
            )
            missed, missed_alone = (
                np.linalg.norm(sight.project(points(PERSON, posed)[handle.anchor]) - goal)
                for posed in (others, alone)
            )
            assert missed < missed_alone + 1.0
