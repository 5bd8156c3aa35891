"""What links frames with each other, and what they share: gradients and equations against finite
differences, whichever poses are unknown."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.solver.motion_problem import (
    EVERY,
    MotionPoint,
    MotionProblem,
    MotionState,
    moved_poses,
)
from keypose.tracker.solver.posed import BodyPoints, Posed, free_skeleton
from keypose.tracker.solver.robust import SQUARED, Cauchy, Huber
from keypose.tracker.solver.smoothness import (
    Increments,
    Smoothness,
    increments,
    second_differences,
)
from keypose.tracker.solver.space_terms import SECOND, AtOnePlace, Differences, Floor, Near, OnFloor
from keypose.tracker.solver.terms import Link, SharedTerm
from tests.tracker.solver.test_banded import dense

Floats = NDArray[np.float64]

SKELETON = free_skeleton(preset("adult_male"))
TRACKED = Skeleton.of(preset("adult_male"))
DOFS = SKELETON.dof_count
FRAMES = 6
FOOT = SKELETON.body.index("left_foot")
HAND = SKELETON.body.index("right_hand")
POINTS = BodyPoints(
    SKELETON,
    (((0, (0.0, 0.0, 0.0)),), ((FOOT, (0.02, 0.06, -0.1)),), ((HAND, (0.0, 0.1, 0.02)),)),
)
SIZES = pytest.mark.parametrize(
    "turn_rad", [1e-3, 0.3, 1.0], ids=["near identity", "bent", "large"]
)
UNKNOWN = pytest.mark.parametrize(
    "unknown",
    [slice(None), slice(1, -1), slice(1, None), slice(0, 2), slice(3, 4)],
    ids=["all", "inner", "from the second", "two", "one"],
)


def motion(turn_rad: float, frames: int = FRAMES, shift_m: float = 0.1) -> Trajectory:
    """Poses in front of the camera that change by about so much from frame to frame."""
    rng = np.random.default_rng(1)
    Rs = exp_rotation(rng.normal(0, turn_rad, (frames, SKELETON.part_count, 3)))
    return Trajectory(4, Rs, rng.normal((0.1, -0.1, 4.0), shift_m, (frames, 3)))


def posed(at: Trajectory) -> Posed:
    return Posed(SKELETON, at.Rs_parent_part, at.ps_camera_root)


def equations(link: Link, at: Trajectory, unknown: slice = EVERY) -> tuple[Floats, Floats]:
    """Rows (u D, w) of the unknown poses, and their gradient (u, D)."""
    count = len(range(*unknown.indices(len(at))))
    rows = np.zeros((count * DOFS, link.width(DOFS)))
    b = np.zeros(count * DOFS)
    link.add_to(at, unknown, rows, b)
    return rows, b.reshape(count, DOFS)


def difference(value: Callable[[Trajectory], float], at: Trajectory, size: float = 1e-6) -> Floats:
    """(N, D) central differences over the motions of every pose."""
    found = np.zeros((len(at), DOFS))
    for j in range(len(at)):
        for d in range(DOFS):
            x = np.zeros((len(at), DOFS))
            x[j, d] = size
            ahead, behind = (moved_poses(SKELETON, at, sign * x) for sign in (1, -1))
            found[j, d] = (value(ahead) - value(behind)) / (2 * size)
    return found


def jerk(fps: float = 30.0, *, varying: bool = False) -> Differences:
    """varying: of sigmas that differ from frame to frame."""
    sigma = np.array([150.0, 1200.0, 750.0])
    if varying:
        sigma = sigma * np.random.default_rng(5).uniform(0.2, 1.0, (FRAMES - 3, len(sigma)))
    return Differences(SKELETON, POINTS, sigma, fps)


def push() -> Differences:
    """Second differences beside wanted ones, of some frames alone."""
    rng = np.random.default_rng(6)
    sigma = np.where(rng.uniform(size=(FRAMES - 2, 3)) < 0.5, 8.0, np.inf)
    wanted = rng.normal(0, 5, (FRAMES - 2, 3, 3))
    return Differences(SKELETON, POINTS, sigma, 30.0, SECOND, wanted)


# --- moving


@SIZES
def test_poses_move_along_their_own_axes_and_stay_rotations(turn_rad: float) -> None:
    at = motion(turn_rad)
    steps = np.random.default_rng(3).normal(0, 0.1, (FRAMES, DOFS))
    there = moved_poses(SKELETON, at, steps)
    R = there.Rs_parent_part
    np.testing.assert_allclose(R @ np.swapaxes(R, -1, -2), np.tile(np.eye(3), (*R.shape[:2], 1, 1)),
                               atol=1e-12)  # fmt: skip
    led = posed(there).motion_from(at.Rs_parent_part, at.ps_camera_root, backward=False)
    np.testing.assert_allclose(led, steps, atol=1e-9)
    assert there.first_frame == at.first_frame


# --- jerk


VARYING = pytest.mark.parametrize("varying", [False, True], ids=["one sigma", "by frame"])


@cache
def _slope_of_jerk(turn_rad: float, varying: bool) -> Floats:
    return difference(jerk(varying=varying).cost, motion(turn_rad))


@cache
def _slopes_of_jerk(turn_rad: float, varying: bool) -> Floats:
    """(N D, ·) what every motion of every pose does to the residuals."""
    link, at = jerk(varying=varying), motion(turn_rad)
    rows = []
    for j in range(FRAMES):
        for d in range(DOFS):
            x = np.zeros((FRAMES, DOFS))
            x[j, d] = 1e-6
            ahead, behind = (link.of(moved_poses(SKELETON, at, s * x)) for s in (1, -1))
            rows.append(((ahead - behind) / 2e-6 / link.sigma[..., None]).ravel())
    return np.array(rows)


@SIZES
@UNKNOWN
@VARYING
def test_the_gradient_of_jerk_is_that_of_its_cost(
    turn_rad: float, unknown: slice, varying: bool
) -> None:
    link, at = jerk(varying=varying), motion(turn_rad)
    _, b = equations(link, at, unknown)
    expected = _slope_of_jerk(turn_rad, varying)[unknown]
    np.testing.assert_allclose(b, expected, atol=1e-6 * np.abs(expected).max())


@SIZES
@UNKNOWN
@VARYING
def test_the_equations_of_jerk_are_the_products_of_its_slopes(
    turn_rad: float, unknown: slice, varying: bool
) -> None:
    link, at, J = jerk(varying=varying), motion(turn_rad), _slopes_of_jerk(turn_rad, varying)
    of = np.arange(FRAMES * DOFS).reshape(FRAMES, DOFS)[unknown].ravel()
    banded, _ = equations(link, at, unknown)
    assert banded.shape == (len(of), 4 * DOFS)
    expected = (J @ J.T)[np.ix_(of, of)]
    np.testing.assert_allclose(dense(banded), expected, atol=1e-6 * np.abs(expected).max())


def test_free_flight_has_no_jerk() -> None:
    s = np.arange(FRAMES)[:, None] / 30.0
    root = np.array([0.1, -0.2, 4.0]) + s * [0.5, -2.0, 0.3] + s**2 * [0.0, 4.9, 0.0]
    still = np.tile(motion(0.3).Rs_parent_part[:1], (FRAMES, 1, 1, 1))
    assert jerk().cost(Trajectory(0, still, root)) < 1e-12


def test_jerk_is_the_same_in_seconds_whatever_the_frame_rate() -> None:
    def swinging(fps: float) -> Trajectory:
        s = np.arange(int(fps)) / fps
        root = np.column_stack([0.1 * np.sin(6 * s), 0 * s, 4 + 0 * s])
        return Trajectory(0, np.tile(np.eye(3), (len(s), SKELETON.part_count, 1, 1)), root)

    slow, fast = (np.abs(jerk(fps).of(swinging(fps))).max() for fps in (60.0, 240.0))
    assert slow == pytest.approx(0.1 * 6**3, rel=0.02)
    assert fast == pytest.approx(slow, rel=0.02)


# --- steps and evenness


def _steps(at: Trajectory) -> Link:
    measured = increments(SKELETON, at)
    rng = np.random.default_rng(5)
    off = rng.normal(0, 1e-4, measured.shape)
    return Increments(SKELETON, measured + off, rng.uniform(1, 9e4, measured.shape), Cauchy(0.01))


def _even(at: Trajectory) -> Link:
    wanted = second_differences(SKELETON, at)
    rng = np.random.default_rng(6)
    off = rng.normal(0, 1e-4, wanted.shape)
    return Smoothness(SKELETON, wanted + off, rng.uniform(1, 9e4, wanted.shape), SQUARED)


@cache
def _slope_of_small_steps(make: Callable[[Trajectory], Link]) -> Floats:
    at = motion(1e-4, shift_m=1e-4)
    return difference(make(at).cost, at)


@UNKNOWN
@pytest.mark.parametrize("make", [_steps, _even], ids=["steps", "evenness"])
def test_links_have_the_gradient_of_small_steps(
    make: Callable[[Trajectory], Link], unknown: slice
) -> None:
    at = motion(1e-4, shift_m=1e-4)
    _, b = equations(make(at), at, unknown)
    expected = _slope_of_small_steps(make)[unknown]
    np.testing.assert_allclose(b, expected, atol=2e-3 * np.abs(expected).max())


@UNKNOWN
@pytest.mark.parametrize("make", [_steps, _even], ids=["steps", "evenness"])
def test_the_equations_of_some_poses_are_those_of_all_without_the_others(
    make: Callable[[Trajectory], Link], unknown: slice
) -> None:
    at = motion(0.3)
    link = make(at)
    every, b = equations(link, at)
    some, own = equations(link, at, unknown)
    of = np.arange(FRAMES * DOFS).reshape(FRAMES, DOFS)[unknown].ravel()
    np.testing.assert_array_equal(dense(some), dense(every)[np.ix_(of, of)])
    np.testing.assert_array_equal(own, b[unknown])
    assert np.linalg.eigvalsh(dense(every)).min() > -1e-9 * np.abs(every).max()


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_in_up_to_three_frames_there_is_no_jerk_but_there_are_steps(frames: int) -> None:
    at = motion(0.1, frames)
    banded, b = equations(jerk(), at)
    assert not banded.any()
    assert not b.any()
    link = Increments(SKELETON, increments(SKELETON, at), np.ones((frames - 1, DOFS)), SQUARED)
    found = dense(equations(link, at)[0])
    assert np.linalg.matrix_rank(found) == (frames - 1) * DOFS
    even = Smoothness.even(SKELETON, frames, np.ones(DOFS))
    found = dense(equations(even, at)[0])
    assert np.linalg.matrix_rank(found) == max(frames - 2, 0) * DOFS


# --- what frames share

PLACE = BodyPoints(SKELETON, (((FOOT, (0.0, 0.07, -0.12)),),))
UP = np.array([0.1, -0.98, 0.2]) / np.linalg.norm([0.1, -0.98, 0.2])
WAYS = np.linalg.svd(UP[None])[2][1:]
SHARED = np.array([0.3, 0.2, 3.9, 0.0, 0.9, 4.1, -0.8])
TERMS: dict[str, SharedTerm] = {
    "at one place": AtOnePlace(PLACE, slice(1, 5), 3, 0.004, SQUARED),
    "at one place, far ones pulling no harder": AtOnePlace(
        PLACE, slice(0, FRAMES), 0, 0.004, Huber(10.0)
    ),
    "on a floor that is level": OnFloor(3, Floor(UP, np.zeros((0, 3)), np.zeros(3)), 0.07, 0.008),
    "on a floor that tilts": OnFloor(0, Floor(UP, WAYS, np.array([0.2, 0.5, 4.0])), 0.0, 0.008),
    "near": Near(SHARED + 0.1, np.linspace(0.03, 100.0, 7)),
}
"""Every term of shared unknowns. One that is added goes here."""


def point(name: str, at: Trajectory, shared: Floats = SHARED) -> MotionPoint:
    """A motion and what its frames share, compared by one term."""
    problem = MotionProblem(SKELETON, unknown=EVERY, shared_terms=(TERMS[name],))
    return problem.at(MotionState(at, shared), 0)


def whole(found: MotionPoint) -> Floats:
    """The matrix of all poses and all that is shared."""
    solved = found.equations
    top = np.hstack([dense(solved.rows), solved.border])
    return np.vstack([top, np.hstack([solved.border.T, solved.corner])])


@SIZES
@pytest.mark.parametrize("name", TERMS)
def test_the_gradient_of_what_is_shared_is_that_of_its_cost(name: str, turn_rad: float) -> None:
    at = motion(turn_rad)
    found = point(name, at).equations
    expected = difference(lambda there: point(name, there).cost, at).ravel()
    np.testing.assert_allclose(found.b, expected, atol=2e-6 * max(np.abs(expected).max(), 1.0))
    slope = np.zeros(len(SHARED))
    for k in range(len(SHARED)):
        e = 1e-6 * np.eye(len(SHARED))[k]
        ahead, behind = (point(name, at, SHARED + sign * e).cost for sign in (1, -1))
        slope[k] = (ahead - behind) / 2e-6
    np.testing.assert_allclose(found.gradient, slope, atol=2e-6 * max(np.abs(slope).max(), 1.0))


@SIZES
@pytest.mark.parametrize("name", TERMS)
def test_the_equations_of_what_is_shared_are_symmetric_and_no_saddle(
    name: str, turn_rad: float
) -> None:
    A = whole(point(name, motion(turn_rad)))
    np.testing.assert_allclose(A, A.T, atol=1e-9 * np.abs(A).max())
    assert np.linalg.eigvalsh(A).min() > -1e-9 * np.abs(A).max()
    assert np.abs(A).max() > 0


def test_shared_equations_of_places_are_those_of_their_slopes() -> None:
    """With squares the second differences over pose and place are the border's, to first order."""
    name, at = "at one place", motion(0.3)
    border = point(name, at).equations.border
    for k in range(len(SHARED)):
        e = np.zeros(len(SHARED))
        e[k] = 1e-3
        ahead, behind = (point(name, at, SHARED + s * e).equations.b for s in (1, -1))
        np.testing.assert_allclose(
            border[:, k], (ahead - behind) / 2e-3, atol=1e-6 * np.abs(border).max()
        )
