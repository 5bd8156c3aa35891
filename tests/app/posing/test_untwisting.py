"""Arms and legs that are dragged are not twisted about their own length beyond their limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from keypose.app.posing import (
    BodyHandle,
    Held,
    angles_deg,
    clamp_to_limits,
    drag,
    handle_named,
    handles,
    untwisted_limb,
)
from keypose.app.posing.angles import with_angles, with_rotation
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.modify import with_clavicles
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import exp_rotation
from tests.app.posing.posing_cases import (
    PERSON,
    VIEWS,
    as_sent,
    bent,
    gesture,
    points,
    pull,
    sights,
    standing,
    walking,
)

SKELETON = Skeleton.of(PERSON)
LIMITS = Limits.of(PERSON)
LIMBS = [h for h in handles(PERSON) if h.kind in ("end", "middle") and len(h.limb) > 1]
PLACED = frozenset(h.name for h in handles(PERSON) if h.kind == "end")
ARM = PERSON.index("left_upper_arm")
ROUNDING_DEG = 0.01


def twisted_deg(pose: Pose) -> float:
    """How far the most twisted part is beyond its limit."""
    return float(np.degrees(np.abs(LIMITS.excess(pose.Rs_parent_part)[0][:, 3]).max()))


def possible(seed: int) -> Pose:
    """A random pose within all limits."""
    return clamp_to_limits(SKELETON, bent(PERSON, seed, size=0.7))


def half_round(pose: Pose, degrees: float = 170.0) -> Pose:
    """The pose with its left upper arm turned about its own length."""
    by = exp_rotation(np.array([0.0, np.radians(degrees), 0.0]))
    return with_rotation(pose, ARM, pose.Rs_parent_part[ARM] @ by)


def dragged(
    pose: Pose, handle: BodyHandle, view: str, way: tuple[float, float], held: Held
) -> Pose:
    views = sights()
    sight = views[view]
    p = points(PERSON, pose)[handle.anchor]
    start = sight.project(p)
    end = start + np.array(way) / sight.metres_per_unit(p)
    return drag(PERSON, pose, gesture(view, as_sent(handle), start, end), views, held=held).pose


@pytest.mark.parametrize("seed", range(4))
def test_random_poses_within_limits_are_not_twisted(seed: int) -> None:
    assert twisted_deg(half_round(standing(PERSON))) > 30.0
    assert twisted_deg(possible(seed)) < ROUNDING_DEG


@given(
    seed=st.integers(0, 40),
    handle=st.sampled_from(LIMBS),
    view=st.sampled_from(VIEWS),
    way=st.tuples(st.floats(-0.9, 0.9), st.floats(-0.9, 0.9)),
    held=st.sampled_from([Held(), Held(placed=PLACED), Held(pinned=PLACED)]),
)
def test_no_drag_of_a_hand_a_foot_an_elbow_or_a_knee_twists_a_limb(
    seed: int, handle: BodyHandle, view: str, way: tuple[float, float], held: Held
) -> None:
    assert twisted_deg(dragged(possible(seed), handle, view, way, held)) < ROUNDING_DEG


@given(
    seed=st.integers(0, 20),
    name=st.sampled_from(["left_shoulder", "right_hip", "root", "head"]),
    way=st.tuples(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4)),
)
def test_hands_that_stay_while_the_trunk_moves_twist_no_arm(
    seed: int, name: str, way: tuple[float, float]
) -> None:
    handle = handle_named(PERSON, name)
    moved = dragged(possible(seed), handle, "side", way, Held(placed=PLACED))
    assert twisted_deg(moved) < ROUNDING_DEG


@pytest.mark.parametrize("name", ["left_hand", "left_elbow"])
def test_an_arm_that_is_twisted_is_mended_by_the_next_drag_without_a_jump(name: str) -> None:
    pose, handle = half_round(walking()), handle_named(PERSON, name)
    assert twisted_deg(pose) > 30.0
    before, turned = pose, []
    for far in np.linspace(0.0, 0.06, 25):
        posed = pull(PERSON, pose, handle, "side", (far, 0.0))[0].pose
        change = before.Rs_parent_part[ARM].T @ posed.Rs_parent_part[ARM]
        turned.append(np.degrees(np.arccos(np.clip((np.trace(change) - 1) / 2, -1, 1))))
        before = posed
    assert turned[0] < 1e-6
    assert max(turned) < 15.0
    assert twisted_deg(before) < ROUNDING_DEG


def test_without_limits_an_arm_may_be_twisted() -> None:
    pose, hand = half_round(walking()), handle_named(PERSON, "left_hand")
    free = pull(PERSON, pose, hand, "side", (0.1, 0.0), limits_on=False)[0].pose
    assert twisted_deg(free) > 20.0


def test_a_typed_angle_stops_where_the_arm_would_be_twisted() -> None:
    raised = with_angles(SKELETON, standing(PERSON), "left_upper_arm", x=-90.0, y=0.0, z=0.0)
    held = with_angles(SKELETON, raised, "left_upper_arm", z=-179.0, limits_on=True)
    assert twisted_deg(held) < ROUNDING_DEG
    stopped = angles_deg(SKELETON, held)[ARM]
    assert -179.0 < stopped[2] < -60.0
    assert stopped[:2] == pytest.approx([-90.0, 0.0], abs=1e-6)


def test_fields_do_not_tell_a_twisted_arm_as_one_within_its_box() -> None:
    shown = angles_deg(SKELETON, half_round(standing(PERSON)))[ARM]
    low, high = PERSON.parts[ARM].limits_deg["y"]
    assert not low <= shown[1] <= high


@pytest.mark.parametrize("degrees", [140.0, 178.0, -165.0])
def test_a_limb_is_untwisted_with_its_joints_where_they_were(degrees: float) -> None:
    pose = half_round(walking(), degrees)
    mended = untwisted_limb(SKELETON, pose, ARM)
    assert twisted_deg(mended) < ROUNDING_DEG
    was, now = points(PERSON, pose), points(PERSON, mended)
    for name in now.keys() - {"left_hand", "left_hand_tip"}:
        np.testing.assert_allclose(now[name], was[name], atol=1e-9)
    bend_m = 2 * np.sin(np.radians(33)) * 0.25  # of the forearm the wrong way, halved
    assert np.linalg.norm(now["left_hand"] - was["left_hand"]) < bend_m
    assert np.abs(LIMITS.excess(mended.Rs_parent_part)[0][PERSON.index("left_forearm")]).max() < 0.1


def test_an_arm_on_a_clavicle_keeps_its_limits_too() -> None:
    body = with_clavicles(PERSON)
    limits = Limits.of(body)
    for name in ("left_hand", "left_elbow"):
        for way in ((0.5, -0.6), (-0.5, -0.4), (0.0, -0.9)):
            posed = pull(body, standing(body), handle_named(body, name), "main", way)[0].pose
            assert np.degrees(np.abs(limits.excess(posed.Rs_parent_part)[0][:, 3]).max()) < 0.01
