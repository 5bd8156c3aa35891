"""Errors against a reference: known displacements come out as what they are."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from keypose.tracker.body.pose import joint_names
from keypose.tracker.body.trajectory import Trajectory, interpolate, joined
from keypose.tracker.errors import FormatError
from keypose.tracker.evaluate import JointReference, Spread, evaluate, evaluate_joints
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation, rotation_from_euler
from keypose.tracker.solver.posed import BodyPoint
from tests.tracker import session_cases as cases

SKELETON = cases.SKELETON
CAMERA = cases.CAMERA
KEYS = (0, 4, 8)
BETWEEN = (1, 2, 3, 5, 6, 7)


def truth() -> Trajectory:
    return joined([cases.segment(0, 4).trajectory, cases.segment(4, 8).trajectory])


def shifted(trajectory: Trajectory, shift: tuple[float, float, float]) -> Trajectory:
    return Trajectory(
        trajectory.first_frame, trajectory.Rs_parent_part, trajectory.ps_camera_root + shift
    )


def test_the_truth_has_no_error_and_interpolation_has_one() -> None:
    found = evaluate(SKELETON, CAMERA, truth(), truth(), KEYS)
    assert found.frames == BETWEEN
    for kind in ("pixels", "distance_m", "depth_m", "angle_deg"):
        ours, linear = getattr(found.estimate, kind), getattr(found.interpolation, kind)
        assert ours.overall.p95 == pytest.approx(0, abs=1e-5)
        assert linear.overall.mean > 0
        assert ours.overall.count == linear.overall.count


def test_interpolation_starts_from_the_poses_at_the_keyframes() -> None:
    linear = joined(
        [interpolate(truth().pose(a), truth().pose(b), a, b) for a, b in pairwise(KEYS)]
    )
    found = evaluate(SKELETON, CAMERA, linear, truth(), KEYS)
    assert found.estimate == found.interpolation


def test_a_shift_in_depth_is_told_apart() -> None:
    found = evaluate(SKELETON, CAMERA, shifted(truth(), (0.0, 0.0, 0.1)), truth(), KEYS)
    assert found.estimate.depth_m is not None
    assert found.estimate.distance_m is not None
    assert found.estimate.depth_m.overall.mean == pytest.approx(0.1)
    assert found.estimate.distance_m.overall.median == pytest.approx(0.1)
    aside = evaluate(SKELETON, CAMERA, shifted(truth(), (0.1, 0.0, 0.0)), truth(), KEYS)
    assert aside.estimate.depth_m is not None
    assert aside.estimate.depth_m.overall.p95 == pytest.approx(0, abs=1e-12)
    assert aside.estimate.pixels.overall.mean == pytest.approx(2, abs=0.3)  # 60 px · 0.1 m / 3 m
    assert set(aside.estimate.pixels.each) == set(joint_names(SKELETON))


def test_an_angle_counts_for_its_own_part_only() -> None:
    Rs = truth().Rs_parent_part.copy()
    Rs[1:4, 2] = Rs[1:4, 2] @ rotation_from_euler(0.0, np.deg2rad(10.0), 0.0)
    bent = Trajectory(0, Rs, truth().ps_camera_root)
    angles = evaluate(SKELETON, CAMERA, bent, truth(), KEYS).estimate.angle_deg
    assert angles is not None
    assert angles.each["left_arm"].count == 6
    assert angles.each["left_arm"].mean == pytest.approx(5)
    assert angles.each["left_hand"].p95 == pytest.approx(0, abs=1e-5)


def test_only_frames_strictly_between_keyframes_count() -> None:
    Rs, ps = truth().Rs_parent_part, truth().ps_camera_root.copy()
    ps[[0, 4, 8]] += 5.0
    found = evaluate(SKELETON, CAMERA, truth(), Trajectory(0, Rs, ps), KEYS)
    assert found.frames == BETWEEN
    assert found.estimate.distance_m is not None
    assert found.estimate.distance_m.overall.p95 == pytest.approx(0, abs=1e-12)


def test_a_shorter_reference_is_compared_where_it_is() -> None:
    part = Trajectory(3, truth().Rs_parent_part[3:7], truth().ps_camera_root[3:7])
    assert evaluate(SKELETON, CAMERA, truth(), part, KEYS).frames == (3, 5, 6)


def test_what_cannot_be_compared_is_refused() -> None:
    elsewhere = Trajectory(50, truth().Rs_parent_part, truth().ps_camera_root)
    with pytest.raises(FormatError, match="no frame between two keyframes"):
        evaluate(SKELETON, CAMERA, truth(), elsewhere, KEYS)
    with pytest.raises(FormatError, match="at least two keyframes"):
        evaluate(SKELETON, CAMERA, truth(), truth(), (4,))
    fewer = Trajectory(0, truth().Rs_parent_part[:, :3], truth().ps_camera_root)
    with pytest.raises(FormatError, match="3 parts; the body has 4"):
        evaluate(SKELETON, CAMERA, truth(), fewer, KEYS)


PLACES: tuple[BodyPoint, ...] = (
    ((2, (0.0, 0.0, 0.0)),),
    ((1, (0.0, 0.0, 0.0)), (2, (0.0, 0.0, 0.0))),
)


def reference(width: int) -> JointReference:
    """An arm's joint and the middle between both arms, at frames 1, 4 and 6."""
    frames = np.array([1, 4, 6])
    joints = truth().joints(SKELETON)[frames]
    positions = np.stack([joints[:, 2], (joints[:, 1] + joints[:, 2]) / 2], axis=1)
    known = positions if width == 3 else CAMERA.project(positions)
    known = known.copy()
    known[2, 0] = np.nan
    return JointReference(("LShoulder", "middle"), PLACES, known, frames)


