"""The articulated chain's loops against their plain twins and against dense matrices."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose, moved, pose_transforms, twists
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import transform
from keypose.tracker.kernels.chain import (
    camera_twists,
    inverse_diagonal,
    move,
    normal_equations,
    place_parts,
    solve_positive,
    sum_subtrees,
)
from keypose.tracker.kernels.layout import BodyArrays
from tests.tracker import reference_loops as plain
from tests.tracker.tracking_cases import deep_chain, random_body, random_pose, scene_of

Floats = NDArray[np.float64]

BODIES = {
    "one part": random_body(0, parts=1),
    "random": random_body(1),
    "large": random_body(2, parts=12),
    "root fixed": random_body(3, root_dofs=()),
    "chain": deep_chain(),
    "person": Skeleton.of(preset("adult_male")),
}
every_body = pytest.mark.parametrize("name", BODIES)


def placed(body: BodyArrays, pose: Pose) -> tuple[Floats, Floats]:
    HR, Ho = np.empty_like(pose.Rs_parent_part), np.empty((len(pose.Rs_parent_part), 3))
    place_parts(body, pose.Rs_parent_part, pose.p_camera_root, HR, Ho)
    return HR, Ho


def twists_of(body: BodyArrays, HR: Floats, Ho: Floats) -> Floats:
    S = np.empty((len(body.dof_part), 6))
    camera_twists(body, HR, Ho, S)
    return S


def random_sums(parts: int, seed: int) -> Floats:
    """(P, 7, 7) sums of a few random rows for every part."""
    rows = np.random.default_rng(seed).normal(size=(parts, 30, 7))
    return np.swapaxes(rows, 1, 2) @ rows


@every_body
def test_parts_are_placed_as_by_the_twin_and_by_the_chain_of_transforms(name: str) -> None:
    skeleton = BODIES[name]
    body, pose = scene_of(skeleton).arrays, random_pose(skeleton, 1)
    HR, Ho = placed(body, pose)
    np.testing.assert_allclose(transform(HR, Ho), pose_transforms(skeleton, pose), atol=1e-13)
    for mine, twin in zip(
        (HR, Ho), plain.place_parts(body, pose.Rs_parent_part, pose.p_camera_root), strict=True
    ):
        np.testing.assert_allclose(mine, twin, atol=1e-13)


@every_body
def test_twists_are_those_of_the_twin_and_of_the_pose(name: str) -> None:
    skeleton = BODIES[name]
    body, pose = scene_of(skeleton).arrays, random_pose(skeleton, 2)
    HR, Ho = placed(body, pose)
    S = twists_of(body, HR, Ho)
    np.testing.assert_allclose(S, plain.camera_twists(body, HR, Ho), atol=1e-13)
    np.testing.assert_allclose(S, twists(skeleton, pose_transforms(skeleton, pose)), atol=1e-13)


@every_body
def test_a_motion_moves_the_arrays_as_it_moves_the_pose(name: str) -> None:
    skeleton = BODIES[name]
    body, pose = scene_of(skeleton).arrays, random_pose(skeleton, 3)
    motion = np.random.default_rng(4).normal(0, 0.4, skeleton.dof_count)
    R, t = pose.Rs_parent_part.copy(), pose.p_camera_root.copy()
    move(body, R, t, motion)
    expected = moved(skeleton, pose, motion)
    np.testing.assert_allclose(R, expected.Rs_parent_part, atol=1e-12)
    np.testing.assert_allclose(t, expected.p_camera_root, atol=1e-12)


def test_ten_thousand_motions_in_place_leave_rotations() -> None:
    skeleton = BODIES["random"]
    body, pose = scene_of(skeleton).arrays, random_pose(skeleton, 5)
    R, t = pose.Rs_parent_part.copy(), pose.p_camera_root.copy()
    for motion in np.random.default_rng(6).normal(0, 0.05, (10_000, skeleton.dof_count)):
        move(body, R, t, motion)
    np.testing.assert_allclose(
        R @ np.swapaxes(R, 1, 2), np.broadcast_to(np.eye(3), R.shape), atol=1e-13
    )


@every_body
def test_subtree_sums_hold_a_part_and_all_that_hangs_below_it(name: str) -> None:
    skeleton = BODIES[name]
    N = random_sums(skeleton.part_count, 7)
    total = N.copy()
    sum_subtrees(scene_of(skeleton).arrays, total)
    for k in range(skeleton.part_count):
        np.testing.assert_allclose(total[k], N[skeleton.below[:, k]].sum(axis=0), atol=1e-12)


@every_body
def test_normal_equations_from_subtree_sums_are_those_of_the_dense_rows(name: str) -> None:
    skeleton = BODIES[name]
    body, pose = scene_of(skeleton).arrays, random_pose(skeleton, 8)
    HR, Ho = placed(body, pose)
    S = twists_of(body, HR, Ho)
    rng = np.random.default_rng(9)
    part = np.repeat(np.arange(skeleton.part_count), 25)
    rows = plain.Rows(part, rng.normal(size=(len(part), 6)), rng.normal(size=len(part)), part)
    N = plain.sum_points(rows, skeleton.part_count, "squares", 1.0, gain=False)
    twin = plain.normal_equations(body, skeleton.below, N, S)
    sum_subtrees(body, N)
    A, b = np.empty((skeleton.dof_count,) * 2), np.empty(skeleton.dof_count)
    normal_equations(body, N, S, A, b)
    J = plain.dense_jacobian(body, skeleton.below, rows, S)
    np.testing.assert_allclose(A, J.T @ J, atol=1e-9)
    np.testing.assert_allclose(b, J.T @ rows.r, atol=1e-9)
    np.testing.assert_allclose(A, twin[0], atol=1e-9)
    np.testing.assert_allclose(b, twin[1], atol=1e-9)


@pytest.mark.parametrize("size", [0, 1, 2, 7, 23])
def test_a_positive_system_is_solved_as_by_lapack(size: int) -> None:
    rng = np.random.default_rng(size)
    half = rng.normal(size=(size, size))
    A, b = half @ half.T + 0.1 * np.eye(size), rng.normal(size=size)
    x = b.copy()
    assert solve_positive(A.copy(), x)
    np.testing.assert_allclose(x, np.linalg.solve(A, b), rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("size", [0, 1, 2, 7, 23])
def test_the_diagonal_of_an_inverse_is_had_from_the_factor(size: int) -> None:
    rng = np.random.default_rng(size)
    half = rng.normal(size=(size, size))
    A, out = half @ half.T + 0.1 * np.eye(size), np.empty(size)
    expected = np.diag(np.linalg.inv(A))
    assert solve_positive(A, np.zeros(size))
    inverse_diagonal(A, out)
    np.testing.assert_allclose(out, expected, rtol=1e-8)


@pytest.mark.parametrize("diagonal", [(1.0, -1.0, 1.0), (1.0, 0.0, 1.0), (1.0, np.nan, 1.0)])
def test_a_system_that_is_not_positive_is_said_to_be_none(diagonal: tuple[float, ...]) -> None:
    assert not solve_positive(np.diag(diagonal), np.ones(3))
