"""One frame pair and one pass: the loops against dense matrices."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose, moved
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.kernels.layout import Lens
from keypose.tracker.kernels.pairs import (
    FIRST_WIDTH,
    doubts,
    follow_pairs,
    mean_capped_square,
    observe_pairs,
    predict_by_velocity,
    scaled_lens,
    shortened,
    solve_pair,
)
from keypose.tracker.tracking.scene import Scene
from tests.tracker import reference_loops as plain
from tests.tracker.tracking_cases import (
    CAMERAS,
    HEIGHT,
    WIDTH,
    random_body,
    random_pose,
    random_trajectory,
    scene_of,
    smooth_picture,
)

Floats = NDArray[np.float64]

every_camera = pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)


def pictures(count: int, seed: int) -> NDArray[np.int16]:
    """Pictures that shift a little from one to the next, with a corner that is ignored."""
    base = smooth_picture(seed, WIDTH + count, HEIGHT)
    moving = np.stack([base[:, k : k + WIDTH] for k in range(count)])
    moving[:, :30, :60, 3] = 0.0
    return np.ascontiguousarray(moving)


def followed(
    scene: Scene, pose: Pose, picture: NDArray[np.int16], of: int
) -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.int64]]:
    """Points that a pose shows in a picture, their brightness there, and the parts' borders."""
    HR, Ho = plain.place_parts(scene.arrays, pose.Rs_parent_part, pose.p_camera_root)
    uvz, seen = plain.see(scene.arrays, HR, Ho, scene.lens, scene.visibility, WIDTH, HEIGHT)
    picked, starts = plain.pick(scene.arrays, uvz.astype(np.float32), seen, picture, 1.0, of, 1)
    chosen = np.array(picked, np.int32)
    grey = plain.bilinear(picture, uvz[chosen, :2])[:, 0].astype(np.float32)
    return chosen, grey, np.array(starts)


def rows(
    scene: Scene, chosen: NDArray[np.int32], grey: NDArray[np.float32], pose: Pose,
    picture: NDArray[np.int16],
) -> tuple[plain.Rows, Floats]:  # fmt: skip
    """The rows at a target pose, and the dense A of them."""
    HR, Ho = plain.place_parts(scene.arrays, pose.Rs_parent_part, pose.p_camera_root)
    made = plain.rows_of(
        scene.arrays, chosen, grey.astype(float), HR, Ho, Ho[0], picture, scene.lens
    )
    S = plain.camera_twists(scene.arrays, HR, Ho - Ho[0])
    return made, plain.dense_jacobian(scene.arrays, scene.skeleton.below, made, S)


@every_camera
def test_one_robust_solve_is_the_dense_least_squares_under_the_prior(camera: Camera) -> None:
    skeleton = random_body(1)
    scene, pose = scene_of(skeleton, camera), random_pose(skeleton, 1)
    first, second = pictures(2, seed=1)
    chosen, grey, starts = followed(scene, pose, first, of=2)
    start = np.random.default_rng(1).normal(0, 0.005, skeleton.dof_count)
    R, t, x = pose.Rs_parent_part.copy(), pose.p_camera_root.copy(), start.copy()
    prior = scene.prior(2)
    args = (chosen, grey, starts, R, t, x, second, scene.lens, prior)
    factor = np.empty((skeleton.dof_count, skeleton.dof_count))
    score = solve_pair(scene.arrays, *args, 1, 0.0, factor)
    made, J = rows(scene, chosen, grey, pose, second)
    w = plain.weights_of(made.r, "huber", 20.0)
    q = prior.information / plain.robust_sigma(made.r) ** 2
    A = q * J.T @ (w[:, None] * J) + np.diag(prior.precision)
    step = -np.linalg.solve(A, q * J.T @ (w * made.r) + prior.precision * start)
    assert np.linalg.norm(step) > 1e-3
    turned = np.empty(skeleton.part_count)
    shifted = doubts(scene.arrays, prior.precision, factor, turned)
    share = np.diag(np.linalg.inv(A)) * prior.precision
    turns, part = skeleton.dof_turns == 1, skeleton.dof_part
    for i in range(skeleton.part_count):
        mine = share[turns & (part == i)]
        assert turned[i] == pytest.approx(mine.mean() if len(mine) else 1.0, rel=0.02)
    assert shifted == pytest.approx(share[~turns].mean(), rel=0.02)
    assert 0 < turned.min() < 0.9
    np.testing.assert_allclose(x - start, step, atol=0.02 * np.abs(step).max())
    expected = moved(skeleton, pose, x - start)
    np.testing.assert_allclose(R, expected.Rs_parent_part, atol=1e-10)
    np.testing.assert_allclose(t, expected.p_camera_root, atol=1e-10)
    assert score == pytest.approx(plain.capped_square(made.r, 15.0), rel=0.01)


