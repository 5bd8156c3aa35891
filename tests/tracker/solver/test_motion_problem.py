"""The poses of neighbouring frames solved at once, with what they share."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.solver.least_squares import EXACT, least_squares
from keypose.tracker.solver.motion_problem import EVERY, MotionProblem, MotionState, moved_poses
from keypose.tracker.solver.pose_terms import PointsInPicture, PointsInSpace, PosePrior
from keypose.tracker.solver.posed import BodyPoint, BodyPoints, Posed
from keypose.tracker.solver.projection import image_points
from keypose.tracker.solver.robust import SQUARED
from keypose.tracker.solver.smoothness import Smoothness
from keypose.tracker.solver.space_terms import AtOnePlace, Differences, Floor, Near, OnFloor
from keypose.tracker.solver.terms import Link, SharedTerm
from tests.tracker.solver.test_links import DOFS, FOOT, SKELETON, motion

UP = np.array([0.0, -1.0, 0.0])
CAMERA = Camera(width=640, height=360, fx=900, fy=900, cx=319.5, cy=179.5)


def swaying(frames: int = 12) -> Trajectory:
    """Somebody who sways while the left foot stands still."""
    s = np.linspace(0, 1, frames)
    turns = np.zeros((frames, SKELETON.part_count, 3))
    turns[:, 0] = np.column_stack([0.1 * s, 0.4 * s**2, 0.2 * np.sin(3 * s)])
    turns[:, SKELETON.body.index("left_upper_arm"), 2] = -1.2 * s
    turns[:, SKELETON.body.index("left_thigh"), 0] = -0.3 * s
    free = Trajectory(4, exp_rotation(turns), np.zeros((frames, 3)))
    foot = free.transforms(SKELETON)[:, FOOT, :3, 3]
    return Trajectory(4, free.Rs_parent_part, np.array([0.2, 0.8, 4.0]) - foot)


def every_point() -> BodyPoints:
    """Four points of every part."""
    corners = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.1))
    places: tuple[BodyPoint, ...] = tuple(
        ((i, p),) for i in range(SKELETON.part_count) for p in corners
    )
    return BodyPoints(SKELETON, places)


def disturbed(truth: Trajectory, size: float, seed: int = 0) -> Trajectory:
    rng = np.random.default_rng(seed)
    return moved_poses(SKELETON, truth, rng.normal(0, size, (len(truth), DOFS)))


def apart_m(one: Trajectory, other: Trajectory) -> float:
    points = every_point()
    away = points.at(one.transforms(SKELETON)) - points.at(other.transforms(SKELETON))
    return float(np.linalg.norm(away, axis=-1).max())


def usually_apart_m(one: Trajectory, other: Trajectory) -> float:
    points = every_point()
    away = points.at(one.transforms(SKELETON)) - points.at(other.transforms(SKELETON))
    return float(np.linalg.norm(away, axis=-1).mean())


def test_a_known_motion_and_a_known_place_are_found_from_points_in_space() -> None:
    truth = swaying()
    points = every_point()
    foot = BodyPoints(SKELETON, (((FOOT, (0.0, 0.0, 0.0)),),))
    place = foot.at(truth.transforms(SKELETON))[0, 0]
    begin = np.append(place + 0.2, 0.0)
    shared: tuple[SharedTerm, ...] = (
        AtOnePlace(foot, slice(0, len(truth)), 0, 0.004, SQUARED),
        OnFloor(0, Floor(UP, np.zeros((0, 3)), np.zeros(3)), 0.0, 0.008),
        Near(begin, np.full(4, 1e-6)),
    )
    terms = [PointsInSpace(points, points.at(truth.transforms(SKELETON)), 0.005)]
    problem = MotionProblem(SKELETON, terms, (), EVERY, shared)
    found = least_squares(problem, MotionState(disturbed(truth, 0.1), begin), EXACT)
    assert found.converged
    assert apart_m(found.state.motion, truth) < 1e-6
    np.testing.assert_allclose(found.state.shared, np.append(place, place @ UP), atol=1e-6)


def test_a_motion_seen_with_noise_comes_nearer_with_its_place_and_smoothness() -> None:
    """A picture says little of depth."""
    truth = swaying(20)
    points = every_point()
    foot = BodyPoints(SKELETON, (((FOOT, (0.0, 0.0, 0.0)),),))
    place = foot.at(truth.transforms(SKELETON))[0, 0]
    clear = image_points(CAMERA, points.at(truth.transforms(SKELETON)))
    noise = np.random.default_rng(8).normal(0, 2.0, clear.shape)
    seen = (PointsInPicture(points, CAMERA, clear + noise, np.full(clear.shape[:2], 0.5), 0.05),)
    start = disturbed(truth, 0.02)
    links: tuple[Link, ...] = (
        Smoothness.even(SKELETON, len(truth), np.full(DOFS, 0.05**-2)),
        Differences(SKELETON, foot, np.array([400.0]), 30.0),
    )
    shared: tuple[SharedTerm, ...] = (
        AtOnePlace(foot, slice(0, len(truth)), 0, 0.002, SQUARED),
        Near(place, np.full(3, 1e3)),
    )
    alone, held = (
        least_squares(
            MotionProblem(SKELETON, seen, links, EVERY, shared), MotionState(start, about), EXACT
        ).state
        for links, shared, about in (((), (), np.zeros(0)), (links, shared, place + 0.1))
    )
    stands = foot.at(held.motion.transforms(SKELETON))[:, 0]
    assert np.linalg.norm(stands - place, axis=-1).max() < 0.005
    assert usually_apart_m(held.motion, truth) < 0.6 * usually_apart_m(alone.motion, truth)


@pytest.mark.parametrize("shared", [0, 4])
def test_a_step_of_squares_leads_to_rest(shared: int) -> None:
    at = motion(0.05)
    wanted = PosePrior(at.Rs_parent_part, at.ps_camera_root, np.full(DOFS, 100.0))
    values = np.arange(shared, dtype=float)
    problem = MotionProblem(SKELETON, (wanted,), (), EVERY, (Near(values, np.full(shared, 2.0)),))
    start = MotionState(disturbed(at, 1e-4), values + 0.5)
    here = problem.at(start, 0)
    step = here.step(0.0)
    assert step is not None
    there = problem.moved(start, step)
    assert problem.at(there, 1).cost < 1e-6 * here.cost
    np.testing.assert_allclose(there.shared, values, atol=1e-9)


def test_a_step_moves_poses_and_shared_unknowns_each_by_their_own() -> None:
    at = motion(0.3)
    problem = MotionProblem(SKELETON, unknown=EVERY)
    step = np.random.default_rng(1).normal(0, 0.01, len(at) * DOFS + 3)
    there = problem.moved(MotionState(at, np.ones(3)), step)
    np.testing.assert_array_equal(there.shared, 1 + step[-3:])
    now = Posed(SKELETON, there.motion.Rs_parent_part, there.motion.ps_camera_root)
    led = now.motion_from(at.Rs_parent_part, at.ps_camera_root, backward=False)
    np.testing.assert_allclose(led.ravel(), step[:-3], atol=1e-9)


def test_smoothness_alone_makes_a_motion_even_and_leaves_its_ends_as_they_are() -> None:
    bent = disturbed(swaying(), 0.02)
    even = Smoothness.even(SKELETON, len(bent), np.ones(DOFS))
    found = MotionProblem(SKELETON, links=(even,)).solve(bent, EXACT)
    assert even.cost(found) < 1e-3 * even.cost(bent)
    for k in (0, -1):
        np.testing.assert_array_equal(found.Rs_parent_part[k], bent.Rs_parent_part[k])
        np.testing.assert_array_equal(found.ps_camera_root[k], bent.ps_camera_root[k])
