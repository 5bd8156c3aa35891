"""Prepared pictures: brightness, its gradient, and what may not be used."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.kernels.layout import STEPS
from keypose.tracker.kernels.noise import BINS
from keypose.tracker.kernels.robust import HUBER
from keypose.tracker.kernels.sums import BLOCK, sum_points
from keypose.tracker.video.pyramid import (
    BLUR_PX,
    IGNORED,
    LEVELS,
    TARGET_ONLY,
    USABLE,
    Clip,
    Picture,
    in_grey_levels,
    level_sizes,
    prepare,
)
from tests.tracker import reference_loops as plain
from tests.tracker.tracking_cases import WIDTH, random_body, random_pose, scene_of

Grey = NDArray[np.uint8]


def ramp(du: float, dv: float, width: int = 96, height: int = 64) -> Grey:
    rows, columns = np.mgrid[0:height, 0:width]
    return np.rint(20 + du * columns + dv * rows).astype(np.uint8)


@pytest.mark.parametrize(("du", "dv"), [(2.0, 0.0), (0.0, 3.0), (1.0, 1.0), (1.0, 2.0)])
def test_the_gradient_of_a_ramp_is_its_slope_at_every_level(du: float, dv: float) -> None:
    for level, picture in enumerate(prepare(ramp(du, dv), None, LEVELS)):
        inner = in_grey_levels(picture)[6:-6, 6:-6]
        np.testing.assert_allclose(inner[..., 1], du * 2**level, atol=2e-3)
        np.testing.assert_allclose(inner[..., 2], dv * 2**level, atol=2e-3)


def test_the_gradient_is_that_of_the_blurred_brightness() -> None:
    noise = np.random.default_rng(0).integers(0, 256, (60, 80)).astype(np.uint8)
    grey = cv2.GaussianBlur(noise, (0, 0), 3.0)
    for picture in map(in_grey_levels, prepare(np.asarray(grey), None, 2)):
        E = picture[..., 0]
        du, dv = (E[1:-1, 2:] - E[1:-1, :-2]) / 2, (E[2:, 1:-1] - E[:-2, 1:-1]) / 2
        spread = np.std(du)
        assert np.abs(picture[1:-1, 1:-1, 1] - du).max() < 0.25 * spread
        assert np.abs(picture[1:-1, 1:-1, 2] - dv).max() < 0.25 * spread


@pytest.mark.parametrize("size", [(96, 64), (97, 63), (5, 5), (320, 180)])
def test_every_level_has_the_size_that_is_reported(size: tuple[int, int]) -> None:
    pictures = prepare(ramp(1.0, 0.0, *size), None, LEVELS)
    assert [p.shape for p in pictures] == [(*s, 4) for s in level_sizes(*size, LEVELS)]
    assert all(p.dtype == np.int16 and (p[..., 3] == USABLE).all() for p in pictures)


@pytest.mark.parametrize("pattern", ["checks", "columns", "rows", "noise"])
def test_the_strongest_contrast_fits_a_picture_and_is_kept_to_a_part_of_a_grey_level(
    pattern: str,
) -> None:
    rows, columns = np.mgrid[0:64, 0:96]
    patterns = {
        "checks": rows // 4 + columns // 4, "columns": columns // 2, "rows": rows,
        "noise": np.random.default_rng(2).integers(0, 2, rows.shape),
    }  # fmt: skip
    grey = (255 * (patterns[pattern] % 2)).astype(np.uint8)
    blurred = cv2.GaussianBlur(grey.astype(np.float32), (0, 0), BLUR_PX)
    picture = in_grey_levels(prepare(grey, None, 1)[0])
    exact = [blurred, *(cv2.Scharr(blurred, -1, du, 1 - du, scale=1 / 32) for du in (1, 0))]
    assert np.abs(picture[..., :3] - np.stack(exact, axis=-1)).max() <= 1 / STEPS


def test_a_pixel_of_a_coarser_level_lies_on_every_second_of_the_finer_one() -> None:
    rows, columns = np.mgrid[0:80, 0:120]
    spot = 250 * np.exp(-((columns - 56) ** 2 + (rows - 32) ** 2) / (2 * 6.0**2))
    for level, picture in enumerate(prepare(spot.astype(np.uint8), None, LEVELS)):
        E = picture[..., 0].astype(float)
        v, u = np.mgrid[0 : E.shape[0], 0 : E.shape[1]]
        middle = np.array([(E * u).sum(), (E * v).sum()]) / E.sum()
        np.testing.assert_allclose(middle * 2**level, (56, 32), atol=0.15)


def test_around_what_is_ignored_a_rim_is_ignored_and_background_stays_a_target() -> None:
    usable = np.full((64, 96), USABLE, np.uint8)
    usable[30, 40] = IGNORED
    usable[:, 80:] = TARGET_ONLY
    use = prepare(ramp(1, 0), usable, LEVELS)[0][..., 3]
    far = np.maximum(*np.abs(np.mgrid[0:64, 0:96] - np.array([30, 40])[:, None, None]))
    assert (use[far <= 2] == IGNORED).all()
    assert (use[(far > 6) & (usable == USABLE)] == USABLE).all()
    assert (use[(far > 6) & (usable == TARGET_ONLY)] == TARGET_ONLY).all()
    for level, picture in enumerate(prepare(ramp(1, 0), usable, LEVELS)):
        near = far[:: 2**level, :: 2**level] <= 2
        assert (picture[..., 3][near] == IGNORED).all()


def two_coverings() -> tuple[list[Picture], list[Picture]]:
    """One picture, black in one and white in the other where both are ignored, at all levels."""
    grey = np.random.default_rng(1).integers(60, 180, (120, WIDTH)).astype(np.uint8)
    usable = np.full(grey.shape, USABLE, np.uint8)
    usable[40:80, 50:90] = IGNORED
    dark, light = grey.copy(), grey.copy()
    dark[usable == IGNORED], light[usable == IGNORED] = 0, 255
    return prepare(dark, usable, LEVELS), prepare(light, usable, LEVELS)


def test_what_is_covered_shines_through_in_traces_only() -> None:
    for dark, light in zip(*two_coverings(), strict=True):
        used = dark[..., 3] > 0
        assert used.any()
        assert np.abs(in_grey_levels(dark) - in_grey_levels(light))[used].max() < 0.02 * 255


def test_what_is_covered_does_not_move_the_body() -> None:
    dark, light = (pyramid[0] for pyramid in two_coverings())
    scene = scene_of(random_body(1))
    pose = random_pose(scene.skeleton, 1)
    HR, Ho = plain.place_parts(scene.arrays, pose.Rs_parent_part, pose.p_camera_root)
    sums = []
    for picture in (dark, light):
        size, parts = len(scene.points.points), scene.skeleton.part_count
        N, histogram = np.empty((parts, 7, 7)), np.empty(BINS, np.int32)
        count = sum_points(
            scene.arrays, np.arange(size, dtype=np.int32), np.full(size, 120, np.float32),
            scene.points.starts, HR, Ho, Ho[0], picture, scene.lens, np.empty(0, np.uint8), False,
            HUBER, 10.0, False, N, histogram, np.empty((9, BLOCK), np.float32),
        )  # fmt: skip
        assert 0 < count < size
        sums.append(N.sum(axis=0))
    gradient = np.abs(sums[0] - sums[1])[:6, 6] / np.sqrt(np.diag(sums[0])[:6] * sums[0][6, 6])
    assert gradient.max() < 1e-3


def test_a_clip_knows_where_its_frames_lie() -> None:
    clip = Clip(7, (np.zeros((5, 4, 4, 4), np.int16),))
    assert len(clip) == 5
    np.testing.assert_array_equal(clip.slots(8, 10), [1, 2, 3])
