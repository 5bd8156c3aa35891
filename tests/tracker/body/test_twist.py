"""How far upper arms and thighs turn about their own length."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.joint_limits import LEAST_DETERMINED, Limits, TwistLimits
from keypose.tracker.body.preset_names import PEOPLE
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import exp_rotation, rotation_from_euler
from tests.rendering import mocap
from tests.rendering.mocap import needs_mocap
from tests.rendering.motions import shelf, speech, stride, throw

Floats = NDArray[np.float64]

BODY = preset("adult_male")
LIMITS = Limits.of(BODY)
LIMBS = [f"{side}_{limb}" for side in ("left", "right") for limb in ("upper_arm", "thigh")]
Y = np.array([0.0, 1.0, 0.0])


def twists() -> TwistLimits:
    assert LIMITS.twists is not None
    return LIMITS.twists


def excess_deg(name: str, R: Floats) -> Floats:
    """(4,) degrees beyond the limits of x, y, z and twist of one part turned so."""
    Rs = np.tile(np.eye(3), (len(BODY.parts), 1, 1))
    Rs[BODY.index(name)] = R
    return np.degrees(LIMITS.excess(Rs)[0][BODY.index(name)])


def about_y(degrees: float) -> Floats:
    return exp_rotation(np.radians(degrees) * Y)


def test_upper_arms_and_thighs_of_people_have_limits_of_twist() -> None:
    for name in PEOPLE:
        body = preset(name)
        assert [part.name for part in body.parts if part.twist] == [
            "left_upper_arm", "right_upper_arm", "left_thigh", "right_thigh"]  # fmt: skip
        for limb in ("upper_arm", "thigh"):
            left, right = (
                body.parts[body.index(f"{side}_{limb}")].twist for side in ("left", "right")
            )
            assert left is not None
            assert right is not None
            assert left.range_deg == (-right.range_deg[1], -right.range_deg[0])
            assert left.toward == (-right.toward[0], *right.toward[1:])


def test_a_part_at_rest_is_not_twisted_and_one_turned_about_its_length_by_that_turn() -> None:
    at_rest = np.tile(np.eye(3), (len(LIMBS), 1, 1))
    assert np.allclose(twists().twist(at_rest), 0.0, atol=1e-12)
    swung = exp_rotation(np.random.default_rng(0).normal(0, 0.5, (200, 1, 3))) @ at_rest
    for turn in (-0.5, 0.4):
        more = twists().twist(swung @ exp_rotation(turn * Y)) - twists().twist(swung)
        assert np.allclose(np.remainder(more - turn + 1, 2 * np.pi), 1.0)


@pytest.mark.parametrize("turn_rad", [1e-3, 0.5, 2.0], ids=["at rest", "bent", "large"])
def test_slopes_are_those_of_small_turns(turn_rad: float) -> None:
    Rs = exp_rotation(np.random.default_rng(1).normal(0, turn_rad, (300, len(LIMBS), 3)))
    slopes, size = twists().slopes(Rs), 1e-6
    along = (np.swapaxes(twists().R_rest, -1, -2) @ Rs)[..., 1, 1]
    determined = 1 + along > LEAST_DETERMINED
    assert determined.mean() > 0.9
    for axis in range(3):
        by = exp_rotation(size * np.eye(3)[axis])
        change = twists().twist(Rs @ by) - twists().twist(Rs @ by.T)
        change = np.arcsin(np.sin(change)) / (2 * size)
        assert np.allclose(slopes[..., axis][determined], change[determined], atol=1e-6)


@pytest.mark.parametrize("k", range(len(LIMBS)), ids=LIMBS)
def test_one_turn_about_an_axis_gives_a_wanted_twist(k: int) -> None:
    limits, rng = twists().one(k), np.random.default_rng(k)
    for _ in range(100):
        R, axis = exp_rotation(rng.normal(0, 1.5, 3)), rng.normal(0, 1, 3)
        axis /= np.linalg.norm(axis)
        wanted = rng.uniform(limits.low, limits.high)
        turn = limits.turn_to(R, axis, wanted)
        assert abs(turn) <= np.pi
        found = float(limits.twist(exp_rotation(turn * axis) @ R))
        assert np.isclose(np.cos(found - wanted), 1.0, atol=1e-12)


def test_a_turn_that_does_not_change_the_twist_is_left_out() -> None:
    limits, across = twists().one(0), np.array([1.0, 0.0, 0.0])
    R = twists().R_rest[0]
    assert limits.turn_to(R, R @ across, 0.0) == 0.0


@pytest.mark.parametrize("side", ["left", "right"])
def test_an_arm_turned_by_half_a_circle_lies_in_the_box_but_not_in_its_twist(side: str) -> None:
    sign = 1.0 if side == "left" else -1.0
    for hanging in (np.eye(3), rotation_from_euler(-0.2 * sign, 0.1, -0.3)):
        beyond = excess_deg(f"{side}_upper_arm", hanging @ about_y(178.0))
        assert np.abs(beyond[:3]).max() < 15.0
        assert abs(beyond[3]) > 40.0
        assert np.abs(excess_deg(f"{side}_upper_arm", hanging)).max() == 0.0


# Where an arm points and which way its bent forearm does: outward, down, back; left arm.
REACHED = {
    "forearm forward at the side": ((0, 1, 0), (0, 0, -1)),
    "hand on the belly": ((0.1, 1, 0.1), (-0.9, 0, -0.4)),
    "turned outward at the side": ((0, 1, 0), (0.9, 0, -0.4)),
    "hand behind the back": ((0.1, 0.85, 0.5), (-0.9, -0.2, 0.1)),
    "arm sideways, forearm forward": ((1, 0, 0), (0, 0, -1)),
    "arm sideways, forearm up": ((1, 0, 0), (0, -1, 0)),
    "arm sideways, forearm down": ((1, 0, 0), (0, 0.94, -0.34)),
    "arm forward, forearm up": ((0, 0, -1), (0, -1, 0)),
    "arm forward, forearm across": ((0, 0, -1), (-1, 0, 0)),
    "hand on the other shoulder": ((-0.4, 0.2, -0.9), (-0.8, -0.3, 0.5)),
    "hand behind the head": ((0.6, -0.8, 0), (-0.6, -0.3, 0.6)),
    "arm up, forearm over the head": ((0.2, -1, 0), (-1, 0, 0)),
}
IMPOSSIBLE = {
    "forearm back at the side": ((0, 1, 0), (0, 0, 1)),
    "arm sideways, forearm back": ((1, 0, 0), (0, 0, 1)),
    "arm forward, forearm outward": ((0, 0, -1), (1, 0.6, 0)),
}


def bent(upper: tuple[float, ...], fore: tuple[float, ...]) -> Floats:
    """(3, 3) the left upper arm that points one way and whose elbow bends the forearm another."""
    y = np.array(upper) / np.linalg.norm(upper)
    z = -(np.array(fore) - (np.array(fore) @ y) * y)
    z /= np.linalg.norm(z)
    return np.stack([np.cross(y, z), y, z], axis=1)


@pytest.mark.parametrize("name", REACHED)
def test_what_arms_do_is_no_twist_beyond_the_limit(name: str) -> None:
    assert excess_deg("left_upper_arm", bent(*REACHED[name]))[3] == 0.0


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_what_no_arm_does_is_beyond_the_limit(name: str) -> None:
    assert abs(excess_deg("left_upper_arm", bent(*IMPOSSIBLE[name]))[3]) > 20.0


def test_limits_widen_to_the_twist_that_was_posed_and_not_beyond() -> None:
    arm = BODY.index("left_upper_arm")
    posed = np.tile(np.eye(3), (len(BODY.parts), 1, 1))
    posed[arm] = about_y(150.0)
    wide = LIMITS.widened([posed])
    assert np.abs(wide.excess(posed)[0][:, 3]).max() < 1e-9
    posed[arm] = about_y(156.0)
    assert np.degrees(wide.excess(posed)[0][arm, 3]) == pytest.approx(6.0)


def test_written_motions_stay_within_limits_of_twist() -> None:
    skeleton = Skeleton.of(BODY)
    for motion in (speech, throw, stride, shelf):
        outside, _ = LIMITS.excess(motion(skeleton).Rs_parent_part)
        assert np.abs(outside[..., 3]).max() == 0.0, motion.__name__


@needs_mocap
def test_recorded_motions_stay_within_limits_of_twist() -> None:
    skeleton, count, beyond = Skeleton.of(BODY), 0, 0
    for motion in (mocap.walk, mocap.jump, mocap.wash, mocap.pirouette, mocap.jumping_jacks):
        outside, _ = LIMITS.excess(motion(skeleton, constrained=False).Rs_parent_part)
        outside = np.degrees(np.abs(outside[:, LIMITS.twisted, 3]))
        count, beyond = count + outside.size, beyond + int((outside > 0).sum())
        assert outside.max() < 5.0, motion.__name__
    assert beyond < 0.01 * count


@needs_mocap
def test_no_recorded_limb_points_where_twist_is_not_determined() -> None:
    skeleton = Skeleton.of(BODY)
    for motion in (mocap.walk, mocap.jump, mocap.wash, mocap.pirouette, mocap.jumping_jacks):
        Rs = motion(skeleton, constrained=False).Rs_parent_part[:, LIMITS.twisted]
        along = (np.swapaxes(twists().R_rest, -1, -2) @ Rs)[..., 1, 1]
        assert along.min() > -0.5, motion.__name__
