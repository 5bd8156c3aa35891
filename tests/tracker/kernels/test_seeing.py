"""Which points are seen and which are followed: the loops against their plain twins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import Body, Part
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.shapes import Box
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.kernels.pairs import scaled_lens
from keypose.tracker.kernels.seeing import brightness, pick, see
from keypose.tracker.tracking.scene import Scene, lens_of
from keypose.tracker.video.pyramid import IGNORED, TARGET_ONLY
from tests.tracker import reference_loops as plain
from tests.tracker.tracking_cases import (
    CAMERA,
    CAMERAS,
    HEIGHT,
    WIDTH,
    random_body,
    random_pose,
    scene_of,
    smooth_picture,
)

Floats = NDArray[np.float64]

every_camera = pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
every_place = pytest.mark.parametrize("sideways", [0.0, 0.9])


@dataclass(frozen=True, eq=False)
class Seen:
    """What a pose shows."""

    uvz: NDArray[np.float32]
    seen: NDArray[np.uint8]
    count: int


def looked_at(scene: Scene, pose: Pose) -> Seen:
    size, cell = len(scene.points.points), scene.visibility.cell
    cells = (HEIGHT // cell + 2, WIDTH // cell + 2)
    uvz, seen = np.full((size, 3), np.nan, np.float32), np.zeros(size, np.uint8)
    HR, Ho = plain.place_parts(scene.arrays, pose.Rs_parent_part, pose.p_camera_root)
    count = see(
        scene.arrays, HR, Ho, scene.lens, scene.visibility, WIDTH, HEIGHT, uvz, seen,
        np.empty(cells, np.float32), np.empty(cells, np.int16),
    )  # fmt: skip
    return Seen(uvz, seen, int(count))


def followed(
    scene: Scene, shown: Seen, picture: NDArray[np.int16], scale: float, of: int, every: int
) -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.int64]]:
    size = len(scene.points.points)
    chosen, grey = np.empty(size + 1, np.int32), np.empty(size + 1, np.float32)
    starts = np.empty(scene.skeleton.part_count + 1, np.int64)
    count = pick(
        scene.arrays, shown.uvz, shown.seen, picture, scaled_lens(scene.lens, scale), scale,
        of, every, chosen, grey, starts,
    )  # fmt: skip
    return chosen[:count], grey[:count], starts


def aside(pose: Pose, sideways: float) -> Pose:
    """The pose moved towards the picture's edge, so that some of the body leaves it."""
    return Pose(pose.Rs_parent_part, pose.p_camera_root + np.array([sideways, 0.0, 0.0]))


@every_camera
@every_place
@pytest.mark.parametrize("seed", range(4))
def test_the_same_points_are_seen_as_by_the_twin(
    camera: Camera, sideways: float, seed: int
) -> None:
    skeleton = random_body(seed, parts=1 + 2 * seed)
    pose = aside(random_pose(skeleton, seed), sideways)
    scene = scene_of(skeleton, camera)
    shown = looked_at(scene, pose)
    HR, Ho = plain.place_parts(scene.arrays, pose.Rs_parent_part, pose.p_camera_root)
    uvz, seen = plain.see(scene.arrays, HR, Ho, scene.lens, scene.visibility, WIDTH, HEIGHT)
    differ = (shown.seen == 1) != seen
    assert differ.sum() <= 3  # single precision, at the very border of a rule
    both = seen & ~differ
    assert 200 < both.sum() < 0.8 * len(seen)
    np.testing.assert_allclose(shown.uvz[both], uvz[both], atol=1e-3)
    assert shown.count == shown.seen.sum()


def test_a_wall_before_the_body_hides_it_and_a_wall_behind_does_not() -> None:
    cube = Box(low_m=(-0.2, -0.2, -0.2), high_m=(0.2, 0.2, 0.2))
    wall = Box(low_m=(-0.5, -0.5, -0.02), high_m=(0.5, 0.5, 0.02))
    for z, hidden in ((-0.6, True), (0.6, False)):
        parts = (
            Part(name="cube", shape=cube),
            Part(name="wall", parent="cube", joint_m=(0.0, 0.0, z), shape=wall),
        )
        skeleton = Skeleton.of(Body(name="two", parts=parts))
        shown = looked_at(scene_of(skeleton), Pose.rest(skeleton, (0.0, 0.0, 3.0)))
        starts = scene_of(skeleton).points.starts
        seen = shown.seen[: starts[1]].sum()
        assert (seen == 0) == hidden


@pytest.mark.parametrize("z", [-2.0, np.nan])
def test_a_body_that_is_not_before_the_camera_shows_nothing(z: float) -> None:
    skeleton = random_body(1, parts=1)
    pose = Pose(np.eye(3)[None], np.array([0.0, 0.0, z]))
    shown = looked_at(scene_of(skeleton), pose)
    assert shown.count == 0
    assert not shown.seen.any()


@every_camera
@pytest.mark.parametrize("of", [1, 2, 3, 4])
@pytest.mark.parametrize(("scale", "every"), [(1.0, 1), (0.5, 1), (0.25, 4)])
def test_the_same_points_are_picked_as_by_the_twin(
    camera: Camera, of: int, scale: float, every: int
) -> None:
    skeleton = random_body(of)
    scene = scene_of(skeleton, camera)
    shown = looked_at(scene, aside(random_pose(skeleton, of), 0.5))
    picture = smooth_picture(of, round(WIDTH * scale), round(HEIGHT * scale))
    picture[: round(50 * scale), : round(90 * scale), 3] = TARGET_ONLY
    picture[round(70 * scale) :, : round(90 * scale), 3] = IGNORED
    chosen, grey, starts = followed(scene, shown, picture, scale, of, every)
    expected, borders = plain.pick(
        scene.arrays, shown.uvz, shown.seen == 1, picture, scale, of, every
    )
    np.testing.assert_array_equal(chosen, expected)
    np.testing.assert_array_equal(starts, borders)
    uv = np.minimum(shown.uvz[chosen, :2] * scale, (picture.shape[1] - 1.01, 1e9))
    np.testing.assert_allclose(grey, plain.bilinear(picture, uv.astype(float))[:, 0], atol=0.02)
    assert len(chosen) > 20


def test_nothing_is_picked_from_a_picture_that_may_not_be_a_source() -> None:
    skeleton = random_body(5)
    scene = scene_of(skeleton)
    shown = looked_at(scene, random_pose(skeleton, 5))
    for use in (IGNORED, TARGET_ONLY):
        picture = smooth_picture(5)
        picture[..., 3] = use
        chosen, _, starts = followed(scene, shown, picture, 1.0, 1, 1)
        assert len(chosen) == 0
        assert not starts.any()


def test_brightness_lies_between_its_four_pixels() -> None:
    picture = smooth_picture(6)
    rng = np.random.default_rng(6)
    uv = rng.uniform(0, (CAMERA.width - 1.001, CAMERA.height - 1.001), (100, 2))
    found = [brightness(picture, lens_of(CAMERA), np.float32(u), np.float32(v)) for u, v in uv]
    np.testing.assert_allclose(found, plain.bilinear(picture, uv)[:, 0], atol=0.02)
