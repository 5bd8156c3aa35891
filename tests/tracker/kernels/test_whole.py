"""The whole segment's system: banded sums against a dense assembly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.kernels.whole import add_smoothness, move_inner, see_all, whole_segment
from keypose.tracker.tracking.scene import Scene
from tests.tracker import reference_loops as plain
from tests.tracker.tracking_cases import (
    CAMERAS,
    HEIGHT,
    WIDTH,
    random_body,
    random_trajectory,
    scene_of,
    smooth_picture,
)

Floats = NDArray[np.float64]

every_camera = pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)


def dense_of(banded: Floats) -> Floats:
    """The full symmetric matrix of an upper banded form."""
    width, size = banded.shape
    A = np.zeros((size, size))
    for row in range(size):
        for column in range(row, min(size, row + width)):
            A[row, column] = A[column, row] = banded[width - 1 + row - column, column]
    return A


@dataclass(frozen=True, eq=False)
class Problem:
    """A random segment with textures of its two keyframes."""

    scene: Scene
    path: Trajectory
    pictures: NDArray[np.float32]
    chosen: NDArray[np.int32]
    grey: NDArray[np.float32]
    starts: NDArray[np.int64]
    seen: NDArray[np.uint8]


def problem(camera: Camera, n: int, seed: int) -> Problem:
    skeleton = random_body(seed, parts=3)
    scene = scene_of(skeleton, camera)
    rng = np.random.default_rng([seed, 7])
    size = len(scene.points.points)
    chosen = np.stack([np.arange(k, size, 9, dtype=np.int32)[: size // 10] for k in range(2)])
    starts = np.stack([np.searchsorted(row, scene.points.starts) for row in chosen])
    starts[:, -1] = chosen.shape[1]
    return Problem(
        scene,
        random_trajectory(skeleton, seed, n + 1),
        np.stack([smooth_picture(seed + k) for k in range(n + 3)]),
        chosen,
        rng.normal(120, 20, chosen.shape).astype(np.float32),
        starts,
        (rng.random((n + 1, size)) < 0.7).astype(np.uint8),
    )


def filled(p: Problem, sigma: Floats, smooth: Floats) -> tuple[Floats, Floats]:
    n, dofs = len(p.path) - 1, p.scene.skeleton.dof_count
    banded, gradient = np.empty((3 * dofs, (n - 1) * dofs)), np.empty((n - 1) * dofs)
    whole_segment(
        p.scene.arrays, p.scene.lens, p.pictures, np.arange(1, n + 2), p.path.Rs_parent_part,
        p.path.ps_camera_root, p.chosen, p.grey, p.starts, p.seen, 0.05, smooth,
        sigma, banded, gradient,
    )  # fmt: skip
    return dense_of(banded), gradient


def dense(p: Problem, sigma: Floats, smooth: Floats) -> tuple[Floats, Floats, Floats]:
    """The same written out frame by frame; and the new noise of the residuals."""
    n, body, below = len(p.path) - 1, p.scene.arrays, p.scene.skeleton.below
    dofs, parts = p.scene.skeleton.dof_count, p.scene.skeleton.part_count
    A, b = plain.smoothness(body, p.path.Rs_parent_part, p.path.ps_camera_root, smooth)
    noise = sigma.copy()
    for j in range(1, n):
        HR, Ho = plain.place_parts(body, p.path.Rs_parent_part[j], p.path.ps_camera_root[j])
        S = plain.camera_twists(body, HR, Ho - Ho[0])
        here = slice((j - 1) * dofs, j * dofs)
        for end, share in enumerate((1 - j / n, j / n)):
            rows = plain.rows_of(
                body, p.chosen[end], p.grey[end].astype(float), HR, Ho, Ho[0], p.pictures[j + 1],
                p.scene.lens, p.seen[j] == 1,
            )  # fmt: skip
            N = plain.sum_points(rows, parts, "tukey", 4.685 * sigma[end, j], gain=True)
            noise[end, j] = plain.robust_sigma(rows.r)
            weight = share * 0.05 / noise[end, j] ** 2
            frame = plain.normal_equations(body, below, N * weight, S)
            A[here, here] += frame[0]
            b[here] += frame[1]
    return A, b, noise


@every_camera
@pytest.mark.parametrize("n", [2, 3, 6])
def test_the_banded_system_is_the_dense_one(camera: Camera, n: int) -> None:
    p = problem(camera, n, seed=n)
    rng = np.random.default_rng(n)
    dofs = p.scene.skeleton.dof_count
    sigma = rng.uniform(8, 14, (2, n + 1))
    smooth = rng.uniform(100, 3000, dofs)
    A, b, noise = dense(p, sigma, smooth)
    found_A, found_b = filled(p, sigma, smooth)
    np.testing.assert_allclose(sigma, noise, rtol=0.02)
    size = np.sqrt(np.diag(A))
    assert (np.abs(found_A - A) / np.outer(size, size)).max() < 0.04  # the noise is of a histogram
    assert np.abs(found_b - b).max() < 0.04 * np.abs(b).max()
    step = np.linalg.solve(A + np.diag(1e-3 * size**2), b)
    found = np.linalg.solve(found_A + np.diag(1e-3 * size**2), found_b)
    assert np.linalg.norm(found - step) < 0.1 * np.linalg.norm(step)


@pytest.mark.parametrize("n", [2, 3, 8])
def test_smoothness_is_the_square_of_second_differences_along_the_whole_segment(n: int) -> None:
    skeleton = random_body(4)
    body, path = scene_of(skeleton).arrays, random_trajectory(skeleton, 4, n + 1)
    dofs = skeleton.dof_count
    precision = np.random.default_rng(4).uniform(1, 9, dofs)
    banded, gradient = np.zeros((3 * dofs, (n - 1) * dofs)), np.zeros((n - 1) * dofs)
    add_smoothness(body, path.Rs_parent_part, path.ps_camera_root, precision, banded, gradient)
    A, b = plain.smoothness(body, path.Rs_parent_part, path.ps_camera_root, precision)
    np.testing.assert_allclose(dense_of(banded), A, atol=1e-10)
    np.testing.assert_allclose(gradient, b, atol=1e-10)


def test_steps_of_smoothness_alone_straighten_a_bent_path() -> None:
    skeleton = random_body(5)
    body, path = scene_of(skeleton).arrays, random_trajectory(skeleton, 5, 12, size=0.02)
    R, t = path.Rs_parent_part.copy(), path.ps_camera_root.copy()
    dofs = skeleton.dof_count

    def bend() -> float:
        _, b = plain.smoothness(body, R, t, np.ones(dofs))
        return float(np.abs(b).max())

    before = bend()
    for _ in range(5):
        banded, gradient = np.zeros((3 * dofs, 10 * dofs)), np.zeros(10 * dofs)
        add_smoothness(body, R, t, np.ones(dofs), banded, gradient)
        banded[-1] += 1e-9
        move_inner(body, R, t, -solveh_banded(banded, gradient).reshape(10, dofs))
    assert bend() < 0.02 * before
    for k in (0, -1):
        np.testing.assert_array_equal(R[k], path.Rs_parent_part[k])
        np.testing.assert_array_equal(t[k], path.ps_camera_root[k])


def test_what_every_frame_shows_is_what_each_pose_alone_shows() -> None:
    p = problem(CAMERAS["perspective"], 4, seed=6)
    scene, path = p.scene, p.path
    seen = np.zeros((5, len(scene.points.points)), np.uint8)
    see_all(
        scene.arrays, scene.lens, scene.visibility, WIDTH, HEIGHT, path.Rs_parent_part,
        path.ps_camera_root, seen,
    )  # fmt: skip
    for j in range(5):
        HR, Ho = plain.place_parts(scene.arrays, path.Rs_parent_part[j], path.ps_camera_root[j])
        _, twin = plain.see(scene.arrays, HR, Ho, scene.lens, scene.visibility, WIDTH, HEIGHT)
        assert ((seen[j] == 1) != twin).sum() <= 3
