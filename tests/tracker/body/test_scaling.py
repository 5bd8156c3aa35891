"""Sizes: whole bodies, single parts and joints, linked to the other side or not."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from keypose.tracker.body.body import Body, Part, Point, load_body, preset
from keypose.tracker.body.modify import height, joint_moved, resized, scaled, unscaled, with_height
from keypose.tracker.body.pose import Pose, joint_names, joint_positions, pose_transforms
from keypose.tracker.body.preset_names import PRESETS
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import BodyError

MALE = preset("adult_male")
EXAMPLES = sorted((Path(__file__).parents[3] / "sample_videos" / "bodies").glob("*.json"))
FACTORS = st.floats(0.3, 3.0)
steady = settings(derandomize=True, deadline=None, max_examples=25)


def part(body: Body, name: str) -> Part:
    return body.parts[body.index(name)]


def points(body: Body) -> dict[str, np.ndarray]:
    skeleton = Skeleton.of(body)
    Ts = pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))
    return dict(zip(joint_names(skeleton), joint_positions(skeleton, Ts), strict=True))


def extent(body: Body, name: str) -> np.ndarray:
    return np.ptp(part(body, name).shape.mesh().vertices, axis=0)


@steady
@given(st.sampled_from(PRESETS), FACTORS)
def test_scaling_multiplies_every_length_of_the_assembled_body(name: str, factor: float) -> None:
    body = preset(name)
    bigger = scaled(body, factor)
    assert height(bigger) == pytest.approx(factor * height(body))
    for mark, point in points(body).items():
        np.testing.assert_allclose(points(bigger)[mark], factor * point, atol=1e-12)
    for name in body.names:
        np.testing.assert_allclose(extent(bigger, name), factor * extent(body, name))


@steady
@given(FACTORS)
def test_scaling_there_and_back_restores_the_body(factor: float) -> None:
    back = scaled(scaled(MALE, factor), 1 / factor)
    for mark, point in points(MALE).items():
        np.testing.assert_allclose(points(back)[mark], point, atol=1e-12)


@steady
@given(st.floats(0.5, 2.5))
def test_a_body_takes_the_height_it_is_given(height_m: float) -> None:
    assert height(with_height(MALE, height_m)) == pytest.approx(height_m)


def test_the_height_of_a_box_is_its_extent_along_y() -> None:
    assert height(load_body(EXAMPLES[0])) == pytest.approx(0.44)


@steady
@given(FACTORS, FACTORS)
def test_a_longer_thigh_carries_shin_and_foot_along_on_both_sides(
    length: float, thickness: float
) -> None:
    before = points(MALE)
    body = resized(MALE, "left_thigh", length_factor=length, thickness_factor=thickness)
    after = points(body)
    for side in ("left", "right"):
        down = before[f"{side}_shin"] - before[f"{side}_thigh"]
        for name in (f"{side}_shin", f"{side}_foot", f"{side}_toe"):
            moved = after[name] - before[name]
            np.testing.assert_allclose(moved, (length - 1) * down, atol=1e-12)
        ratio = extent(body, f"{side}_thigh") / extent(MALE, f"{side}_thigh")
        np.testing.assert_allclose(ratio, [thickness, length, thickness])
    assert part(body, "chest") == part(MALE, "chest")
    assert part(body, "left_shin").shape == part(MALE, "left_shin").shape


def test_a_thicker_waist_moves_the_hips_outward_and_keeps_their_height() -> None:
    hip = part(resized(MALE, "waist", thickness_factor=1.2), "left_thigh").joint_m
    x, y, z = part(MALE, "left_thigh").joint_m
    assert hip == pytest.approx((1.2 * x, y, 1.2 * z))


def test_landmarks_and_boxes_grow_with_their_part() -> None:
    body = resized(MALE, "right_foot", length_factor=1.5, thickness_factor=2.0)
    x, y, z = part(MALE, "left_foot").landmarks["left_toe"]
    assert part(body, "left_foot").landmarks["left_toe"] == pytest.approx((2 * x, 1.5 * y, 2 * z))
    np.testing.assert_allclose(extent(body, "left_foot") / extent(MALE, "left_foot"), [2, 1.5, 2])


def test_the_neck_which_has_no_mirror_is_resized_alone() -> None:
    body = resized(MALE, "neck", length_factor=2.0, thickness_factor=1.5)
    np.testing.assert_allclose(extent(body, "neck") / extent(MALE, "neck"), [1.5, 2, 1.5])
    changed = [name for name in MALE.names if part(body, name) != part(MALE, name)]
    assert changed == ["neck", "head"]


def test_unlinked_the_other_side_stays_as_it_is() -> None:
    body = resized(MALE, "left_shin", length_factor=1.1, linked=False)
    assert part(body, "right_shin") == part(MALE, "right_shin")
    assert part(body, "right_foot") == part(MALE, "right_foot")
    assert part(body, "left_shin") != part(MALE, "left_shin")


def test_factors_of_one_change_nothing() -> None:
    assert resized(MALE, "chest") == MALE
    assert scaled(MALE, 1.0) == MALE


lengths = st.floats(-1, 1)


@steady
@given(st.tuples(lengths, lengths, lengths), st.booleans())
def test_a_moved_joint_is_mirrored_in_x_when_linked(joint: Point, linked: bool) -> None:
    body = joint_moved(MALE, "right_upper_arm", joint, linked=linked)
    x, y, z = joint
    assert part(body, "right_upper_arm").joint_m == joint
    other = (-x, y, z) if linked else part(MALE, "left_upper_arm").joint_m
    assert part(body, "left_upper_arm").joint_m == other
    assert part(body, "right_upper_arm").shape == part(MALE, "right_upper_arm").shape


def test_a_joint_on_the_midline_may_leave_it() -> None:
    assert part(joint_moved(MALE, "head", (0.1, -0.1, 0.0)), "head").joint_m == (0.1, -0.1, 0.0)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_the_example_bodies_can_be_sized_too(path: Path) -> None:
    body = load_body(path)
    assert height(with_height(body, 0.5)) == pytest.approx(0.5)
    longer = resized(body, body.parts[-1].name, length_factor=2.0)
    assert extent(longer, body.parts[-1].name)[1] == pytest.approx(
        2 * extent(body, body.parts[-1].name)[1]
    )


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf])
def test_a_ratio_that_is_no_number_above_zero_is_refused(bad: float) -> None:
    with pytest.raises(BodyError, match=r"The factor is .*; it must be a number above 0\."):
        scaled(MALE, bad)
    with pytest.raises(BodyError, match="height_m"):
        with_height(MALE, bad)
    with pytest.raises(BodyError, match="length_factor"):
        resized(MALE, "chest", length_factor=bad)
    with pytest.raises(BodyError, match="thickness_factor"):
        resized(MALE, "chest", thickness_factor=bad)


def test_what_the_body_model_forbids_is_refused_in_one_sentence() -> None:
    with pytest.raises(BodyError, match=r"^This size is not possible: .*\.$"):
        scaled(MALE, 1e6)
    with pytest.raises(BodyError, match=r"^This size is not possible: .*\.$"):
        joint_moved(MALE, "head", (math.nan, 0.0, 0.0))
    with pytest.raises(BodyError, match="'waist' is the root and has no joint"):
        joint_moved(MALE, "waist", (0.0, 0.0, 0.0))
    with pytest.raises(BodyError, match="no part 'wing'"):
        resized(MALE, "wing", length_factor=1.1)


@steady
@given(st.sampled_from(PRESETS), FACTORS, FACTORS)
def test_a_body_that_was_scaled_evenly_is_still_the_one_it_was(
    name: str, factor: float, again: float
) -> None:
    body = preset(name)
    assert unscaled(scaled(scaled(body, factor), again), map(preset, PRESETS)) == body


SIZED = {
    "one part longer": resized(MALE, "head", length_factor=1.01),
    "one joint moved": joint_moved(MALE, "head", (0.0, 0.21, 0.0)),
    "a preset of others": with_height(preset("box"), 1.7),
}


@pytest.mark.parametrize("sized", SIZED)
def test_a_body_whose_proportions_are_its_own_is_nobodys(sized: str) -> None:
    assert unscaled(with_height(SIZED[sized], 1.9), [MALE]) is None
