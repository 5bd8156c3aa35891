"""Fit here: a rough keyframe goes where the picture shows the body, and nowhere else."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest

from keypose.tracker.body.body import ALL_DOFS, Body, Part
from keypose.tracker.body.pose import Pose, joint_positions, moved, pose_transforms
from keypose.tracker.body.shapes import Box, Cylinder
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.pose import PictureFit, fit_pose_to_picture
from keypose.tracker.fitting.pose.messages import Moves, describe_moves
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.session.settings import IgnoreMask
from tests.rendering.render import render
from tests.rendering.settings import RenderSettings
from tests.tracker.tracking_cases import CAMERA, SMALL, Case, MemoryVideo, case

HERE = 8
NEAR = (0, 16)


@pytest.fixture(scope="module")
def person() -> Case:
    return case("speech", 40, 56)


@pytest.fixture(scope="module")
def box() -> Case:
    return case("tumbling_box", 10, 26)


def rough(shown: Case, frame: int, seed: int, size: float = 1.0) -> Pose:
    """The truth as a hand would pose it: off by 3° at every joint and 1.5 cm at the hips."""
    turns = shown.skeleton.dof_turns == 1
    sigma = np.where(turns, np.radians(3.0), 0.015)
    motion = size * sigma * np.random.default_rng(seed).normal(size=len(sigma))
    return moved(shown.skeleton, shown.truth.pose(frame), motion)


def fitted(shown: Case, pose: Pose, others: Any = None, **more: Any) -> PictureFit:
    """PictureFit at HERE; the other keyframes are the truth unless they are given."""
    keyposes = {k: shown.truth.pose(k) for k in NEAR} if others is None else others
    given = {"tracked": {}, **more}
    video: Any = MemoryVideo(given.pop("pictures", shown.pictures))
    return fit_pose_to_picture(video, shown.camera, shown.skeleton, HERE, pose, keyposes, **given)


def off_px(shown: Case, pose: Pose, frame: int = HERE) -> float:
    """Mean distance of the joints from the truth in the picture."""
    uv = [
        shown.camera.project(joint_positions(shown.skeleton, pose_transforms(shown.skeleton, p)))
        for p in (pose, shown.truth.pose(frame))
    ]
    return float(np.linalg.norm(uv[0] - uv[1], axis=-1).mean())


def assert_same(a: Pose, b: Pose) -> None:
    np.testing.assert_array_equal(a.Rs_parent_part, b.Rs_parent_part)
    np.testing.assert_array_equal(a.p_camera_root, b.p_camera_root)


class Detector:
    """Sees the joints where they truly are, give or take a share of the body's height."""

    def __init__(self, shown: Case, off_px: float) -> None:
        self.shown, self.off_px = shown, off_px

    def at(self, frame: int, skeleton: Skeleton, pose: Pose) -> Keypoints:
        _, parts, points = points_on_body(skeleton.body, JOINTS)
        T = pose_transforms(skeleton, self.shown.truth.pose(frame))[parts]
        p = (T[:, :3, :3] @ points[..., None])[..., 0] + T[:, :3, 3]
        off = np.random.default_rng(frame).normal(0.0, self.off_px, (len(parts), 2))
        uv = self.shown.camera.project(p) + off
        return Keypoints(frame, JOINTS, uv[None], np.ones((1, len(parts))))


def test_a_pose_that_is_clearly_wrong_goes_where_its_joints_are_seen(person: Case) -> None:
    pose = rough(person, HERE, 1, 3.0)
    found = fitted(person, pose, {}, source=Detector(person, 0.5))
    assert found.way == "joints"
    assert off_px(person, found.pose) < 0.4 * off_px(person, pose)


def test_a_slightly_wrong_pose_goes_where_joints_are_seen_if_its_outline_says_so_too(
    person: Case,
) -> None:
    pose = rough(person, HERE, 1, 0.9)
    found = fitted(person, pose, {}, source=Detector(person, 1.0))
    assert found.way == "joints"
    assert off_px(person, found.pose) < 0.5 * off_px(person, pose)


