"""Parts of every shape are taken hold of, sized and picked alike."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from keypose.app.posing import drag, outline, part_sizes, parts_at, with_shape, with_size
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.shapes import KINDS, Solid
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import BodyError
from tests.app.posing.posing_cases import ARMS, BOX, DOG, PERSON, gesture, points, sights
from tests.tracker.shape_cases import SHAPES, every_shape, pair_of

STEP_M = 0.02


def before_the_camera(body: Body) -> Pose:
    return Pose.rest(Skeleton.of(body), (0.1, 0.0, 4.0))


def dragged(body: Body, part: str, key: str, start: np.ndarray, way_m: np.ndarray) -> Body:
    """A size's handle pulled along a direction of the camera frame, in the front view."""
    view = sights()["front"]
    ends = view.project(start), view.project(start + way_m)
    sent = gesture("front", {"kind": "size", "part": part, "key": key}, *ends)
    posed = drag(body, before_the_camera(body), sent, sights())
    assert posed.body is not None
    return posed.body


@every_shape
def test_the_handle_of_a_length_takes_the_end_along_with_the_pointer(shape: Solid) -> None:
    body = pair_of(shape)
    (length, *_) = shape.sizes()
    joint = points(body, before_the_camera(body))["left_limb"]
    way = STEP_M * np.sign(length.p_part[1])
    longer = dragged(body, "left_limb", "length", joint + length.p_part, np.array([0.0, way, 0.0]))
    for part in longer.parts[1:]:
        (changed, *_) = part.shape.sizes()
        moved = np.array(changed.p_part) - length.p_part
        np.testing.assert_allclose(moved, [0.0, way, 0.0], atol=1e-6)
    assert longer.parts[0].shape == shape


@every_shape
def test_every_other_handle_takes_its_side_of_the_surface_along(shape: Solid) -> None:
    body = pair_of(shape)
    joint = points(body, before_the_camera(body))["left_limb"]
    outward = np.array([STEP_M, 0.0, 0.0])
    for size in shape.sizes()[1:]:
        start = joint + np.array([0.05, size.p_part[1], 0.0])
        wider = dragged(body, "left_limb", size.key, start, outward)
        (changed,) = (s for s in wider.parts[1].shape.sizes() if s.key == size.key)
        both_sides = 1 if size.key.endswith("radius") else 2
        assert changed.metres - size.metres == pytest.approx(both_sides * STEP_M, abs=1e-6)


@every_shape
def test_landmarks_at_its_end_stay_there_whatever_size_is_set(shape: Solid) -> None:
    body = pair_of(shape)
    for size in part_sizes(body, "left_limb"):
        for cm in (0.9 * size.cm, 1.1 * size.cm):
            part = with_size(body, "left_limb", size.key, cm).parts[1]
            np.testing.assert_allclose(part.landmarks["left_tip"], part.shape.far_end, atol=1e-9)


@every_shape
def test_it_is_picked_where_its_outline_says(shape: Solid) -> None:
    body = pair_of(shape)
    skeleton, pose = Skeleton.of(body), before_the_camera(body)
    for view, sight in sights().items():
        corners = outline(skeleton, pose, sight, "left_limb")
        low, high = corners.min(axis=0), corners.max(axis=0)
        for share in np.random.default_rng(2).uniform(-0.2, 1.2, (30, 2)):
            at = low + share * (high - low)
            side = cv2.pointPolygonTest(corners.astype(np.float32), at.tolist(), True)
            if abs(side) > 1e-3 * np.abs(high - low).max():
                found = "left_limb" in parts_at(skeleton, pose, sight, at)
                assert found == (side > 0), view


@every_shape
@pytest.mark.parametrize("kind", KINDS)
def test_another_shape_is_chosen_for_both_sides_and_joints_stay(shape: Solid, kind: str) -> None:
    body = pair_of(shape)
    changed = with_shape(body, "left_limb", kind)
    assert [part.shape.kind for part in changed.parts] == [shape.kind, kind, kind]
    assert [part.joint_m for part in changed.parts] == [part.joint_m for part in body.parts]
    assert with_shape(body, "left_limb", shape.kind) == body
    alone = with_shape(body, "left_limb", kind, linked=False)
    assert [part.shape.kind for part in alone.parts] == [shape.kind, kind, shape.kind]


def test_every_part_of_the_bodies_there_are_takes_every_shape() -> None:
    for body in (PERSON, DOG, ARMS, BOX):
        for kind in KINDS:
            for part in body.names:
                body = with_shape(body, part, kind)
            assert {part.shape.kind for part in body.parts} == {kind}


def test_a_shape_that_there_is_not_is_refused_by_name() -> None:
    with pytest.raises(BodyError, match="There is no shape 'egg'; the shapes are cylinder"):
        with_shape(PERSON, "head", "egg")


@pytest.mark.parametrize("body", [PERSON, DOG, ARMS, BOX], ids=lambda body: body.name)
def test_every_handle_of_the_bodies_there_are_is_on_its_part(body: Body) -> None:
    for part in body.parts:
        for size in part_sizes(body, part.name):
            assert part.shape.distance(np.array([size.at_m]))[0] < 1e-9


def test_a_size_that_the_other_side_does_not_have_is_refused_unless_it_is_left_alone() -> None:
    body = pair_of(SHAPES["cylinder"])
    body = body.with_part(body.parts[2].model_copy(update={"shape": SHAPES["frustum"]}))
    with pytest.raises(BodyError, match="Part 'right_limb' has no size 'radius'; its sizes are"):
        with_size(body, "left_limb", "radius", 9.0)
    alone = with_size(body, "left_limb", "radius", 9.0, linked=False)
    assert part_sizes(alone, "left_limb")[1].cm == pytest.approx(9.0)
    assert alone.parts[2] == body.parts[2]
