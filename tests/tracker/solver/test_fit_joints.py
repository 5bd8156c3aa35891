"""The body laid into joint positions and keypoints that are known exactly."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose, moved, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import (
    exp_rotation,
    log_rotation,
    rotation_from_euler,
    transpose,
)
from keypose.tracker.solver.fit_joints import fit_motion, fit_picture, rigid
from keypose.tracker.solver.posed import BodyPoint, BodyPoints, Posed, free_skeleton

Floats = NDArray[np.float64]

BODY = preset("adult_female")
SKELETON = Skeleton.of(BODY)
LIMITS = Limits.of(BODY)
JOINTS: list[BodyPoint] = [((i, (0.0, 0.0, 0.0)),) for i in range(SKELETON.part_count)]
LANDMARKS: list[BodyPoint] = [
    ((i, p),) for i, part in enumerate(BODY.parts) for p in part.landmarks.values()
]
CAMERA = Camera(width=640, height=480, fx=700, fy=710, cx=322, cy=235)


def _angles(rng: np.random.Generator, share: float = 0.8) -> Floats:
    """(P, 3) Euler angles x, y, z within the limits; parts without any turn up to 45°."""
    low, high = (
        np.where(np.isfinite(x), x, f) for x, f in ((LIMITS.low, -0.8), (LIMITS.high, 0.8))
    )
    middle = np.clip(0.0, low, high)
    return middle + share * (rng.uniform(low, high) - middle)


def _pose(angles: Floats, place: Floats) -> Pose:
    return Pose(np.stack([rotation_from_euler(z, y, x) for x, y, z in angles]), place)


@cache
def _motion(seed: int = 3, frames: int = 24) -> Trajectory:
    """From one pose that the joints allow to two others."""
    rng = np.random.default_rng(seed)
    ends = [_angles(rng) for _ in range(3)]
    s = np.linspace(0, 2, frames)
    path = np.stack([0.3 * s, 0.1 * np.sin(3 * s), 3.5 + 0.2 * s], axis=1)
    leg = np.minimum(s.astype(int), 1)
    poses = [
        _pose(ends[i] + (x - i) * (ends[i + 1] - ends[i]), p)
        for x, i, p in zip(s, leg, path, strict=True)
    ]
    Rs = np.stack([pose.Rs_parent_part for pose in poses])
    return Trajectory(40, Rs, np.stack([pose.p_camera_root for pose in poses]))


def _away(one: Trajectory, other: Trajectory) -> Floats:
    return np.asarray(np.linalg.norm(one.joints(SKELETON) - other.joints(SKELETON), axis=-1))


def test_a_motion_of_our_own_body_is_recovered_to_a_millimetre() -> None:
    truth = _motion()
    fit = fit_motion(BODY, [*JOINTS, *LANDMARKS], truth.joints(SKELETON), truth.first_frame)
    assert fit.trajectory.first_frame == 40
    assert _away(fit.trajectory, truth).max() < 1e-3
    assert fit.rms_m.max() < 5e-4
    assert fit.converged.all()


def test_noise_does_not_stretch_the_bones() -> None:
    truth = _motion()
    noise = np.random.default_rng(5).normal(0, 0.03, (len(truth), len(JOINTS), 3))
    ps = truth.joints(SKELETON)[:, : len(JOINTS)] + noise
    fit = fit_motion(BODY, JOINTS, ps, 0)
    Rs = fit.trajectory.Rs_parent_part
    assert np.allclose(Rs @ transpose(Rs), np.eye(3), atol=1e-9)
    assert 0.005 < np.median(fit.rms_m) < 0.06  # told as it is


def test_an_elbow_does_not_bend_backwards_as_far_as_the_positions_say() -> None:
    elbow = BODY.index("left_forearm")
    for asked in (30.0, 60.0):
        angles = np.zeros((SKELETON.part_count, 3))
        angles[elbow, 0] = np.radians(asked)  # its limit is 0
        wrong = _pose(angles, np.array([0.0, 0.0, 3.0]))
        ps = Trajectory(0, wrong.Rs_parent_part[None], wrong.p_camera_root[None]).joints(SKELETON)
        fit = fit_motion(BODY, JOINTS, ps[:, : len(JOINTS)], 0)
        outside, _ = LIMITS.excess(fit.trajectory.Rs_parent_part[0])
        assert np.degrees(np.abs(outside)).max() < asked / 2


def test_a_limb_that_is_not_given_keeps_the_pose_it_is_held_to() -> None:
    truth = _motion()
    ps = truth.joints(SKELETON)[:, : len(JOINTS)].copy()
    limb = [BODY.index(name) for name in ("left_forearm", "left_hand")]
    ps[:, limb] = np.nan
    held = truth.pose(45)
    Rs = fit_motion(BODY, JOINTS, ps, 40, [held] * len(truth)).trajectory.Rs_parent_part
    bent = log_rotation(transpose(held.Rs_parent_part[limb]) @ Rs[:, limb])
    assert np.degrees(np.abs(bent)).max() < 1.0


def test_a_rigid_transform_is_recovered_past_missing_points() -> None:
    rng = np.random.default_rng(1)
    R, p = exp_rotation([0.7, -2.0, 0.4]), np.array([4.0, -1.0, 2.0])
    ours = rng.normal(size=(20, 3))
    theirs = ours @ R.T + p
    ours[3] = np.nan
    found = rigid(ours, theirs)
    assert np.allclose(found[0], R)
    assert np.allclose(found[1], p)


def test_the_slopes_of_places_and_limits_are_those_of_small_motions() -> None:
    skeleton = free_skeleton(BODY)
    place: BodyPoint = ((5, (0.0, 0.1, 0.02)), (9, (0.01, 0.0, 0.0)))
    laid = BodyPoints(skeleton, (*JOINTS, place))
    pose = _motion().pose(50)
    _, slopes = laid.jacobian(Posed.of(skeleton, pose))
    narrow = Limits(np.full_like(LIMITS.low, 0.0), np.full_like(LIMITS.high, 0.0))
    outside, turned = narrow.excess(pose.Rs_parent_part)
    for d in range(skeleton.dof_count):
        x = np.zeros(skeleton.dof_count)
        x[d] = 1e-6
        there = moved(skeleton, pose, x)
        change = laid.at(pose_transforms(skeleton, there)) - laid.at(
            pose_transforms(skeleton, pose)
        )
        assert np.allclose(change / 1e-6, slopes[:, d], atol=1e-5)
        if skeleton.dof_turns[d]:
            part, axis = skeleton.dof_part[d], skeleton.dof_axis[d]
            steeper = (narrow.excess(there.Rs_parent_part)[0] - outside)[part] / 1e-6
            assert np.allclose(steeper, turned[part, :, axis], atol=1e-3)


@pytest.mark.parametrize(
    "camera",
    [
        CAMERA,
        CAMERA.model_copy(update={"distortion": (-0.2, 0.05, 0.001, -0.001, 0.0)}),
        CAMERA.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 4.0}),
    ],
    ids=["perspective", "distorted", "telephoto"],
)
def test_a_pose_is_found_from_exact_pixels_through_every_lens(camera: Camera) -> None:
    truth = _motion().pose(46)
    truth = Pose(truth.Rs_parent_part, np.array([0.1, 0.0, 4.0]))
    laid = BodyPoints(SKELETON, tuple(JOINTS))
    uv = camera.project(laid.at(pose_transforms(SKELETON, truth)))
    start = moved(
        free_skeleton(BODY),
        truth,
        np.random.default_rng(2).normal(0, 0.1, 3 * SKELETON.part_count + 3),
    )
    solved = fit_picture(BODY, camera, JOINTS, uv, np.ones(len(JOINTS)), [start], start)
    away = camera.project(laid.at(pose_transforms(SKELETON, solved.pose))) - uv
    assert np.abs(away).max() < 0.5
    assert solved.converged


def test_of_several_starts_the_one_that_ends_best_is_kept() -> None:
    """A start with its back to the camera ends badly; the other one is right."""
    truth = Pose.rest(SKELETON, (0.0, 0.0, 4.0))
    laid = BodyPoints(SKELETON, (*JOINTS, *LANDMARKS))
    uv = CAMERA.project(laid.at(pose_transforms(SKELETON, truth)))
    Rs = truth.Rs_parent_part.copy()
    Rs[0] = exp_rotation([0.0, np.pi, 0.0])
    away = Pose(Rs, truth.p_camera_root)

    def turn(starts: list[Pose]) -> float:
        weights = np.ones(len(uv))
        solved = fit_picture(BODY, CAMERA, laid.points, uv, weights, starts)
        return float(np.linalg.norm(log_rotation(solved.pose.Rs_parent_part[0])))

    assert turn([away, truth]) < 0.1
    assert turn([truth, away]) < 0.1


def test_limits_are_widened_to_what_was_posed_and_not_beyond() -> None:
    body = preset("adult_male")
    limits, elbow = Limits.of(body), body.index("left_forearm")
    bent_back = np.tile(np.eye(3), (len(body.parts), 1, 1))
    bent_back[elbow] = exp_rotation(np.array([limits.high[elbow, 0] + 0.3, 0.0, 0.0]))
    wide = limits.widened([bent_back])
    assert np.abs(limits.excess(bent_back)[0]).max() > 0.2
    assert np.abs(wide.excess(bent_back)[0]).max() < 1e-9
    further = bent_back.copy()
    further[elbow] = further[elbow] @ exp_rotation(np.array([0.1, 0.0, 0.0]))
    assert wide.excess(further)[0][elbow, 0] == pytest.approx(0.1)