@pytest.mark.parametrize("off", [1.5, 3.5])
def test_a_right_pose_stays_though_a_detector_sees_its_joints_elsewhere(
    person: Case, off: float
) -> None:
    pose = person.truth.pose(HERE)
    found = fitted(person, pose, {}, source=Detector(person, off))
    assert found.way == "nothing"
    assert_same(found.pose, pose)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_rough_pose_between_exact_keyframes_is_brought_to_the_truth(
    person: Case, seed: int
) -> None:
    pose = rough(person, HERE, seed)
    found = fitted(person, pose)
    assert off_px(person, pose) > 2.0
    assert off_px(person, found.pose) < 0.2
    assert found.way == "neighbours"
    assert "moved" in found.message


def test_a_rough_pose_between_rough_keyframes_comes_much_nearer(person: Case) -> None:
    pose = rough(person, HERE, 1)
    others = {k: rough(person, k, 20 + k) for k in NEAR}
    found = fitted(person, pose, others)
    assert off_px(person, found.pose) < 0.6 * off_px(person, pose)


def test_a_correct_pose_hardly_moves(person: Case) -> None:
    found = fitted(person, person.truth.pose(HERE))
    assert off_px(person, found.pose) < 0.5


def test_tracked_frames_beside_it_are_enough(person: Case) -> None:
    pose = rough(person, HERE, 3)
    tracked = {k: person.truth.pose(k) for k in range(2, 15)}
    found = fitted(person, pose, {}, tracked=tracked)
    assert found.way == "neighbours"
    assert off_px(person, found.pose) < 0.2


def test_tracking_that_was_led_through_the_keyframe_does_not_hold_it_there(person: Case) -> None:
    """Its poses beside the keyframe are just as wrong, and agree with it."""
    pose = rough(person, HERE, 1)
    motion = rough(person, HERE, 1), person.truth.pose(HERE)
    leaning = {}
    for k in range(2, 15):
        turn = np.swapaxes(motion[1].Rs_parent_part, -1, -2) @ motion[0].Rs_parent_part
        shift = motion[0].p_camera_root - motion[1].p_camera_root
        true = person.truth.pose(k)
        leaning[k] = Pose(true.Rs_parent_part @ turn, true.p_camera_root + shift)
    leaning[HERE] = pose
    found = fitted(person, pose, tracked=leaning)
    assert off_px(person, found.pose) < 0.2


def test_a_limb_that_was_tracked_somewhere_else_is_not_taken_from_tracking(person: Case) -> None:
    """The person has just posed it: that is why the keyframe is there."""
    pose = rough(person, HERE, 4, 0.5)
    arm = person.skeleton.body.index("right_upper_arm")
    tracked = {}
    for k in range(2, 15):
        Rs = person.truth.pose(k).Rs_parent_part.copy()
        Rs[arm] = Rs[arm] @ exp_rotation([0.6, 0.0, 0.0])
        tracked[k] = Pose(Rs, person.truth.pose(k).p_camera_root)
    found = fitted(person, pose, {}, tracked=tracked)
    turn = found.pose.Rs_parent_part[arm].T @ person.truth.pose(HERE).Rs_parent_part[arm]
    assert np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1)) < np.radians(8.0)
    assert off_px(person, found.pose) < off_px(person, pose)


def test_without_anything_near_the_outline_decides(person: Case) -> None:
    pose = rough(person, HERE, 1)
    found = fitted(person, pose, {})
    assert found.way == "outline"
    assert off_px(person, found.pose) < 0.6 * off_px(person, pose)


def test_what_is_not_tracked_stays_as_it_was_posed(person: Case) -> None:
    pose = rough(person, HERE, 1)
    found = fitted(person, pose)
    names = person.skeleton.body.names
    for name in ("left_hand", "right_hand", "left_foot", "right_foot", "neck"):
        i = names.index(name)
        np.testing.assert_array_equal(found.pose.Rs_parent_part[i], pose.Rs_parent_part[i])
        assert found.decided[i] == 0


