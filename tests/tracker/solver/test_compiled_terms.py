"""The loops that compare poses against their plain twins."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.solver.placed import Placed
from keypose.tracker.solver.plain_placed import PlainPlaced
from keypose.tracker.solver.pose_terms import DepthFromRoot, JointLimits, PointsInPicture
from keypose.tracker.solver.posed import BodyPoints, Posed, free_skeleton
from keypose.tracker.solver.robust import SQUARED, Cauchy, Huber, Kernel, Tukey
from keypose.tracker.solver.smoothness import (
    Increments,
    Smoothness,
    increments,
    second_differences,
)
from keypose.tracker.solver.terms import SummedTerm
from tests.tracker.solver.test_banded import dense
from tests.tracker.tracking_cases import deep_chain, random_body

Floats = NDArray[np.float64]

BODIES = {
    "one part": random_body(0, parts=1),
    "root fixed": random_body(3, root_dofs=()),
    "chain": deep_chain(),
    "person": Skeleton.of(preset("adult_male")),
    "person whose parts turn in every way": free_skeleton(preset("adult_male")),
    "dog": Skeleton.of(preset("dog")),
}
CAMERA = Camera(width=640, height=480, fx=700, fy=710, cx=322, cy=235)
CAMERAS = {
    "perspective": CAMERA,
    "telephoto": CAMERA.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 4.0}),
}
KERNELS: dict[str, Kernel] = {
    "squares": SQUARED, "huber": Huber(), "cauchy": Cauchy(), "tukey": Tukey(30.0),
}  # fmt: skip
every_body = pytest.mark.parametrize("name", BODIES)
every_kernel = pytest.mark.parametrize("kernel", KERNELS.values(), ids=KERNELS)
BATCHES = pytest.mark.parametrize("batch", [(), (1,), (4,), (2, 3)], ids=str)


def poses(skeleton: Skeleton, batch: tuple[int, ...], turn_rad: float = 0.6) -> Posed:
    rng = np.random.default_rng(1)
    Rs = exp_rotation(rng.normal(0, turn_rad, (*batch, skeleton.part_count, 3)))
    return Posed(skeleton, Rs, rng.normal((0.2, -0.1, 4.0), 0.2, (*batch, 3)))


def plainly(posed: Posed) -> Posed:
    """The same poses, compared without loops."""
    same = Posed(posed.skeleton, posed.Rs_parent_part, posed.p_camera_root)
    each = same.each(same.Rs_parent_part, 3), same.each(same.p_camera_root, 1)
    same.__dict__["placed"] = PlainPlaced(same.skeleton, *each)
    return same


def by_loops(posed: Posed) -> Posed:
    """The same poses, compared by loops, also where it is one."""
    same = Posed(posed.skeleton, posed.Rs_parent_part, posed.p_camera_root)
    each = same.each(same.Rs_parent_part, 3), same.each(same.p_camera_root, 1)
    same.__dict__["placed"] = Placed.of(same.skeleton, *each)
    return same


def all_places(skeleton: Skeleton) -> BodyPoints:
    """A place on every part, and the middle of some."""
    single = [((i, (0.01 * i, 0.02, -0.01)),) for i in range(skeleton.part_count)]
    ends = ((0, (0.0, 0.1, 0.0)), (skeleton.part_count - 1, (0.0, 0.0, 0.02)))
    return BodyPoints(skeleton, (*single, ends))


def test_one_pose_needs_no_loops_and_many_are_compared_by_them() -> None:
    for batch, kind in (((), PlainPlaced), ((1,), Placed), ((2, 3), Placed)):
        assert isinstance(poses(BODIES["person"], batch).placed, kind)


POSED = """
import sys
from keypose.app.posing import box_corners, trunk
from keypose.tracker.body.body import preset
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.solver.least_squares import USUAL, least_squares
from keypose.tracker.solver.one_pose import OnePose
from keypose.tracker.solver.pose_terms import JointLimits, PointsInSpace, PosePrior
from keypose.tracker.solver.posed import joints_and_landmarks
skeleton = Skeleton.of(preset("adult_male"))
pose, points = Pose.rest(skeleton, (0.0, 0.0, 4.0)), joints_and_landmarks(skeleton)
limits = JointLimits(Limits.of(skeleton.body), 0.05)
terms = PointsInSpace(points, 1.0, 0.1), limits, PosePrior.of(pose, 1.0)
assert least_squares(OnePose(skeleton, terms), pose, USUAL).steps
print(*sorted({"numba", "scipy"} & set(sys.modules)))
"""


def test_to_pose_by_hand_loads_no_loops() -> None:
    done = subprocess.run([sys.executable, "-c", POSED], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def assert_equal(term: SummedTerm, posed: Posed) -> None:
    expected, posed = term.equations(plainly(posed)), by_loops(posed)
    found = term.equations(posed)
    for own, other in ((found.A, expected.A), (found.b, expected.b)):
        np.testing.assert_allclose(own, other, atol=1e-9 * max(np.abs(other).max(initial=0.0), 1.0))
    assert found.cost == pytest.approx(expected.cost)
    assert term.cost(posed) == pytest.approx(expected.cost)


@every_body
@BATCHES
def test_places_and_how_they_move_are_as_by_the_twin(name: str, batch: tuple[int, ...]) -> None:
    posed = poses(BODIES[name], batch)
    points = all_places(posed.skeleton)
    found, expected = points.jacobian(by_loops(posed)), points.jacobian(plainly(posed))
    np.testing.assert_allclose(found[0], expected[0], atol=1e-12)
    np.testing.assert_allclose(found[1], expected[1], atol=1e-12)
    for way in (by_loops, plainly):
        np.testing.assert_allclose(points.of(way(posed)), expected[0], atol=1e-12)


@every_body
@every_kernel
@pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
@BATCHES
def test_pixels_are_compared_as_by_the_twin(
    name: str, kernel: Kernel, camera: Camera, batch: tuple[int, ...]
) -> None:
    posed, rng = poses(BODIES[name], batch), np.random.default_rng(2)
    points = all_places(posed.skeleton)
    uv = rng.normal((320, 240), 90, (*batch, len(points.points), 2))
    scale = rng.uniform(-0.1, 0.3, len(points.points)).clip(0)  # of some nothing is known
    assert_equal(PointsInPicture(points, camera, uv, scale, 0.05, kernel), posed)


def test_a_pose_with_a_point_too_near_the_camera_cannot_be() -> None:
    skeleton = BODIES["person"]
    posed = Posed(skeleton, poses(skeleton, ()).Rs_parent_part, np.array([0.0, 0.0, 0.1]))
    points = all_places(skeleton)
    unknown = np.zeros(len(points.points))
    term = PointsInPicture(points, CAMERA, np.zeros((len(points.points), 2)), unknown, 0.05)
    for way in (plainly, by_loops):
        assert term.cost(way(posed)) == term.equations(way(posed)).cost == np.inf


@every_body
@every_kernel
@BATCHES
def test_depths_are_compared_as_by_the_twin(
    name: str, kernel: Kernel, batch: tuple[int, ...]
) -> None:
    posed, rng = poses(BODIES[name], batch), np.random.default_rng(3)
    points = all_places(posed.skeleton)
    depth = rng.normal(0, 0.3, (*batch, len(points.points)))
    scale = rng.uniform(-3, 12, depth.shape).clip(0)
    assert_equal(DepthFromRoot(points, depth, scale, kernel), posed)


@every_body
@pytest.mark.parametrize("turn_rad", [0.0, 0.3, 1.5, 3.0])
@pytest.mark.parametrize("allowed", [None, 0.2], ids=["none allowed", "some allowed"])
@pytest.mark.parametrize("onset_rad", [0.0, 0.4])
def test_joint_limits_are_compared_as_by_the_twin(
    name: str, turn_rad: float, allowed: float | None, onset_rad: float
) -> None:
    posed, rng = poses(BODIES[name], (5,), turn_rad), np.random.default_rng(4)
    limits = Limits.of(posed.skeleton.body)
    beyond = None
    if allowed is not None:
        beyond = rng.normal(0, allowed, (posed.skeleton.part_count, 4))
    assert_equal(JointLimits(limits, 0.03, beyond, onset_rad), posed)


@every_body
@pytest.mark.parametrize("turn_rad", [1e-9, 0.1, 1.0, np.pi])
@pytest.mark.parametrize("backward", [True, False])
def test_the_motion_between_poses_is_as_by_the_twin(
    name: str, turn_rad: float, backward: bool
) -> None:
    here, rng = poses(BODIES[name], (4,)), np.random.default_rng(5)
    axes = rng.normal(size=here.Rs_parent_part.shape[:-1])
    axes *= (1 - 1e-7) * turn_rad / np.linalg.norm(axes, axis=-1, keepdims=True)
    there = Posed(here.skeleton, here.Rs_parent_part @ exp_rotation(axes), here.p_camera_root + 0.1)
    before = here.Rs_parent_part, here.p_camera_root
    expected = plainly(there).motion_from(*before, backward)
    np.testing.assert_allclose(there.motion_from(*before, backward), expected, atol=1e-6)
    one = here.Rs_parent_part[0], here.p_camera_root[0]
    alike = there.motion_from(*one, backward)
    np.testing.assert_allclose(alike[0], expected[0], atol=1e-6)


def link_rows(link: Increments | Smoothness, of: Floats) -> tuple[Floats, Floats, float]:
    """Residuals (M,) of differences (m, D), weighted if robust, their Jacobian (M, N D) as it is of
    small motions, and their cost."""
    (m, dofs), reach = of.shape, len(link.stencil)
    precision = np.broadcast_to(link.precision, of.shape)
    away = of - link.wanted
    size = np.sqrt(precision) * np.abs(away)
    scale = np.sqrt(precision * link.kernel.weight(size))
    J = np.zeros((m, dofs, m + reach - 1, dofs))
    for k in range(m):
        for i, share in enumerate(link.stencil):
            J[k, np.arange(dofs), k + i, np.arange(dofs)] = share * scale[k]
    cost = 0.5 * float(link.kernel.loss(size).sum())
    return (scale * away).ravel(), J.reshape(m * dofs, -1), cost


MakeLink = Callable[[Skeleton, Trajectory, Kernel], Increments | Smoothness]


def _steps(skeleton: Skeleton, at: Trajectory, kernel: Kernel) -> Increments:
    rng, of = np.random.default_rng(6), increments(skeleton, at)
    precision = rng.uniform(-100, 400, of.shape).clip(0)
    return Increments(skeleton, of + rng.normal(0, 0.2, of.shape), precision, kernel)


def _even(skeleton: Skeleton, at: Trajectory, kernel: Kernel) -> Smoothness:
    wanted = np.zeros_like(second_differences(skeleton, at))
    return Smoothness(skeleton, wanted, np.linspace(0, 40, wanted.shape[1]), kernel)


@every_body
@every_kernel
@pytest.mark.parametrize("make", [_steps, _even], ids=["steps", "evenness"])
@pytest.mark.parametrize(
    "unknown",
    [slice(None), slice(1, -1), slice(1, None), slice(2, 3)],
    ids=["all", "inner", "from the second", "one"],
)
def test_links_are_compared_as_by_the_twin(
    name: str, kernel: Kernel, make: MakeLink, unknown: slice
) -> None:
    skeleton = BODIES[name]
    posed = poses(skeleton, (5,), 0.2)
    at = Trajectory(3, posed.Rs_parent_part, posed.p_camera_root)
    link = make(skeleton, at, kernel)
    r, of_all, cost = link_rows(link, link.of(at))
    chosen = np.arange(5 * skeleton.dof_count).reshape(5, -1)[unknown].ravel()
    J = of_all[:, chosen]
    rows = np.zeros((len(chosen), link.width(skeleton.dof_count)))
    b = np.zeros(len(chosen))
    link.add_to(at, unknown, rows, b)
    np.testing.assert_allclose(dense(rows), J.T @ J, atol=1e-9)
    np.testing.assert_allclose(b, J.T @ r, atol=1e-9)
    assert link.cost(at) == pytest.approx(cost)


def test_places_that_are_the_middle_of_points_move_with_all_that_these_hang_on() -> None:
    skeleton = BODIES["person"]
    ends = (skeleton.body.index("left_hand"), skeleton.body.index("right_foot"))
    middle = BodyPoints(skeleton, (tuple((part, (0.0, 0.0, 0.0)) for part in ends),))
    _, J = middle.jacobian(poses(skeleton, ()))
    moved = np.abs(J[0]).max(axis=-1) > 0
    above = skeleton.below[list(ends)].any(axis=0)[skeleton.dof_part]
    assert not moved[~above].any()
    assert moved[above].mean() > 0.9
