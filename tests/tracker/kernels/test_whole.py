"""The poses of a whole segment: their equations beside those written out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.kernels.whole import compare_textures, see_all
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


@dataclass(frozen=True, eq=False)
class Problem:
    """A random segment of n inner poses with textures of its two keyframes."""

    scene: Scene
    path: Trajectory
    pictures: NDArray[np.int16]
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
        random_trajectory(skeleton, seed, n + 2),
        np.stack([smooth_picture(seed + k) for k in range(n + 4)]),
        chosen,
        rng.normal(120, 20, chosen.shape).astype(np.float32),
        starts,
        (rng.random((n, size)) < 0.7).astype(np.uint8),
    )


def filled(p: Problem, sigma: Floats) -> tuple[Floats, Floats]:
    n, dofs = len(p.seen), p.scene.skeleton.dof_count
    A, b = np.empty((n, dofs, dofs)), np.empty((n, dofs))
    compare_textures(
        p.scene.arrays, p.scene.lens, p.pictures, np.arange(2, n + 2), p.path.Rs_parent_part[1:-1],
        p.path.ps_camera_root[1:-1], p.chosen, p.grey, p.starts, p.seen, 0.05, sigma, A, b,
    )  # fmt: skip
    return A, b


def plainly(p: Problem, sigma: Floats) -> tuple[Floats, Floats, Floats]:
    """The same written out frame by frame; and the new noise of the residuals."""
    n, body, below = len(p.seen), p.scene.arrays, p.scene.skeleton.below
    parts = p.scene.skeleton.part_count
    A, b, noise = [], [], sigma.copy()
    for j in range(n):
        R, t = p.path.Rs_parent_part[j + 1], p.path.ps_camera_root[j + 1]
        HR, Ho = plain.place_parts(body, R, t)
        S = plain.camera_twists(body, HR, Ho - Ho[0])
        of_ends = []
        for end, share in enumerate((1 - (j + 1) / (n + 1), (j + 1) / (n + 1))):
            rows = plain.rows_of(
                body, p.chosen[end], p.grey[end].astype(float), HR, Ho, Ho[0], p.pictures[j + 2],
                p.scene.lens, p.seen[j] == 1,
            )  # fmt: skip
            N = plain.sum_points(rows, parts, "tukey", 4.685 * sigma[end, j], gain=True)
            noise[end, j] = plain.robust_sigma(rows.r)
            weight = share * 0.05 / noise[end, j] ** 2
            of_ends.append(plain.normal_equations(body, below, N * weight, S))
        A.append(sum(frame[0] for frame in of_ends))
        b.append(sum(frame[1] for frame in of_ends))
    return np.array(A), np.array(b), noise


@every_camera
@pytest.mark.parametrize("n", [1, 2, 5])
def test_every_inner_pose_is_compared_with_the_textures_of_both_keyframes(
    camera: Camera, n: int
) -> None:
    p = problem(camera, n, seed=n + 1)
    rng = np.random.default_rng(n + 1)
    sigma = rng.uniform(8, 14, (2, n))
    A, b, noise = plainly(p, sigma)
    found_A, found_b = filled(p, sigma)
    np.testing.assert_allclose(sigma, noise, rtol=0.02)
    for j in range(n):
        size = np.sqrt(np.diag(A[j]))
        off = np.abs(found_A[j] - A[j]) / np.outer(size, size)
        assert off.max() < 0.04  # the noise is of a histogram
        assert np.abs(found_b[j] - b[j]).max() < 0.04 * np.abs(b[j]).max()


def test_what_every_frame_shows_is_what_each_pose_alone_shows() -> None:
    p = problem(CAMERAS["perspective"], 4, seed=6)
    scene, path = p.scene, p.path
    seen = np.zeros((len(path), len(scene.points.points)), np.uint8)
    see_all(
        scene.arrays, scene.lens, scene.visibility, WIDTH, HEIGHT, path.Rs_parent_part,
        path.ps_camera_root, seen,
    )  # fmt: skip
    for j in range(len(path)):
        HR, Ho = plain.place_parts(scene.arrays, path.Rs_parent_part[j], path.ps_camera_root[j])
        _, twin = plain.see(scene.arrays, HR, Ho, scene.lens, scene.visibility, WIDTH, HEIGHT)
        assert ((seen[j] == 1) != twin).sum() <= 3