def test_what_moved_is_reported_in_pixels_of_the_video(person: Case) -> None:
    pose = rough(person, HERE, 1)
    found = fitted(person, pose)
    assert found.moved_px.shape == found.decided.shape == (person.skeleton.part_count,)
    assert found.decided.min() >= 0.0
    assert found.decided.max() <= 1.0
    spoken = re.match(r"(.+) moved (\d+) px", found.message)
    assert spoken is not None
    part = person.skeleton.body.index(spoken[1].lower().replace(" ", "_"))
    uv = [
        person.camera.project(pose_transforms(person.skeleton, p)[part, :3, 3])
        for p in (pose, found.pose)
    ]
    assert int(spoken[2]) == pytest.approx(found.moved_px[part], abs=0.51)
    assert np.linalg.norm(uv[1] - uv[0]) < 3 * found.moved_px[part] + 1


@pytest.mark.parametrize("value", [0, 128])
def test_a_featureless_picture_leaves_the_pose_and_says_so(person: Case, value: int) -> None:
    pose = rough(person, HERE, 1)
    found = fitted(person, pose, pictures=np.full_like(person.pictures, value))
    assert_same(found.pose, pose)
    assert found.way == "nothing"
    assert "unchanged" in found.message
    assert not found.moved_px.any()


def test_without_neighbours_and_without_colour_the_pose_stays(person: Case) -> None:
    noise = np.random.default_rng(0).integers(0, 255, person.pictures.shape, dtype=np.uint8)
    pose = rough(person, HERE, 1)
    found = fitted(person, pose, {}, pictures=noise)
    assert_same(found.pose, pose)
    assert "unchanged" in found.message


def test_pixels_under_a_mask_have_no_say(person: Case) -> None:
    pose = rough(person, HERE, 1)
    mask = IgnoreMask(
        polygon=((100, 0), (150, 0), (150, 179), (100, 179)), first_frame=0, last_frame=16
    )
    found = []
    for value in (0, 255):
        pictures = person.pictures.copy()
        pictures[:, :, 100:151] = value
        found.append(fitted(person, pose, masks=(mask,), pictures=pictures))
    assert_same(found[0].pose, found[1].pose)
    assert not np.array_equal(found[0].pose.p_camera_root, pose.p_camera_root)


def test_a_picture_that_is_masked_throughout_leaves_the_pose(person: Case) -> None:
    pose = rough(person, HERE, 1)
    corners = ((-5, -5), (400, -5), (400, 300), (-5, 300))
    mask = IgnoreMask(polygon=corners, first_frame=0, last_frame=16)
    found = fitted(person, pose, masks=(mask,))
    assert_same(found.pose, pose)
    assert found.way == "nothing"


def test_a_frame_that_cannot_be_decoded_leaves_the_pose(person: Case) -> None:
    pose = rough(person, HERE, 1)
    video: Any = MemoryVideo(person.pictures, missing=(HERE,))
    keyposes = {k: person.truth.pose(k) for k in NEAR}
    found = fit_pose_to_picture(video, person.camera, person.skeleton, HERE, pose, keyposes, {})
    assert_same(found.pose, pose)


def test_the_same_comes_out_every_time(person: Case) -> None:
    pose = rough(person, HERE, 2)
    one, two = fitted(person, pose), fitted(person, pose)
    assert_same(one.pose, two.pose)
    assert one.message == two.message


def test_it_can_be_stopped_at_any_moment(person: Case) -> None:
    pose = rough(person, HERE, 1)
    asked = iter(range(10**6))
    found = fitted(person, pose, cancelled=lambda: next(asked) >= 7)
    assert_same(found.pose, pose)
    assert found.way == "nothing"
    assert next(asked) < 40


def test_a_body_of_one_part_is_fitted(box: Case) -> None:
    pose = rough(box, HERE, 1)
    found = fitted(box, pose)
    assert off_px(box, found.pose) < 0.15 * off_px(box, pose)


