"""A box is posed by dragging its corners to where the picture shows them."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.app.posing import PlacedCorner, Posed, drag
from keypose.app.posing.resizing import part_sizes, with_size
from keypose.app.posing.vectors import unit
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import BodyError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import apply_transform, exp_rotation, log_rotation
from tests.app.posing.posing_cases import CAMERA, PERSON, TELEPHOTO, Floats, gesture, sights

BOX = preset("box")
FACES = {
    "left": (0, 1, 2, 3), "right": (4, 5, 6, 7), "bottom": (0, 1, 4, 5),
    "top": (2, 3, 6, 7), "front": (0, 2, 4, 6), "back": (1, 3, 5, 7),
}  # fmt: skip
every_face = pytest.mark.parametrize("face", FACES)


def corners_seen(pose: Pose, camera: Camera = CAMERA) -> Floats:
    """(8, 2) pixels."""
    corners = BOX.parts[0].shape.corners()
    assert corners is not None
    T = pose_transforms(Skeleton.of(BOX), pose)[0]
    return sights(camera)["main"].project(apply_transform(T, corners))


def shows(pose: Pose, face: str) -> bool:
    """Whether a side faces the camera by more than 20 degrees."""
    corners = BOX.parts[0].shape.corners()
    assert corners is not None
    T = pose_transforms(Skeleton.of(BOX), pose)[0]
    middle = apply_transform(T, corners[list(FACES[face])]).mean(axis=0)
    return bool(unit(middle) @ unit(middle - T[:3, 3]) < -np.sin(np.radians(20)))


def showing(face: str, rng: np.random.Generator) -> Pose:
    """A random pose in which that side is seen."""
    while True:
        place = np.array([rng.uniform(-0.2, 0.2), rng.uniform(-0.1, 0.1), rng.uniform(0.8, 1.5)])
        pose = Pose(exp_rotation(rng.normal(0, 2, (1, 3))), place)
        if shows(pose, face):
            return pose


def about(pose: Pose, rng: np.random.Generator, degrees: float) -> Pose:
    """A rough first pose: turned by so much about some axis, in the middle of the picture."""
    turn = exp_rotation(unit(rng.normal(size=3)) * np.radians(degrees))
    return Pose(pose.Rs_parent_part @ turn, np.array([0.0, 0.0, 1.2]))


def put(
    pose: Pose, index: int, at: Floats, placed: tuple[PlacedCorner, ...] = (), **more: bool
) -> Posed:
    """A corner dragged from where it is seen."""
    handle = {"kind": "box_corner", "part": "box", "index": index}
    sent = gesture("main", handle, corners_seen(pose)[index], at, **more)
    return drag(BOX, pose, sent, sights(), placed_corners=placed)


def put_all(pose: Pose, targets: dict[int, Floats]) -> Posed:
    """One after another."""
    placed: tuple[PlacedCorner, ...] = ()
    for index, at in targets.items():
        posed = put(pose, index, at, placed)
        pose, placed = posed.pose, posed.readout.corners
    return posed


def turned_deg(one: Pose, other: Pose) -> float:
    R = one.Rs_parent_part[0].T @ other.Rs_parent_part[0]
    return float(np.degrees(np.linalg.norm(log_rotation(R))))


def shifted_m(one: Pose, other: Pose) -> float:
    return float(np.linalg.norm(one.p_camera_root - other.p_camera_root))


@every_face
def test_four_corners_of_a_side_put_where_they_are_seen_give_the_pose(face: str) -> None:
    """With one pixel of noise: as well as the noise allows, and never its mirror image."""
    rng = np.random.default_rng(3)
    off = []
    for _ in range(6):
        truth = showing(face, rng)
        seen = corners_seen(truth) + rng.normal(0, 1.0, (8, 2))
        put_there = list(FACES[face])
        found = put_all(about(truth, rng, 25.0), {i: seen[i] for i in put_there}).pose
        missed = [np.linalg.norm((corners_seen(p) - seen)[put_there]) for p in (found, truth)]
        assert missed[0] <= missed[1]
        off.append((turned_deg(found, truth), shifted_m(found, truth)))
    assert (np.median(off, axis=0) < (2.0, 0.01)).all()
    assert (np.max(off, axis=0) < (10.0, 0.03)).all()


def test_the_first_corner_carries_the_box_across_the_picture() -> None:
    pose = about(showing("front", np.random.default_rng(1)), np.random.default_rng(2), 0.0)
    at = corners_seen(pose)[3] + (60.0, -40.0)
    found = put(pose, 3, at).pose
    np.testing.assert_allclose(corners_seen(found)[3], at, atol=0.1)
    assert turned_deg(found, pose) < 0.5
    assert abs(found.p_camera_root[2] / pose.p_camera_root[2] - 1) < 0.05


def test_the_second_turns_it_in_the_picture_and_brings_it_nearer() -> None:
    pose = Pose(np.eye(3)[None], np.array([0.0, 0.0, 1.5]))
    seen = corners_seen(pose)
    first = put(pose, 0, seen[0])
    found = put(first.pose, 6, seen[0] + 1.4 * (seen[6] - seen[0]), first.readout.corners).pose
    np.testing.assert_allclose(corners_seen(found)[0], seen[0], atol=0.1)
    assert found.p_camera_root[2] < 1.2
    assert turned_deg(found, pose) < 3.0


def test_corners_that_were_placed_stay_under_what_was_pointed_at() -> None:
    rng = np.random.default_rng(5)
    truth = showing("top", rng)
    seen = corners_seen(truth)
    posed = put_all(about(truth, rng, 20.0), {i: seen[i] for i in (2, 3, 6)})
    np.testing.assert_allclose(corners_seen(posed.pose)[[2, 3, 6]], seen[[2, 3, 6]], atol=0.1)
    assert [one.index for one in posed.readout.corners] == [2, 3, 6]
    again = put(posed.pose, 2, seen[2] + 5.0, posed.readout.corners)
    assert [one.index for one in again.readout.corners] == [3, 6, 2]
    np.testing.assert_allclose(corners_seen(again.pose)[[3, 6]], seen[[3, 6]], atol=0.1)


def test_with_alt_the_other_corners_are_let_go() -> None:
    pose = showing("top", np.random.default_rng(5))
    seen = corners_seen(pose)
    placed = put_all(pose, {i: seen[i] for i in (2, 3, 6)}).readout.corners
    found = put(pose, 7, seen[7] + (50.0, 0.0), placed, carry=True)
    assert [one.index for one in found.readout.corners] == [7]
    assert turned_deg(found.pose, pose) < 0.5


def test_a_side_seen_almost_from_the_front_does_not_jump_to_its_mirror_image() -> None:
    """Of both poses that explain the corners it is the one the drag comes from."""
    rng = np.random.default_rng(8)
    for degrees in (12.0, -12.0):
        truth = Pose(exp_rotation(np.radians([[0.0, degrees, 0.0]])), np.array([0.0, 0.0, 2.5]))
        seen = corners_seen(truth) + rng.normal(0, 1.0, (8, 2))
        posed = put_all(truth, {i: seen[i] for i in FACES["front"]})
        for way in np.linspace(0, 1.5, 7):
            moved = put(posed.pose, 6, seen[6] + (way, 0.0), posed.readout.corners)
            turn = log_rotation(moved.pose.Rs_parent_part[0])
            assert np.sign(turn[1]) == np.sign(degrees)


def test_a_first_pose_seen_from_the_wrong_side_is_mended_by_the_fourth_corner() -> None:
    truth = Pose(exp_rotation(np.radians([[20.0, 50.0, 0.0]])), np.array([0.0, 0.0, 0.7]))
    wrong = Pose(exp_rotation(np.radians([[-20.0, -50.0, 0.0]])), np.array([0.0, 0.0, 0.7]))
    seen = corners_seen(truth)
    found = put_all(wrong, {i: seen[i] for i in FACES["front"]}).pose
    assert turned_deg(found, truth) < 1.0


def test_parallel_rays_leave_the_distance_and_give_the_rest() -> None:
    truth = Pose(exp_rotation(np.radians([[20.0, 30.0, 10.0]])), np.array([0.1, 0.0, 5.0]))
    rough = Pose(exp_rotation(np.radians([[5.0, 10.0, 0.0]])), np.array([0.0, 0.0, 5.0]))
    seen = corners_seen(truth, TELEPHOTO)
    placed: tuple[PlacedCorner, ...] = ()
    for index in (0, 2, 4, 6, 7):
        handle = {"kind": "box_corner", "part": "box", "index": index}
        sent = gesture("main", handle, corners_seen(rough, TELEPHOTO)[index], seen[index])
        posed = drag(BOX, rough, sent, sights(TELEPHOTO), placed_corners=placed)
        rough, placed = posed.pose, posed.readout.corners
    assert turned_deg(rough, truth) < 1.0
    assert shifted_m(rough, truth) < 0.01


def test_a_box_that_hangs_on_a_joint_turns_about_it() -> None:
    part = next(p.name for p in PERSON.parts if p.shape.corners() is not None)
    pose = Pose.rest(Skeleton.of(PERSON), (0.0, 0.0, 4.0))
    handle = {"kind": "box_corner", "part": part, "index": 7}
    found = drag(PERSON, pose, gesture("main", handle, (0, 0), (4, 3)), sights()).pose
    still = [name != part for name in PERSON.names]
    np.testing.assert_array_equal(found.Rs_parent_part[still], pose.Rs_parent_part[still])
    np.testing.assert_array_equal(found.p_camera_root, pose.p_camera_root)
    assert not np.allclose(found.Rs_parent_part, pose.Rs_parent_part)


@pytest.mark.parametrize(
    ("body", "view", "part", "words"),
    [
        (BOX, "side", "box", "camera view"),
        (preset("cylinder"), "main", "cylinder", "no corners"),
        (BOX, "main", "lid", "lid"),
    ],
)
def test_where_there_is_no_corner_to_drag_that_is_said(body, view, part, words) -> None:
    pose = Pose.rest(Skeleton.of(body), (0.0, 0.0, 2.0))
    handle = {"kind": "box_corner", "part": part, "index": 0}
    with pytest.raises(BodyError, match=words):
        drag(body, pose, gesture(view, handle, (0, 0), (9, 9)), sights())


def with_sizes(body: Body, **cm: float) -> Body:
    for key, value in cm.items():
        body = with_size(body, "box", key, value, linked=False)
    return body


def seen_of(body: Body, pose: Pose) -> Floats:
    """(8, 2) pixels of a box with other sizes."""
    corners = body.parts[0].shape.corners()
    assert corners is not None
    T = pose_transforms(Skeleton.of(body), pose)[0]
    return sights()["main"].project(apply_transform(T, corners))


def put_six(body: Body, pose: Pose, seen: Floats, *, free_sizes: bool) -> tuple[Body, Pose]:
    """The corners of two sides, one after another."""
    placed: tuple[PlacedCorner, ...] = ()
    for index in (0, 2, 4, 6, 3, 7):
        handle = {"kind": "box_corner", "part": "box", "index": index}
        sent = gesture("main", handle, seen_of(body, pose)[index], seen[index])
        made = drag(body, pose, sent, sights(), placed_corners=placed, free_sizes=free_sizes)
        pose, placed, body = made.pose, made.readout.corners, made.body or body
    return body, pose


def proportions(body: Body) -> Floats:
    """(3,) of its edges, so that their product is 1."""
    edges = np.array([size.cm for size in part_sizes(body, "box")])
    return np.asarray(edges / np.exp(np.log(edges).mean()))


SEEN_FROM_ABOVE = Pose(exp_rotation(np.array([[0.6, 0.5, 0.1]])), np.array([0.05, 0.0, 1.0]))


def test_six_corners_fit_wrong_sizes_along_with_the_pose_and_keep_the_volume() -> None:
    rng = np.random.default_rng(3)
    true, guess = (
        with_sizes(BOX, width=w, length=h, depth=d) for w, h, d in ((20, 30, 25), (26, 25, 20))
    )
    seen = seen_of(true, SEEN_FROM_ABOVE) + rng.normal(0, 1.0, (8, 2))
    start = about(SEEN_FROM_ABOVE, rng, 15.0)
    body, pose = put_six(guess, start, seen, free_sizes=True)
    assert turned_deg(pose, SEEN_FROM_ABOVE) < 2.0
    np.testing.assert_allclose(proportions(body), proportions(true), rtol=0.04)
    volumes = [np.prod([size.cm for size in part_sizes(b, "box")]) for b in (body, guess)]
    np.testing.assert_allclose(*volumes, rtol=0.02)
    kept, tilted = put_six(guess, start, seen, free_sizes=False)
    assert kept == guess
    assert turned_deg(tilted, SEEN_FROM_ABOVE) > 2 * turned_deg(pose, SEEN_FROM_ABOVE)


def test_sizes_that_are_right_stay_to_the_last_digit() -> None:
    rng = np.random.default_rng(4)
    seen = seen_of(BOX, SEEN_FROM_ABOVE) + rng.normal(0, 1.0, (8, 2))
    body, _ = put_six(BOX, about(SEEN_FROM_ABOVE, rng, 15.0), seen, free_sizes=True)
    assert body == BOX
