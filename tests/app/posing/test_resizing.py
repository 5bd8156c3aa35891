"""Sizes by number and on the picture."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from keypose.app.posing import drag, part_sizes, with_height, with_joint, with_size
from keypose.tracker.body.body import Body
from keypose.tracker.body.modify import height, with_clavicles
from keypose.tracker.errors import BodyError
from tests.app.posing.posing_cases import (
    ARMS,
    BOX,
    DOG,
    PERSON,
    difference,
    gesture,
    points,
    rotations,
    sights,
    standing,
    walking,
)

BODIES = (PERSON, DOG, ARMS, BOX)


def sizes(body: Body, part: str) -> dict[str, float]:
    return {size.key: size.cm for size in part_sizes(body, part)}


@pytest.mark.parametrize("body", BODIES, ids=lambda body: body.name)
def test_every_size_of_every_part_can_be_set_and_changes_no_other(body: Body) -> None:
    for part in body.names:
        before = sizes(body, part)
        for size in part_sizes(body, part):
            assert size.min <= size.cm <= size.max
            cm = 1.3 * size.cm
            after = sizes(with_size(body, part, size.key, cm), part)
            for key in before:
                assert after[key] == pytest.approx(cm if key == size.key else before[key])


@pytest.mark.parametrize("body", BODIES, ids=lambda body: body.name)
@given(st.floats(0.4, 2.5))
def test_a_size_set_there_and_back_restores_the_body(body: Body, factor: float) -> None:
    for part in body.names[:4]:
        for key, cm in sizes(body, part).items():
            there = with_size(body, part, key, factor * cm)
            back = with_size(there, part, key, cm)
            for one, other in zip(back.parts, body.parts, strict=True):
                np.testing.assert_allclose(one.joint_m, other.joint_m, atol=1e-9)
                for mark, point in one.landmarks.items():
                    np.testing.assert_allclose(point, other.landmarks[mark], atol=1e-9)


def test_a_longer_thigh_carries_the_shin_along_on_both_sides_or_on_one() -> None:
    cm = sizes(PERSON, "left_thigh")["length"]
    both = with_size(PERSON, "left_thigh", "length", cm + 10)
    one = with_size(PERSON, "left_thigh", "length", cm + 10, linked=False)
    rest, longer = points(PERSON, standing(PERSON)), points(both, standing(PERSON))
    down = longer["left_foot"] - rest["left_foot"]
    np.testing.assert_allclose(down, [0, 0.10, 0], atol=1e-9)
    np.testing.assert_allclose(longer["right_foot"] - rest["right_foot"], down, atol=1e-12)
    assert points(one, standing(PERSON))["right_foot"] == pytest.approx(rest["right_foot"])
    assert sizes(both, "right_thigh")["length"] == pytest.approx(cm + 10)


def test_broader_shoulders_carry_the_arms_outward_and_leave_the_waist() -> None:
    before = sizes(PERSON, "chest")
    broad = with_size(PERSON, "chest", "end_width", 1.2 * before["end_width"])
    arm, was = (b.parts[b.index("left_upper_arm")].joint_m for b in (broad, PERSON))
    assert 1.1 * was[0] < arm[0] < 1.2 * was[0] + 1e-9
    assert arm[1:] == pytest.approx(was[1:])
    assert broad.parts[broad.index("neck")].joint_m == PERSON.parts[2].joint_m
    mirror = broad.parts[broad.index("right_upper_arm")].joint_m
    assert mirror == pytest.approx((-arm[0], arm[1], arm[2]))


def test_labels_say_where_a_size_is() -> None:
    labels = [size.label for size in part_sizes(PERSON, "right_forearm")]
    assert labels == ["Length", "Width at elbow", "Width at wrist"]
    assert [size.label for size in part_sizes(PERSON, "left_hand")] == [
        *("Length", "Depth", "Width"),
    ]
    assert [size.label for size in part_sizes(BOX, "box")] == ["Length", "Width", "Depth"]
    assert "Width at shoulders" in [size.label for size in part_sizes(PERSON, "chest")]


@pytest.mark.parametrize("part", ["left_forearm", "left_shin", "neck", "chest", "head"])
def test_a_width_is_how_far_a_part_is_across_whatever_its_shape(part: str) -> None:
    shape = PERSON.parts[PERSON.index(part)].shape
    across = [size for size in part_sizes(PERSON, part) if size.role == "width"]
    assert across
    for size in across:
        assert size.label.startswith("Width")
        assert size.cm == pytest.approx(200 * shape.half_widths(size.at_m[1])[0])


@pytest.mark.parametrize("cm", [0.0, -3.0, 0.1, 2000.0, math.nan, math.inf])
def test_a_size_out_of_bounds_is_refused_in_a_plain_sentence(cm: float) -> None:
    with pytest.raises(BodyError, match=r"^The size must lie between 0.2 and 1000 cm\.$"):
        with_size(PERSON, "chest", "length", cm)
    with pytest.raises(BodyError, match=r"^The height must lie between"):
        with_height(PERSON, 1e6 if math.isfinite(cm) else cm)
    with pytest.raises(BodyError, match=r"has no size 'girth'; its sizes are length, "):
        with_size(PERSON, "chest", "girth", 10)
    with pytest.raises(BodyError, match=r"^The joint's place must lie between"):
        with_joint(PERSON, "head", (0.0, math.nan, 0.0))


def test_height_and_joints_are_given_in_centimetres() -> None:
    assert height(with_height(PERSON, 150.0)) == pytest.approx(1.5)
    body = with_joint(PERSON, "left_upper_arm", (25.0, -30.0, 1.0))
    assert body.parts[body.index("left_upper_arm")].joint_m == pytest.approx((0.25, -0.30, 0.01))
    assert body.parts[body.index("right_upper_arm")].joint_m == pytest.approx((-0.25, -0.30, 0.01))


def pulled(part: str, key: str, direction: np.ndarray, metres: float, **more: object) -> Body:
    """A size handle dragged on the picture along a direction of space, from beside the joint."""
    pose, view = walking(), sights()["front"]
    p = points(PERSON, pose)[part]
    start = p + 0.05 * direction
    ends = view.project(start), view.project(start + metres * direction)
    sent = gesture("front", {"kind": "size", "part": part, "key": key}, *ends, **more)
    posed = drag(PERSON, pose, sent, sights())
    assert difference(posed.pose, pose) == 0
    assert posed.body is not None
    return posed.body


@pytest.mark.parametrize("part", ["left_thigh", "right_shin", "left_forearm", "chest"])
def test_an_end_cap_follows_the_pointer(part: str) -> None:
    down = rotations(PERSON, walking())[part][:, 1] * (-1 if part == "chest" else 1)
    longer = pulled(part, "length", down, 0.05)
    ends = [
        max(b.parts[b.index(part)].shape.mesh().vertices[:, 1] * (-1 if part == "chest" else 1))
        for b in (PERSON, longer)
    ]
    assert ends[1] - ends[0] == pytest.approx(0.05, abs=1e-6)


def test_a_rim_pulled_outward_makes_a_part_thicker_on_both_sides() -> None:
    along = rotations(PERSON, walking())["left_thigh"][:, 1]
    outward = np.array([-along[1], along[0], 0.0])
    outward /= np.linalg.norm(outward)
    for sign in (1, -1):
        body = pulled("left_thigh", "end_radius", sign * outward, 0.02)
        grown = sizes(body, "left_thigh")["end_radius"] - sizes(PERSON, "left_thigh")["end_radius"]
        assert grown == pytest.approx(4.0, abs=1e-6)  # how far it is across
        assert sizes(body, "right_thigh")["end_radius"] == sizes(body, "left_thigh")["end_radius"]
    thin = pulled("left_thigh", "end_radius", outward, -5.0)
    assert sizes(thin, "left_thigh")["end_radius"] == pytest.approx(0.2)


def test_a_joint_s_cross_takes_the_joint_to_the_pointer_and_mirrors_it() -> None:
    pose, view = walking(), sights()["main"]
    for part in ("left_upper_arm", "head"):
        p = points(PERSON, pose)[part]
        start = view.project(p)
        sent = gesture("main", {"kind": "size", "part": part, "key": "joint"}, start, start + 9)
        posed = drag(PERSON, pose, sent, sights())
        assert posed.body is not None
        np.testing.assert_allclose(view.project(points(posed.body, pose)[part]), start + 9)
        other = posed.body.parts[posed.body.index(PERSON.mirror_of(part))].joint_m
        x, y, z = posed.body.parts[posed.body.index(part)].joint_m
        assert other == pytest.approx((-x, y, z) if part != "head" else (x, y, z))


def test_snapping_changes_sizes_by_whole_centimetres() -> None:
    down = rotations(PERSON, walking())["left_thigh"][:, 1]
    longer = pulled("left_thigh", "length", down, 0.0234, snap=True)
    grown = sizes(longer, "left_thigh")["length"] - sizes(PERSON, "left_thigh")["length"]
    assert grown == pytest.approx(2.0)


def test_a_clavicle_is_as_long_as_it_reaches_sideways_and_carries_the_arm() -> None:
    body = with_clavicles(PERSON)
    sizes_of = {size.label: size for size in part_sizes(body, "left_clavicle")}
    assert set(sizes_of) == {"Length", "Height", "Depth"}
    assert sizes_of["Length"].role == "length"
    longer = with_size(body, "left_clavicle", "width", 1.2 * sizes_of["Length"].cm)
    for side in ("left", "right"):
        was, now = (b.parts[b.index(f"{side}_upper_arm")].joint_m[0] for b in (body, longer))
        assert now == pytest.approx(1.2 * was)
