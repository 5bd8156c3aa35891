"""Points on the body's surface: where they lie, and which of them a pose shows."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from keypose.tracker.body.body import Body, Part, preset
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.shapes import Box, Capsule, Cylinder, Frustum, Shape
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.surface_points import SurfacePoints, sample_points, surface_area
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.kernels.chain import place_parts
from keypose.tracker.kernels.seeing import see
from keypose.tracker.tracking.scene import FEWEST_POINTS, MOST_POINTS, Scene
from tests.rendering.scenes import scene
from tests.tracker.tracking_cases import random_body

Floats = NDArray[np.float64]

SHAPES: dict[str, Shape] = {
    "box": Box(low_m=(-0.2, 0.0, -0.1), high_m=(0.1, 0.5, 0.3)),
    "cylinder": Cylinder(start_m=-0.1, end_m=0.4, radius_m=0.08),
    "capsule": Capsule(start_m=-0.1, end_m=0.4, radius_m=0.08),
    "frustum": Frustum(end_m=-0.5, start_radii_m=(0.2, 0.1), end_radii_m=(0.1, 0.15)),
    "sheet": Box(low_m=(-0.3, -0.3, 0.0), high_m=(0.3, 0.3, 0.001)),
}
every_shape = pytest.mark.parametrize("name", SHAPES)


def on(shape: Shape, spacing: float) -> SurfacePoints:
    part = Part(name="one", shape=shape)
    return sample_points(Skeleton.of(Body(name="one", parts=(part,))), spacing)


def faces_at(shape: Shape, points: NDArray[np.float32]) -> tuple[Floats, NDArray[np.bool_]]:
    """Outward unit normals (F, 3) of a shape's faces, and on which of them points lie (N, F)."""
    mesh = shape.mesh()
    corners = mesh.vertices[mesh.faces]
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    near = np.abs(points @ normals.T - np.einsum("fi,fi->f", normals, a)) < 1e-6
    for k in range(3):
        inward = np.cross(normals, corners[:, (k + 1) % 3] - corners[:, k])
        inward /= np.linalg.norm(inward, axis=1, keepdims=True)
        near &= points @ inward.T - np.einsum("fi,fi->f", inward, corners[:, k]) > -1e-6
    return normals, near


@every_shape
def test_points_lie_on_the_surface_with_outward_unit_normals(name: str) -> None:
    sampled = on(SHAPES[name], 0.02)
    normals, touched = faces_at(SHAPES[name], sampled.points)
    assert touched.any(axis=1).all()
    along = sampled.normals @ normals.T
    assert (np.where(touched, along, -1).max(axis=1) > 0.999).all()
    middle = SHAPES[name].mesh().vertices.mean(axis=0)
    assert (np.sum(sampled.normals * (sampled.points - middle), axis=1) > 0).all()
    np.testing.assert_allclose(np.linalg.norm(sampled.normals, axis=1), 1.0, atol=1e-6)


@every_shape
@pytest.mark.parametrize("spacing", [0.01, 0.04])
def test_points_are_about_as_far_apart_as_asked_on_every_side(name: str, spacing: float) -> None:
    shape = SHAPES[name]
    sampled = on(shape, spacing)
    area = surface_area(Skeleton.of(Body(name="one", parts=(Part(name="one", shape=shape),))))
    assert len(sampled.points) == pytest.approx(area / spacing**2, rel=0.01)
    assert sampled.spacing_m == spacing
    fine = on(shape, spacing / 3)
    gaps, _ = cKDTree(sampled.points).query(fine.points)
    assert gaps.max() < 2.5 * spacing
    assert np.median(gaps) < 0.6 * spacing


def test_points_are_sorted_by_part_and_every_part_has_some() -> None:
    skeleton = Skeleton.of(preset("elderly_female"))
    sampled = sample_points(skeleton, 0.03)
    assert sampled.starts[0] == 0
    assert sampled.starts[-1] == len(sampled.points) == len(sampled.normals)
    assert (np.diff(sampled.starts) >= 8).all()
    for i, part in enumerate(skeleton.body.parts):
        mine = sampled.points[sampled.starts[i] : sampled.starts[i + 1]]
        assert faces_at(part.shape, mine)[1].any(axis=1).all()


def test_neighbours_in_the_list_are_neighbours_on_the_surface() -> None:
    sampled = on(SHAPES["box"], 0.01)
    steps = np.linalg.norm(np.diff(sampled.points, axis=0), axis=1)
    assert np.median(steps) < 5 * 0.01


