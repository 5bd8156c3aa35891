"""Residuals, rows and weights: the summing loop against its plain twin and the picture itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose, moved
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.kernels.noise import BINS, capped_square, median_residual, robust_sigma
from keypose.tracker.kernels.pairs import linearise
from keypose.tracker.kernels.robust import HUBER, LEAST_SQUARES, TUKEY
from keypose.tracker.kernels.sums import BLOCK, sum_points
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.video.pyramid import IGNORED
from tests.tracker import reference_loops as plain
from tests.tracker.tracking_cases import (
    CAMERA,
    CAMERAS,
    deep_chain,
    random_body,
    random_pose,
    scene_of,
    smooth_picture,
    waves_at,
)

Floats = NDArray[np.float64]

LOSSES = {"squares": LEAST_SQUARES, "huber": HUBER, "tukey": TUKEY}
every_camera = pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
every_loss = pytest.mark.parametrize("loss", LOSSES)
gain_or_not = pytest.mark.parametrize("gain", [False, True], ids=["plain", "gain"])


@dataclass(frozen=True, eq=False)
class Pair:
    """Points of a body chosen in one picture, and a pose in another."""

    scene: Scene
    pose: Pose
    picture: NDArray[np.int16]
    chosen: NDArray[np.int32]
    grey: NDArray[np.float32]
    starts: NDArray[np.int64]
    seen: NDArray[np.uint8]


def pair(seed: int, camera: Camera, sideways: float = 1.0, masked: bool = True) -> Pair:
    """Every third point of a random body, some of them beside the picture or on ignored pixels."""
    skeleton = random_body(seed, parts=4)
    scene = scene_of(skeleton, camera)
    rng = np.random.default_rng([seed, 3])
    chosen = np.arange(0, len(scene.points.points), 3, dtype=np.int32)
    starts = np.searchsorted(chosen, scene.points.starts)
    pose = random_pose(skeleton, seed)
    place = pose.p_camera_root + (np.array([sideways, 0, 0]))
    picture = smooth_picture(seed)
    if masked:
        picture[:60, :, 3] = IGNORED
        picture[:, :120, 3] //= 2
    grey = rng.normal(120, 15, len(chosen)).astype(np.float32)
    seen = (rng.random(len(scene.points.points)) < 0.7).astype(np.uint8)
    return Pair(scene, Pose(pose.Rs_parent_part, place), picture, chosen, grey, starts, seen)


def summed(
    p: Pair, loss: str, scale: float, gain: bool, need_seen: bool
) -> tuple[Floats, NDArray[np.int32], int]:
    N = np.full((p.scene.skeleton.part_count, 7, 7), np.nan)
    histogram = np.full(BINS, -7, np.int32)
    HR, Ho = plain.place_parts(p.scene.arrays, p.pose.Rs_parent_part, p.pose.p_camera_root)
    count = sum_points(
        p.scene.arrays, p.chosen, p.grey, p.starts, HR, Ho, Ho[0].copy(), p.picture, p.scene.lens,
        p.seen, need_seen, LOSSES[loss], scale, gain, N, histogram,
        np.empty((9, BLOCK), np.float32),
    )  # fmt: skip
    return N, histogram, int(count)


def rows(p: Pair, need_seen: bool = False) -> plain.Rows:
    HR, Ho = plain.place_parts(p.scene.arrays, p.pose.Rs_parent_part, p.pose.p_camera_root)
    seen = p.seen == 1 if need_seen else None
    return plain.rows_of(
        p.scene.arrays, p.chosen, p.grey.astype(float), HR, Ho, Ho[0], p.picture, p.scene.lens, seen
    )


def close(N: Floats, expected: Floats, share: float = 2e-4) -> None:
    """Equal up to a share of what the diagonals allow each entry to be."""
    size = np.sqrt(np.einsum("pii->pi", np.abs(expected)))
    allowed = share * (size[:, :, None] * size[:, None, :]) + 1e-6
    assert (np.abs(N - expected) <= allowed).all()


@every_camera
@every_loss
@gain_or_not
@pytest.mark.parametrize("need_seen", [False, True])
def test_sums_are_those_of_the_twin(camera: Camera, loss: str, gain: bool, need_seen: bool) -> None:
    p = pair(1, camera)
    N, histogram, count = summed(p, loss, 20.0, gain, need_seen)
    expected = rows(p, need_seen)
    assert 300 < count < len(p.chosen)
    assert count == len(expected.r)
    assert (
        np.abs(histogram - plain.histogram(expected.r, expected.lost)).sum() <= 4
    )  # at the borders of bins
    twin = plain.sum_points(expected, len(N), loss, 20.0, gain)
    close(N, twin, share=2e-4 if not gain else 2e-3)
    np.testing.assert_array_equal(N, np.swapaxes(N, 1, 2))


@every_camera
def test_a_part_without_points_sums_to_nothing(camera: Camera) -> None:
    p = pair(2, camera)
    starts = p.starts.copy()
    starts[2:] -= starts[2] - starts[1]
    keep = np.r_[: p.starts[1], p.starts[2] : len(p.chosen)]
    empty = Pair(p.scene, p.pose, p.picture, p.chosen[keep], p.grey[keep], starts, p.seen)
    for gain in (False, True):
        N, _, _ = summed(empty, "huber", 5.0, gain, False)
        np.testing.assert_array_equal(N[1], 0.0)
        assert np.isfinite(N).all()


def test_nothing_is_summed_where_all_is_ignored_or_out_of_the_picture() -> None:
    p = pair(3, CAMERA)
    p.picture[..., 3] = IGNORED
    for gone in (p, pair(3, CAMERA, sideways=50.0)):
        N, histogram, count = summed(gone, "tukey", 5.0, True, False)
        assert count == 0
        assert not histogram[:-1].any()
        assert histogram[-1] == rows(gone).lost
        np.testing.assert_array_equal(N, 0.0)


def test_what_ignored_pixels_show_does_not_matter() -> None:
    p = pair(4, CAMERA)
    before = summed(p, "huber", 10.0, False, False)
    p.picture[:59, :, :3] = 2**15 - 1
    after = summed(p, "huber", 10.0, False, False)
    np.testing.assert_array_equal(before[0], after[0])
    assert before[2] == after[2]


@every_camera
def test_a_gain_and_a_bias_of_the_source_leave_no_gradient(camera: Camera) -> None:
    p = pair(5, camera, sideways=0.0, masked=False)
    HR, Ho = plain.place_parts(p.scene.arrays, p.pose.Rs_parent_part, p.pose.p_camera_root)
    at = plain.project(p.scene.lens, plain.in_camera(p.scene.arrays, HR, Ho, p.chosen))
    shown = plain.bilinear(p.picture, np.clip(at, 0, (CAMERA.width - 1.01, CAMERA.height - 1.01)))
    p.grey[:] = shown[:, 0] * 1.2 - 15
    exact, _, _ = summed(p, "squares", 1.0, True, False)
    plainly, _, _ = summed(p, "squares", 1.0, False, False)
    assert np.abs(plainly[:, :6, 6]).max() > 1e3
    assert np.abs(exact[:, :6, 6]).max() < 2e-3 * np.abs(plainly[:, :6, 6]).max()


@every_camera
@pytest.mark.parametrize("skeleton", [random_body(6), deep_chain(6)], ids=["random", "chain"])
def test_the_rows_are_the_brightness_differences_along_every_degree_of_freedom(
    camera: Camera, skeleton: Skeleton
) -> None:
    scene, dofs = scene_of(skeleton, camera), skeleton.dof_count
    body, pose = scene.arrays, random_pose(skeleton, 7, size=0.4)
    everyone = np.arange(0, len(scene.points.points), 5, dtype=np.int32)

    def shown(at: Pose, chosen: NDArray[np.int32]) -> Floats:
        HR, Ho = plain.place_parts(body, at.Rs_parent_part, at.p_camera_root)
        uv = plain.project(scene.lens, plain.in_camera(body, HR, Ho, chosen))
        return np.asarray(uv)

    uv = shown(pose, everyone)
    chosen = everyone[((uv > 1) & (uv < (CAMERA.width - 2, CAMERA.height - 2))).all(1)]
    assert len(chosen) > 300
    grey, starts = np.zeros(len(chosen), np.float32), np.searchsorted(chosen, body.starts)
    N, histogram = np.empty((skeleton.part_count, 7, 7)), np.empty(BINS, np.int32)
    A, b = np.empty((dofs, dofs)), np.empty(dofs)
    linearise(
        body, chosen, grey, starts, pose.Rs_parent_part, pose.p_camera_root, smooth_picture(7),
        scene.lens, LEAST_SQUARES, 1.0, N, histogram, A, b,
    )  # fmt: skip
    J = np.empty((len(chosen), dofs))
    for d in range(dofs):
        step = np.zeros(dofs)
        step[d] = 1e-5
        ahead, back = (shown(moved(skeleton, pose, x), chosen) for x in (step, -step))
        J[:, d] = (waves_at(7, ahead)[:, 0] - waves_at(7, back)[:, 0]) / 2e-5
    E = waves_at(7, shown(pose, chosen))[:, 0]
    size = np.linalg.norm(J, axis=0)
    assert (np.abs(A - J.T @ J) / np.outer(size, size)).max() < 0.01
    assert (np.abs(b - J.T @ E) / (size * np.linalg.norm(E))).max() < 0.01


def test_the_robust_noise_is_the_median_and_never_below_two_grey_levels() -> None:
    rng = np.random.default_rng(8)
    for spread in (0.5, 3.0, 12.0):
        r = rng.normal(0, spread, 4000)
        r[:400] = 300.0
        counts = plain.histogram(r).astype(np.int32)
        assert median_residual(counts, len(r)) == pytest.approx(np.median(np.abs(r)), abs=0.13)
        assert robust_sigma(counts, len(r)) == pytest.approx(plain.robust_sigma(r), abs=0.2)
    assert robust_sigma(np.zeros(BINS, np.int32), 0) == 10.0
    assert robust_sigma(plain.histogram(np.full(50, 30.0)).astype(np.int32), 50) == 10.0
    all_beyond = plain.histogram(np.full(60, 200.0)).astype(np.int32)
    assert robust_sigma(all_beyond, 60) > 80


def test_the_capped_square_stops_growing_at_the_cap() -> None:
    r = np.random.default_rng(9).normal(0, 10, 5000)
    counts = plain.histogram(r).astype(np.int32)
    found = capped_square(counts, len(r), 15.0)
    assert found == pytest.approx(plain.capped_square(r, 15.0))
    assert found == pytest.approx(np.minimum(r**2, 225).mean(), rel=0.01)
    far = plain.histogram(np.full(10, 250.0)).astype(np.int32)
    assert capped_square(far, 10, 15.0) == 225.0
    assert capped_square(np.zeros(BINS, np.int32), 0, 15.0) == 0.0