def test_before_a_telephoto_camera_depth_stays_as_posed() -> None:
    shown = case("tumbling_box", 10, 26, telephoto=True)
    pose = rough(shown, HERE, 1)
    found = fitted(shown, pose)
    assert off_px(shown, found.pose) < 0.3 * off_px(shown, pose)
    assert found.pose.p_camera_root[2] == pytest.approx(pose.p_camera_root[2], abs=2e-3)


def test_a_hidden_limb_stays_as_it_was_posed() -> None:
    shown = hiding()
    pose = rough(shown, HERE, 5)
    found = fitted(shown, pose)
    np.testing.assert_array_equal(found.pose.Rs_parent_part[1], pose.Rs_parent_part[1])
    assert found.decided[1] == 0
    assert found.decided[0] > 0.5
    assert "Stick is hidden and was left unchanged." in found.message


def hiding() -> Case:
    """A box that turns a little before the camera, with a stick behind it."""
    wall = Part(
        name="wall", shape=Box(low_m=(-0.4, -0.3, -0.05), high_m=(0.4, 0.3, 0.05)), tracked=ALL_DOFS
    )
    stick = Part(
        name="stick", parent="wall", joint_m=(0.0, -0.1, 0.3),
        shape=Cylinder(end_m=0.2, radius_m=0.03), tracked=("rx", "rz"),
    )  # fmt: skip
    skeleton = Skeleton.of(Body(name="hiding", parts=(wall, stick)))
    s = np.linspace(-1, 1, 17)
    Rs = np.tile(np.eye(3), (17, 2, 1, 1))
    Rs[:, 0] = exp_rotation(np.stack([0.1 * s, 0.15 * s, 0.05 * s], axis=1))
    ps = np.stack([0.05 * s, 0.02 * s, np.full(17, 2.5)], axis=1)
    truth = Trajectory(0, Rs, ps)
    camera = CAMERA.model_copy(update={"width": SMALL[0], "height": SMALL[1], "cx": 160, "cy": 90})
    return Case(skeleton, camera, truth, render(skeleton, truth, camera, RenderSettings()))


def test_a_body_without_tracked_motions_stays(box: Case) -> None:
    part = box.skeleton.body.parts[0].model_copy(update={"tracked": ()})
    still = replace(box, skeleton=Skeleton.of(Body(name="still", parts=(part,))))
    pose = box.truth.pose(HERE)
    found = fitted(still, pose)
    assert_same(found.pose, pose)
    assert "unchanged" in found.message


def test_a_part_that_is_hidden_is_not_reported_to_have_moved() -> None:
    names = ("chest", "left_forearm", "right_shin")
    hidden = np.array([False, True, False])
    moves = Moves(
        names, np.array([4.2, 9.0, 6.1]), np.array([0.9, 0.0, 0.8]), np.ones(3, bool), hidden
    )
    assert describe_moves(moves) == (
        "Right shin moved 6 px, chest 4 px. Left forearm is hidden and was left unchanged."
    )


def test_where_nothing_moved_it_says_so() -> None:
    still = np.zeros(2, bool)
    moves = Moves(("chest", "head"), np.array([0.2, 0.4]), np.ones(2), ~still, still)
    assert describe_moves(moves) == "No part moved by more than a pixel."


def test_a_camera_that_zoomed_since_the_keyframes_beside_it_shows_the_same_pose(
    person: Case,
) -> None:
    zoom = np.ones(len(person.pictures))
    zoom[HERE] = 1.2
    path = CameraPath(np.tile(np.eye(4), (len(zoom), 1, 1)), zoom)
    camera, pictures = person.camera, person.pictures.copy()
    K = camera.K.copy()
    K[:2, :2] *= zoom[HERE]
    height, width = pictures.shape[1:3]
    pictures[HERE] = cv2.warpPerspective(
        pictures[HERE], K @ np.linalg.inv(camera.K), (width, height), flags=cv2.INTER_CUBIC
    )
    pose, steady = rough(person, HERE, 1), SteadyCamera.at_one_focal(camera, path)
    found = fitted(person, pose, pictures=pictures, steady=steady)
    assert off_px(person, found.pose) < 0.5
    assert found.way == "neighbours"