def test_laid_points_cannot_be_changed_and_are_laid_alike_every_time() -> None:
    first, second = (sample_points(random_body(1), 0.02) for _ in range(2))
    np.testing.assert_array_equal(first.points, second.points)
    with pytest.raises(ValueError, match="read-only"):
        first.points[0, 0] = 1.0


@pytest.mark.parametrize("depth_m", [1.0, 3.0, 6.0, 40.0])
def test_near_and_far_bodies_have_neither_too_many_points_nor_too_few(depth_m: float) -> None:
    skeleton = Skeleton.of(preset("adult_male"))
    camera = Camera.from_field_of_view(640, 480, 0.9)
    made = Scene.of(skeleton, camera, [Pose.rest(skeleton, (0.0, 0.0, depth_m))])
    spacing_px = made.points.spacing_m / made.pixel_m
    assert len(made.points.points) < 1.02 * MOST_POINTS
    assert len(made.points.points) > 0.98 * FEWEST_POINTS or spacing_px < 1.0
    half = Scene.of(skeleton, camera, [Pose.rest(skeleton, (0.0, 0.0, depth_m))], density=0.5)
    assert len(half.points.points) == pytest.approx(len(made.points.points) / 2, rel=0.02)


@pytest.mark.parametrize("name", ["speech", "stride", "throw", "tumbling_box"])
@pytest.mark.parametrize("projection", ["perspective", "telephoto"])
def test_points_are_seen_where_their_part_owns_the_pixel(name: str, projection: str) -> None:
    made = scene(name)
    camera = made.camera
    if projection == "telephoto":
        update = {"projection": projection, "telephoto_distance_m": 5.0}
        camera = camera.model_copy(update=update)
    for frame in (5, 30, 55):
        pose = made.truth.pose(frame)
        here = Scene.of(made.skeleton, camera, [pose])
        shown = looked_at(here, pose)
        view = ViewCamera.of(camera)
        drawn = raster(BodyMesh.of(made.skeleton), pose_transforms(made.skeleton, pose), view)
        owners = drawn.part.astype(np.float32)
        inner = cv2.dilate(owners, np.ones((5, 5))) == cv2.erode(owners, np.ones((5, 5)))
        columns, rows = np.rint(np.where(shown.inside, shown.uv.T, 0.0)).astype(int)
        clear = shown.inside & inner[rows, columns]
        own = drawn.part[rows, columns] == shown.part
        behind = shown.z - drawn.depth[rows, columns]
        seen = clear & shown.seen
        # sunk a little into its neighbour at a joint, a point still counts as seen
        assert (own | (behind < here.visibility.tolerance))[seen].mean() >= 0.97
        assert own[seen].mean() >= 0.94
        bare = clear & own & (np.abs(behind) < 0.004)
        assert shown.seen[bare].mean() >= 0.95  # all but those at a grazing angle
        pixels = np.bincount(drawn.part[drawn.part >= 0], minlength=made.skeleton.part_count)
        found = np.bincount(shown.part[shown.seen], minlength=made.skeleton.part_count)
        assert (found[pixels > 150] > 0).all()


@dataclass(frozen=True, eq=False)
class Shown:
    """Of every point: its part, pixel and depth, whether it falls into the picture and is seen."""

    part: NDArray[np.int64]
    uv: Floats
    z: Floats
    inside: NDArray[np.bool_]
    seen: NDArray[np.bool_]


def looked_at(here: Scene, pose: Pose) -> Shown:
    parts, size = here.skeleton.part_count, len(here.points.points)
    width, height, cell = here.camera.width, here.camera.height, here.visibility.cell
    HR, Ho = np.empty((parts, 3, 3)), np.empty((parts, 3))
    place_parts(here.arrays, pose.Rs_parent_part, pose.p_camera_root, HR, Ho)
    seen, cells = np.zeros(size, np.uint8), (height // cell + 2, width // cell + 2)
    see(
        here.arrays, HR, Ho, here.lens, here.visibility, width, height,
        np.empty((size, 3), np.float32), seen,
        np.empty(cells, np.float32), np.empty(cells, np.int16),
    )  # fmt: skip
    part = np.repeat(np.arange(parts), np.diff(here.points.starts))
    p = np.einsum("nij,nj->ni", HR[part], here.points.points) + Ho[part]
    uv = here.camera.project(p)
    inside = ((uv > 1) & (uv < (width - 2, height - 2))).all(axis=1)
    return Shown(part, uv, p[:, 2], inside, seen == 1)
