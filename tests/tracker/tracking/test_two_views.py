"""Two cameras that see one motion: what each shows of it is a term, and the terms are summed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.body.pose import moved
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import rotation_from_euler, transform
from keypose.tracker.solver.frames import TermIn, carried
from keypose.tracker.solver.motion_problem import MotionProblem
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.sigmas import BEND_IN_PICTURE
from keypose.tracker.solver.smoothness import Smoothness
from keypose.tracker.tracking.bundle import Textures, refine
from keypose.tracker.tracking.method import Refinement
from tests.rendering.render import render
from tests.rendering.settings import RenderSettings
from tests.tracker.tracking_cases import Case, case

HOW = Refinement(solves=8, stride=2)
DEPTH_M = 0.03


@pytest.fixture(scope="module")
def front() -> Case:
    return case("tumbling_box", 10, 16)


@pytest.fixture(scope="module")
def T_side_front(front: Case) -> np.ndarray:
    """A camera aside, a quarter turn about the box."""
    R = rotation_from_euler(0.0, np.radians(80.0), 0.0)
    middle = front.truth.ps_camera_root.mean(axis=0)
    return transform(R, middle - R @ middle)


@pytest.fixture(scope="module")
def side(front: Case, T_side_front: np.ndarray) -> Case:
    """The same motion as the other camera films it."""
    Ts = np.broadcast_to(T_side_front, (len(front.truth), 4, 4))
    truth = front.truth.carried(Ts)
    pictures = render(front.skeleton, truth, front.camera, RenderSettings())
    return Case(front.skeleton, front.camera, truth, pictures)


def farther(truth: Trajectory) -> Trajectory:
    """The truth with every inner pose farther from the first camera than it is."""
    ps = truth.ps_camera_root.copy()
    ps[1:-1, 2] += DEPTH_M
    return Trajectory(0, truth.Rs_parent_part, ps)


def off_m(front: Case, found: Trajectory) -> float:
    """How far the root's depth is off, at worst."""
    return float(np.abs(found.ps_camera_root - front.truth.ps_camera_root)[:, 2].max())


def test_depth_that_one_camera_hardly_shows_the_other_one_gives(
    front: Case, side: Case, T_side_front: np.ndarray
) -> None:
    start, scene = farther(front.truth), front.scene()
    alone = refine(scene, front.clip(), start, HOW)
    seen_aside = start.carried(np.broadcast_to(T_side_front, (len(start), 4, 4)))
    aside = Textures.of(side.scene(), side.clip(), seen_aside, HOW.stride)
    even = Smoothness.even(front.skeleton, len(start), scene.precision(BEND_IN_PICTURE))
    also = MotionProblem(front.skeleton, (TermIn(aside, T_side_front),), (even,))
    both = refine(scene, front.clip(), start, HOW, also)
    assert off_m(front, both) < 0.004
    assert off_m(front, both) < 0.5 * off_m(front, alone)


def test_equations_of_another_frame_are_those_of_the_same_degrees_of_freedom(
    front: Case, T_side_front: np.ndarray
) -> None:
    """A step that is taken before or after changing the frame leads to the same pose there."""
    skeleton, pose = front.skeleton, front.truth.pose(2)
    step = np.random.default_rng(0).normal(0, 0.1, skeleton.dof_count)
    first = carried(Posed.of(skeleton, moved(skeleton, pose, step)), T_side_front)
    there = carried(Posed.of(skeleton, pose), T_side_front)
    turned = replace(pose, Rs_parent_part=there.Rs_parent_part, p_camera_root=there.p_camera_root)
    last = moved(skeleton, turned, step)
    np.testing.assert_allclose(last.Rs_parent_part, first.Rs_parent_part, atol=1e-12)
    np.testing.assert_allclose(last.p_camera_root, first.p_camera_root, atol=1e-12)