@every_camera
@pytest.mark.parametrize("of", [1, 2, 4])
def test_the_score_of_a_trajectory_is_the_twins(camera: Camera, of: int) -> None:
    skeleton = random_body(2)
    scene, path = scene_of(skeleton, camera), random_trajectory(skeleton, 2, 4)
    shown = pictures(6, seed=2)
    found = mean_capped_square(
        scene.arrays, scene.lens, scene.visibility, shown, np.arange(1, 5), path.Rs_parent_part,
        path.ps_camera_root, of, 15.0,
    )  # fmt: skip
    scores = []
    for j in range(3):
        HR, Ho = plain.place_parts(scene.arrays, path.Rs_parent_part[j], path.ps_camera_root[j])
        uvz, seen = plain.see(scene.arrays, HR, Ho, scene.lens, scene.visibility, WIDTH, HEIGHT)
        picked, _ = plain.pick(scene.arrays, uvz.astype(np.float32), seen, shown[j + 1], 1.0, of, 1)
        chosen = np.array(picked, np.int32)
        grey = plain.bilinear(shown[j + 1], uvz[chosen, :2])[:, 0].astype(np.float32)
        made, _ = rows(scene, chosen, grey, path.pose(j + 1), shown[j + 2])
        scores.append(plain.capped_square(made.r, 15.0))
    assert found == pytest.approx(np.mean(scores), rel=0.02)
    assert found > 1.0


def test_every_pair_of_a_pass_is_solved_from_the_trajectory_alone() -> None:
    skeleton = random_body(3)
    scene, path = scene_of(skeleton), random_trajectory(skeleton, 3, 6)
    shown = pictures(6, seed=3)

    def motions(first: int, last: int) -> tuple[Floats, Floats]:
        R, t = np.empty((last - first, 5, 3, 3)), np.empty((last - first, 3))
        turned, shifted = np.empty((last - first, 5)), np.empty(last - first)
        follow_pairs(
            scene.arrays, scene.lens, scene.visibility, scene.prior(4), shown,
            np.arange(first, last + 1), path.Rs_parent_part[first : last + 1],
            path.ps_camera_root[first : last + 1], 4, 5, 1e-3, R, t, turned,
            shifted,
        )  # fmt: skip
        return R, t

    whole, part = motions(0, 5), motions(2, 4)
    np.testing.assert_array_equal(whole[0][2:4], part[0])
    np.testing.assert_array_equal(whole[1][2:4], part[1])


