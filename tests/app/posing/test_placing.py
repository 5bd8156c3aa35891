"""Where a body stands at first, what can be taken hold of, how parts are grouped."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.app.posing import handle_named, handles, lanes, opening_pose, up_from_vertical
from keypose.app.posing.handles import handle_at_far_end
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.modify import with_clavicles, without_part
from keypose.tracker.body.pose import joint_names, pose_transforms
from keypose.tracker.body.preset_names import PEOPLE
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import BodyError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import apply_transform
from tests.app.posing.posing_cases import ARMS, BOX, CAMERA, DOG, PERSON, TELEPHOTO, points, sights
from tests.tracker.tracking_cases import deep_chain, random_body

TALL = Camera(width=540, height=960, fx=840.0, fy=840.0, cx=256.0, cy=473.0)


def seen(body: Body, camera: Camera, up: tuple[float, float, float]) -> np.ndarray:
    pose = opening_pose(body, camera, up)
    Ts = pose_transforms(Skeleton.of(body), pose)
    corners = [
        apply_transform(T, part.shape.mesh().vertices)
        for T, part in zip(Ts, body.parts, strict=True)
    ]
    return sights(camera)["main"].project(np.concatenate(corners))


@pytest.mark.parametrize("camera", [CAMERA, TALL], ids=["wide", "tall"])
@pytest.mark.parametrize("name", PEOPLE)
def test_a_person_fills_seven_tenths_of_the_height_in_the_middle_of_the_picture(
    name: str, camera: Camera
) -> None:
    at = seen(preset(name), camera, (0.0, -1.0, 0.0))
    low, high = at.min(axis=0), at.max(axis=0)
    assert high[1] - low[1] == pytest.approx(0.7 * camera.height, rel=1e-3)
    middle = [(camera.width - 1) / 2, (camera.height - 1) / 2]
    np.testing.assert_allclose((low + high) / 2, middle, atol=0.01)


@pytest.mark.parametrize("body", [DOG, ARMS, BOX], ids=lambda body: body.name)
def test_other_bodies_are_wholly_in_the_picture_too(body: Body) -> None:
    at = seen(body, TALL, (0.0, -1.0, 0.0))
    assert (at > 0).all()
    assert (at < [TALL.width, TALL.height]).all()
    assert np.ptp(at, axis=0).max() > 0.6 * TALL.width


def test_the_body_stands_along_the_drawn_vertical() -> None:
    up = up_from_vertical(CAMERA, (CAMERA.cx, CAMERA.cy), (CAMERA.cx + 20, CAMERA.cy - 100))
    p = points(PERSON, opening_pose(PERSON, CAMERA, up))
    spine = p["neck"] - p["waist"]
    np.testing.assert_allclose(spine / np.linalg.norm(spine), up, atol=1e-12)
    assert p["left_upper_arm"][0] > p["right_upper_arm"][0]


def test_a_telephoto_camera_puts_the_body_at_the_distance_where_its_scale_holds() -> None:
    pose = opening_pose(PERSON, TELEPHOTO)
    assert pose.p_camera_root[2] == pytest.approx(TELEPHOTO.telephoto_distance_m)


def test_a_person_is_taken_by_body_head_hands_feet_and_the_joints_between() -> None:
    found = {handle.name: handle for handle in handles(PERSON)}
    assert [found[name].kind for name in ("root", "head", "left_hand", "left_knee")] == [
        *("root", "head", "end"),
        "middle",
    ]
    assert len(found) == 2 + 4 + 4 + 4
    assert (found["left_hip"].kind, found["left_hip"].anchor) == ("corner", "left_thigh")
    assert found["left_shoulder"].movers == ("waist", "chest", "neck", "head")
    assert found["right_elbow"].label == "Right elbow"
    assert found["right_elbow"].anchor == "right_forearm"
    assert found["left_foot"].movers == ("left_thigh", "left_shin")
    assert found["head"].limb == ("chest", "neck", "head")
    with pytest.raises(BodyError, match=r"no handle 'tail'; its handles are root, head, .*\.$"):
        handle_named(PERSON, "tail")


@pytest.mark.parametrize(
    "body",
    [
        *(PERSON, DOG, ARMS, BOX, deep_chain().body, *(random_body(k, 9).body for k in range(6))),
        *(without_part(with_clavicles(PERSON), name) for name in PERSON.names[1:]),
    ],
    ids=lambda body: f"{body.name} of {len(body.parts)}",
)
def test_every_handle_stands_at_a_point_of_the_body_and_has_a_name_of_its_own(body: Body) -> None:
    known = joint_names(Skeleton.of(body))
    found = handles(body)
    assert len({handle.name for handle in found}) == len(found)
    for handle in found:
        assert handle.anchor in known
        assert handle.movers
        assert set(handle.movers) <= set(body.names)
        assert handle.part in handle.limb
    groups = [part for _, parts in lanes(body) for part in parts]
    assert sorted(groups) == sorted(body.names)


def test_a_dog_is_taken_by_its_paws_its_tail_and_its_nose() -> None:
    found = {handle.label: handle for handle in handles(DOG)}
    assert {"Left front paw", "Right hind paw", "Tail tip", "Head"} <= set(found)
    assert found["Head"].anchor == "nose"
    assert [label for label, _ in lanes(DOG)][:4] == [
        *("Trunk", "Neck and head", "Tail", "Left front leg"),
    ]
    assert len(handles(BOX)) == 1


def test_the_far_end_of_a_part_is_the_handle_that_its_surface_pulls() -> None:
    names = {
        part: (found.name if (found := handle_at_far_end(PERSON, part)) else None)
        for part in ("left_upper_arm", "left_forearm", "left_hand", "right_thigh", "chest", "head")
    }
    assert names == {
        "left_upper_arm": "left_elbow",
        "left_forearm": "left_hand",
        "left_hand": "left_hand",
        "right_thigh": "right_knee",
        "chest": "head",
        "head": "head",
    }


def test_the_person_s_groups_are_trunk_arms_and_legs() -> None:
    assert [label for label, _ in lanes(PERSON)] == [
        *("Trunk", "Right arm", "Left arm", "Right leg", "Left leg"),
    ]
    assert dict(lanes(PERSON))["Right arm"] == ("right_upper_arm", "right_forearm", "right_hand")


def test_a_shoulder_that_moves_is_a_handle_and_arms_stay_two_bones() -> None:
    body = with_clavicles(PERSON)
    found = {handle.name: handle for handle in handles(body)}
    assert set(found) == {handle.name for handle in handles(PERSON)}
    for handle in handles(PERSON):
        if not handle.name.endswith("shoulder"):
            assert found[handle.name].movers == handle.movers, handle.name
    shoulder = found["left_shoulder"]
    assert shoulder.movers == ("left_clavicle",)
    assert (shoulder.anchor, shoulder.label) == ("left_upper_arm", "Left shoulder")
    assert handle_at_far_end(body, "left_clavicle") == shoulder
    assert dict(lanes(body))["Right arm"][0] == "right_clavicle"