def test_joints_in_space_are_compared_at_their_frames() -> None:
    moved = shifted(truth(), (0.0, 0.0, 0.2))
    found = evaluate_joints(SKELETON, CAMERA, moved, reference(3), KEYS)
    assert found.frames == (1, 6)
    assert found.estimate.depth_m is not None
    assert found.estimate.depth_m.each["middle"].mean == pytest.approx(0.2)
    assert found.estimate.depth_m.each["LShoulder"].count == 1
    assert found.estimate.angle_deg is None


def test_marked_joints_are_compared_in_the_picture_only() -> None:
    found = evaluate_joints(SKELETON, CAMERA, truth(), reference(2), KEYS)
    assert found.estimate.pixels.overall.count == 3
    assert found.estimate.pixels.overall.p95 == pytest.approx(0, abs=1e-9)
    assert found.estimate.distance_m is None
    assert found.interpolation.pixels.overall.mean > 0


def test_no_errors_have_no_spread() -> None:
    spread = Spread.of(np.full((2, 3), np.nan))
    assert spread.count == 0
    assert np.isnan([spread.mean, spread.median, spread.p95]).all()


def test_before_a_camera_that_moves_errors_are_in_its_picture_and_interpolation_in_the_world() -> (
    None
):
    t = np.linspace(0, 1, 9)[:, None]
    path = CameraPath.of(exp_rotation(t * [0.0, -0.5, 0.1]), t * [0.3, 0.0, 0.1], 1 + t[:, 0])
    linear = joined(
        [interpolate(truth().pose(a), truth().pose(b), a, b) for a, b in pairwise(KEYS)]
    )
    seen = linear.carried(path.Ts_camera_world)
    exact = evaluate(SKELETON, CAMERA, seen, seen, KEYS, path=path).interpolation
    assert exact.distance_m is not None
    assert exact.distance_m.overall.p95 < 1e-9
    cameras = [path.camera_at(CAMERA, frame) for frame in range(9)]
    marks = np.stack(
        [camera.project(ps) for camera, ps in zip(cameras, seen.joints(SKELETON), strict=True)]
    )
    reference = JointReference(
        ("left_arm",), (((2, (0.0, 0.0, 0.0)),),), marks[:, 2:3], np.arange(9)
    )
    found = evaluate_joints(SKELETON, CAMERA, seen, reference, KEYS, path=path)
    assert found.estimate.pixels.overall.p95 < 1e-9
    aside = shifted(seen, (0.1, 0.0, 0.0))
    moved = evaluate(SKELETON, CAMERA, aside, seen, KEYS, path=path).estimate.pixels
    one_focal = evaluate(SKELETON, CAMERA, aside, seen, KEYS).estimate.pixels
    assert moved.overall.mean > 1.4 * one_focal.overall.mean