@every_camera
def test_what_a_trajectory_gives_is_that_of_the_dense_rows(camera: Camera) -> None:
    skeleton = random_body(4)
    scene, path = scene_of(skeleton, camera), random_trajectory(skeleton, 4, 3)
    shown = pictures(3, seed=4)
    dofs, parts = skeleton.dof_count, skeleton.part_count
    A, residual = np.empty((2, dofs, dofs)), np.empty((2, parts))
    count, sigma = np.empty((2, parts), np.int64), np.empty(2)
    observe_pairs(
        scene.arrays, scene.lens, scene.visibility, shown, np.arange(3), path.Rs_parent_part,
        path.ps_camera_root, A, residual, count, sigma,
    )  # fmt: skip
    for j in range(2):
        chosen, grey, starts = followed(scene, path.pose(j), shown[j], of=1)
        made, J = rows(scene, chosen, grey, path.pose(j + 1), shown[j + 1])
        assert np.abs(count[j] - np.diff(starts)).max() <= 3
        assert sigma[j] == pytest.approx(plain.robust_sigma(made.r), rel=0.03)
        w = plain.weights_of(made.r, "huber", FIRST_WIDTH)[:, None]
        dense = J.T @ (w * J)
        size = np.sqrt(np.diag(dense))
        assert (np.abs(A[j] - dense) / np.outer(size, size)).max() < 0.01
        for i in range(parts):
            r = made.r[made.part == i]
            if len(r) == np.diff(starts)[i] and len(r) > 50:
                weighed = plain.weights_of(r, "huber", FIRST_WIDTH) * r**2
                assert residual[j, i] == pytest.approx(np.sqrt(np.mean(weighed)), rel=0.02)


def test_the_last_motion_goes_on_where_nothing_else_is_known() -> None:
    turn, step = exp_rotation([0.1, -0.2, 0.05]), np.array([0.01, 0.0, -0.02])
    R, t = np.full((4, 1, 3, 3), np.nan), np.full((4, 3), np.nan)
    R[0, 0], t[0] = exp_rotation([0.3, 0.2, 0.1]), (0.0, 0.1, 3.0)
    predict_by_velocity(R, t, 0)
    np.testing.assert_array_equal(R[1], R[0])
    np.testing.assert_array_equal(t[1], t[0])
    R[1, 0], t[1] = R[0, 0] @ turn, t[0] + step
    for j in (1, 2):
        predict_by_velocity(R, t, j)
    np.testing.assert_allclose(R[3, 0], R[0, 0] @ turn @ turn @ turn, atol=1e-13)
    np.testing.assert_allclose(t[3], t[0] + 3 * step, atol=1e-13)


def test_a_long_step_is_shortened_as_a_whole_and_one_that_is_none_is_said() -> None:
    step = np.array([0.2, -2.0, 1.0])
    assert shortened(step, 0.5) == 2.0
    np.testing.assert_allclose(step, [0.05, -0.5, 0.25])
    short = np.array([0.1, -0.2])
    assert shortened(short, 0.5) == 0.2
    np.testing.assert_array_equal(short, [0.1, -0.2])
    for none in (np.nan, np.inf, -np.inf):
        assert shortened(np.array([0.0, none]), 0.5) == -1.0
    assert shortened(np.empty(0), 0.5) == 0.0


def test_a_halved_lens_projects_to_halved_pixels() -> None:
    p = np.array([[0.3, -0.2, 2.0], [-0.1, 0.4, 4.0]])
    for camera in CAMERAS.values():
        lens = scene_of(random_body(0, parts=1), camera).lens
        half = scaled_lens(lens, 0.5)
        assert isinstance(half, Lens)
        np.testing.assert_allclose(plain.project(half, p), plain.project(lens, p) / 2)


def test_a_trajectory_of_wild_numbers_harms_nothing_but_itself() -> None:
    skeleton = random_body(5)
    scene = scene_of(skeleton)
    path = random_trajectory(skeleton, 5, 4)
    ps = path.ps_camera_root.copy()
    ps[1], ps[2] = np.nan, (0.0, 0.0, -1e8)
    wild = Trajectory(0, path.Rs_parent_part, ps)
    found = mean_capped_square(
        scene.arrays, scene.lens, scene.visibility, pictures(4, 5), np.arange(4),
        wild.Rs_parent_part, wild.ps_camera_root, 4, 15.0,
    )  # fmt: skip
    assert np.isfinite(found)
