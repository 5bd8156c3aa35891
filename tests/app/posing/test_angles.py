"""Angles in fields, joint limits, and the places where angles are not unique."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from keypose.app.posing import (
    angle_curve_deg,
    angles_deg,
    at_limit,
    axis_labels,
    clamp_to_limits,
    part_label,
    with_angles,
    with_reset,
)
from keypose.app.posing.angles import rotation_of
from keypose.app.posing.limits import (
    JointRange,
    box_of,
    is_within,
    nearest_within,
    of_angles,
    range_of,
)
from keypose.tracker.body.body import preset
from keypose.tracker.body.heading import from_heading_first
from keypose.tracker.body.preset_names import PEOPLE
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import (
    Array,
    exp_rotation,
    log_rotation,
    rotation_from_euler,
)
from keypose.tracker.storage.fingerprints import setup_hash
from tests.app.posing.posing_cases import ARMS, PERSON, bent, difference, standing, walking

SKELETON = Skeleton.of(PERSON)
angle = st.floats(-180, 180)
small = st.floats(-80, 80)
NO_KEYS = np.array([], dtype=np.intp)


@given(angle, st.floats(-89, 89), angle)
def test_angles_that_are_set_are_shown_and_mean_qz_qy_qx(x: float, y: float, z: float) -> None:
    skeleton = Skeleton.of(ARMS)
    pose = with_angles(skeleton, standing(ARMS), "left_arm", x, y, z)
    i = ARMS.index("left_arm")
    np.testing.assert_allclose(
        pose.Rs_parent_part[i], rotation_from_euler(*np.radians([z, y, x])), atol=1e-12
    )
    shown = angles_deg(skeleton, pose)[i]
    np.testing.assert_allclose(np.cos(np.radians(shown - [x, y, z])), 1, atol=1e-9)


def test_an_angle_that_is_not_given_stays() -> None:
    pose = with_angles(SKELETON, walking(), "left_thigh", z=12.0)
    before, after = (angles_deg(SKELETON, p)[PERSON.index("left_thigh")] for p in (walking(), pose))
    np.testing.assert_allclose(after, [before[0], before[1], 12.0])
    others = [i for i in range(len(PERSON.parts)) if i != PERSON.index("left_thigh")]
    np.testing.assert_array_equal(pose.Rs_parent_part[others], walking().Rs_parent_part[others])


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("start", [(10.0, 20.0, -30.0), (0.0, 0.0, 0.0), (-120.0, 60.0, 100.0)])
def test_a_full_turn_runs_on_through_every_angle(
    axis: int, start: tuple[float, float, float]
) -> None:
    # twice around; y goes through both quarter turns, where x and z cannot be distinguished
    wanted = np.tile(start, (721, 1))
    wanted[:, axis] += np.arange(721.0)
    part = ARMS.parts[ARMS.index("left_arm")]
    Rs = np.stack([rotation_of(angles) for angles in wanted])
    np.testing.assert_allclose(angle_curve_deg(part, Rs, NO_KEYS), wanted, atol=1e-6)


def test_a_typed_angle_stops_at_the_limit_only_when_limits_are_on() -> None:
    i = PERSON.index("left_shin")
    free = with_angles(SKELETON, walking(), "left_shin", x=-40.0)
    assert angles_deg(SKELETON, free)[i, 0] == pytest.approx(-40)
    held = with_angles(SKELETON, walking(), "left_shin", x=-40.0, limits_on=True)
    assert angles_deg(SKELETON, held)[i, 0] == pytest.approx(0)
    assert at_limit(SKELETON, held) == {"left_shin": ["x"]}
    assert at_limit(SKELETON, walking()) == {}


def test_reset_lays_one_part_to_rest() -> None:
    pose = with_reset(SKELETON, walking(), "left_thigh")
    np.testing.assert_array_equal(pose.Rs_parent_part[PERSON.index("left_thigh")], np.eye(3))
    again = with_angles(SKELETON, pose, "left_thigh", *angles_deg(SKELETON, walking())[10])
    assert PERSON.names[10] == "left_thigh"
    assert difference(again, walking()) < 1e-12


@pytest.mark.parametrize("part", ["left_upper_arm", "right_thigh", "chest", "left_shin"])
def test_the_nearest_allowed_rotation_is_nearer_than_any_other(part: str) -> None:
    box = box_of(PERSON.parts[PERSON.index(part)])
    assert box is not None
    rng = np.random.default_rng(4)
    for R in exp_rotation(rng.normal(0, 1.2, (25, 3))):
        found = nearest_within(R, JointRange(box))
        assert is_within(found, JointRange(box))
        if is_within(R, JointRange(box)):
            np.testing.assert_array_equal(found, R)
            continue
        made = np.linalg.norm(log_rotation(R.T @ found))
        tries = rng.uniform(box[:, 0], box[:, 1], (3000, 3))
        others = np.stack([of_angles(t) for t in tries])
        least = np.linalg.norm(log_rotation(R.T @ others), axis=-1).min()
        assert made <= least + 1e-6


def test_a_clamped_pose_keeps_every_limit_and_is_not_clamped_again() -> None:
    for seed in range(5):
        held = clamp_to_limits(SKELETON, bent(PERSON, seed, size=0.9))
        for R, part in zip(held.Rs_parent_part, PERSON.parts, strict=True):
            assert is_within(R, range_of(part)), part.name
        assert difference(clamp_to_limits(SKELETON, held), held) < 1e-6
        now = angles_deg(SKELETON, held)
        for i, part in enumerate(PERSON.parts):
            for k, name in enumerate("xyz"):
                low, high = part.limits_deg.get(name, (-math.inf, math.inf))
                assert low - 1e-3 <= now[i, k] <= high + 1e-3


@pytest.mark.parametrize("name", PEOPLE)
def test_every_joint_of_a_person_has_limits_that_hold_the_rest_pose(name: str) -> None:
    body = preset(name)
    for part in body.parts[1:]:
        assert set(part.limits_deg) == {"x", "y", "z"}, part.name
        assert all(low <= 0 <= high for low, high in part.limits_deg.values()), part.name
    assert body.parts[0].limits_deg == {}
    for left, right in body.mirror_pairs:
        one, other = (body.parts[body.index(part)].limits_deg for part in (left, right))
        assert one["x"] == other["x"]
        for axis in ("y", "z"):
            assert one[axis] == (-other[axis][1], -other[axis][0])  # type: ignore[index]


def test_elbows_and_knees_bend_one_way_only() -> None:
    limits = {part.name: part.limits_deg for part in PERSON.parts}
    assert limits["left_forearm"]["x"] == (-150, 0)
    assert limits["left_shin"]["x"] == (0, 135)


def test_words_fit_parts_axes_and_sides() -> None:
    assert part_label("right_forearm") == "Right forearm"
    assert axis_labels(PERSON, "waist") == {"x": "Lean", "y": "Turn", "z": "Tilt"}
    assert axis_labels(PERSON, "left_shin") == {"x": "Bend", "y": "Twist", "z": "Side"}
    assert axis_labels(PERSON, "left_hand")["z"] == "Bend"
    assert axis_labels(ARMS, "left_arm") == {"x": "Bend", "y": "Twist", "z": "Side"}


def test_limits_do_not_make_a_tracked_motion_outdated() -> None:
    from keypose.tracker.storage.files import load_session
    from tests.app.posing.posing_cases import SAMPLES

    session = load_session(SAMPLES / "person" / "session.json")
    bare = [part.model_copy(update={"limits_deg": {}}) for part in session.subject.body.parts]
    without = session.changed({"body": session.subject.body.replaced(bare)})
    assert without.subject.body != session.subject.body
    assert setup_hash(without) == setup_hash(session)


TILTED_UP = np.array([0.2, -0.9, 0.4])


def root_at(lean: float, turn: float, tilt: float, up: Array) -> Array:
    """The root's rotation (3, 3) with these angles in its fields."""
    i = PERSON.index("waist")
    pose = with_angles(SKELETON, standing(PERSON), "waist", lean, turn, tilt, up_camera=up)
    np.testing.assert_allclose(angles_deg(SKELETON, pose, up)[i], [lean, turn, tilt], atol=1e-9)
    return pose.Rs_parent_part[i]


