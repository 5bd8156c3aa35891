"""What a film with a clock of its own shows acts on the motion as its derivatives say."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import rotation_from_euler, transform
from keypose.tracker.solver.frames import TermIn
from keypose.tracker.solver.in_film import FilmFrames, InFilm
from keypose.tracker.solver.motion_problem import EVERY, MotionProblem, MotionState, moved_poses
from keypose.tracker.solver.pose_terms import PointsInPicture
from keypose.tracker.solver.posed import joints_and_landmarks
from keypose.tracker.solver.robust import SQUARED
from keypose.tracker.solver.smoothness import Increments, increments
from tests.rendering.motions import tumbling_box

SKELETON = Skeleton.of(preset("box"))
CAMERA = Camera.from_focal_length(640, 480, 30.0)
MOTION = tumbling_box(SKELETON, 8)
R = rotation_from_euler(0.1, 0.6, -0.1)
MIDDLE = MOTION.ps_camera_root.mean(axis=0)
T_SIDE = transform(R, MIDDLE - R @ MIDDLE)


def frames(moments: np.ndarray) -> FilmFrames:
    return FilmFrames(0, moments, np.broadcast_to(T_SIDE, (len(moments), 4, 4)))


def picture(motion: Trajectory) -> PointsInPicture:
    """Joints seen a little beside where they are."""
    points = joints_and_landmarks(SKELETON)
    uv = CAMERA.project(points.at(motion.transforms(SKELETON))) + 3.0
    return PointsInPicture(points, CAMERA, uv, np.ones(uv.shape[:2]), 0.05, SQUARED)


def link_of(moments: np.ndarray) -> InFilm:
    """Points in the film's pictures, and its steps, which lead a little astray."""
    own = frames(moments)
    seen = own.seen(MOTION)
    wanted = increments(SKELETON, seen) + 0.01
    precision = np.full(wanted.shape, 30.0)
    steps = Increments(SKELETON, wanted, precision, SQUARED)
    return InFilm(SKELETON, own, (picture(seen),), (steps,))


MOMENTS = [
    np.arange(8.0),
    np.arange(7) + 0.3,
    np.arange(0.5, 7.0, 0.5),
    np.arange(0.2, 7.0, 2.0),
]


@pytest.mark.parametrize("moments", MOMENTS, ids=["same", "between", "twice", "half"])
def test_its_gradient_is_that_of_its_cost(moments: np.ndarray) -> None:
    problem = MotionProblem(SKELETON, (), (link_of(moments),), EVERY)
    gradient = problem.at(MotionState(MOTION), 0).equations.b
    step = np.zeros_like(gradient)
    for k in range(len(gradient)):
        step[:] = 0.0
        step[k] = 1e-5
        there, back = (
            problem.cost(moved_poses(SKELETON, MOTION, (sign * step).reshape(8, -1)))
            for sign in (1, -1)
        )
        # a pose between two lies on the way from one to the other: exact to first order of its turn
        assert abs((there - back) / 2e-5 - gradient[k]) < 0.05 * np.abs(gradient).max() + 1e-6


def test_a_film_with_the_same_clock_is_a_term_in_another_frame() -> None:
    own = frames(np.arange(8.0))
    term = picture(own.seen(MOTION))
    film = MotionProblem(SKELETON, (), (InFilm(SKELETON, own, (term,)),), EVERY)
    plain = MotionProblem(SKELETON, (TermIn(term, own.Ts_film_first),), (), EVERY)
    here, there = (each.at(MotionState(MOTION), 0).equations for each in (film, plain))
    np.testing.assert_allclose(here.b, there.b, rtol=1e-9, atol=1e-9)
    width = there.rows.shape[1]
    np.testing.assert_allclose(here.rows[:, :width], there.rows, rtol=1e-9, atol=1e-9)
    assert film.cost(MOTION) == pytest.approx(plain.cost(MOTION), rel=1e-12)


def test_frames_that_are_held_are_not_moved() -> None:
    link = link_of(np.arange(7) + 0.4)
    inner = MotionProblem(SKELETON, (), (link,), slice(1, -1))
    whole = MotionProblem(SKELETON, (), (link,), EVERY)
    dofs = SKELETON.dof_count
    held, all_of_it = (each.at(MotionState(MOTION), 0).equations for each in (inner, whole))
    np.testing.assert_allclose(held.b, all_of_it.b[dofs:-dofs], rtol=1e-12)