@pytest.mark.parametrize("up", [np.array([0.0, -1.0, 0.0]), TILTED_UP])
def test_a_turn_of_the_root_turns_the_body_about_what_is_up(up: Array) -> None:
    turned = root_at(12.0, 40.0, -7.0, up) @ root_at(12.0, 15.0, -7.0, up).T
    expected = np.radians(-25.0) * up / np.linalg.norm(up)  # a turn about y, which is down
    np.testing.assert_allclose(log_rotation(turned), expected, atol=1e-9)


@pytest.mark.parametrize("up", [np.array([0.0, -1.0, 0.0]), TILTED_UP])
def test_somebody_who_turns_round_and_round_keeps_lean_and_tilt(up: Array) -> None:
    wanted = np.array([[8.0, turn, -3.0] for turn in range(-170, 740, 10)], dtype=float)
    Rs = np.stack([root_at(8.0, math.remainder(turn, 360.0), -3.0, up) for _, turn, _ in wanted])
    shown = angle_curve_deg(PERSON.parts[0], Rs, NO_KEYS, up)
    np.testing.assert_allclose(shown, wanted, atol=1e-6)


def test_somebody_who_goes_head_over_heels_leans_round_and_nothing_else() -> None:
    wanted = np.array([[lean, 30.0, 4.0] for lean in range(0, 720, 10)], dtype=float)
    Rs = [from_heading_first(rotation_of(np.array([x, -4.0, 30.0])), TILTED_UP) for x, *_ in wanted]
    shown = angle_curve_deg(PERSON.parts[0], np.stack(Rs), NO_KEYS, TILTED_UP)
    np.testing.assert_allclose(shown, wanted, atol=1e-6)


@pytest.mark.parametrize("name", PERSON.names)
def test_one_part_alone_is_reported_as_it_is_among_the_others(name: str) -> None:
    i, pose = PERSON.index(name), walking()
    alone = angle_curve_deg(PERSON.parts[i], pose.Rs_parent_part[i][None], NO_KEYS)
    np.testing.assert_allclose(alone[0], angles_deg(SKELETON, pose)[i], atol=1e-9)


def test_the_curve_is_that_of_the_keyframe_most_clearly_upright() -> None:
    # who lies nearly on one side, where lean and turn swing far together
    wanted = np.array([[k - 140.0, k - 140.0, 84.0] for k in range(140)])
    inner = [rotation_of(np.array([lean, -tilt, turn])) for lean, turn, tilt in wanted]
    Rs = from_heading_first(np.stack(inner), TILTED_UP)
    root = PERSON.parts[0]
    assert angle_curve_deg(root, Rs[:1], NO_KEYS, TILTED_UP)[0, 0] == pytest.approx(40)
    shown = angle_curve_deg(root, Rs, np.array([0, 139]), TILTED_UP)
    np.testing.assert_allclose(shown, wanted, atol=1e-6)
