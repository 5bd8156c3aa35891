"""Points on the body's surface: where they lie, and which of them a pose shows."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from tests.rendering.scenes import scene
from tests.tracker.tracking_cases import random_body
from tracker.body import Body, Part, preset
from tracker.camera import Camera
from tracker.eye import Eye
from tracker.kernels.chain import place_parts
from tracker.kernels.seeing import see
from tracker.points import SurfacePoints, lay_points, surface_area
from tracker.pose import Pose, pose_transforms
from tracker.raster import BodyMesh, raster
from tracker.scene import FEWEST_POINTS, MOST_POINTS, Scene
from tracker.shapes import Box, Cylinder, Frustum, Shape
from tracker.skeleton import Skeleton

SHAPES: dict[str, Shape] = {
    "box": Box(low_m=(-0.2, 0.0, -0.1), high_m=(0.1, 0.5, 0.3)),
    "cylinder": Cylinder(start_m=-0.1, end_m=0.4, radius_m=0.08),
    "frustum": Frustum(end_m=-0.5, start_radii_m=(0.2, 0.1), end_radii_m=(0.1, 0.15)),
    "sheet": Box(low_m=(-0.3, -0.3, 0.0), high_m=(0.3, 0.3, 0.001)),
}
every_shape = pytest.mark.parametrize("name", SHAPES)


def on(shape: Shape, spacing: float) -> SurfacePoints:
    part = Part(name="one", shape=shape)
    return lay_points(Skeleton.of(Body(name="one", parts=(part,))), spacing)


def planes(shape: Shape) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Outward unit normals (F, 3) of a shape's faces and their distances from the origin (F,)."""
    mesh = shape.mesh()
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals, np.einsum("fi,fi->f", normals, a)


@every_shape
def test_points_lie_on_the_surface_with_outward_unit_normals(name: str) -> None:
    laid = on(SHAPES[name], 0.02)
    normals, distances = planes(SHAPES[name])
    outside = laid.points @ normals.T - distances
    assert outside.max() < 1e-6  # the shapes are convex
    touched = np.abs(outside) < 1e-6
    assert touched.any(axis=1).all()
    along = laid.normals @ normals.T
    assert (np.where(touched, along, -1).max(axis=1) > 0.999).all()
    np.testing.assert_allclose(np.linalg.norm(laid.normals, axis=1), 1.0, atol=1e-6)


@every_shape
@pytest.mark.parametrize("spacing", [0.01, 0.04])
def test_points_are_about_as_far_apart_as_asked_on_every_side(name: str, spacing: float) -> None:
    shape = SHAPES[name]
    laid = on(shape, spacing)
    area = surface_area(Skeleton.of(Body(name="one", parts=(Part(name="one", shape=shape),))))
    assert len(laid.points) == pytest.approx(area / spacing**2, rel=0.01)
    assert laid.spacing_m == spacing
    fine = on(shape, spacing / 3)
    gaps, _ = cKDTree(laid.points).query(fine.points)
    assert gaps.max() < 2.5 * spacing
    assert np.median(gaps) < 0.6 * spacing


def test_points_are_sorted_by_part_and_every_part_has_some() -> None:
    skeleton = Skeleton.of(preset("elderly_female"))
    laid = lay_points(skeleton, 0.03)
    assert laid.starts[0] == 0
    assert laid.starts[-1] == len(laid.points) == len(laid.normals)
    assert (np.diff(laid.starts) >= 8).all()
    for i, part in enumerate(skeleton.body.parts):
        normals, distances = planes(part.shape)
        mine = laid.points[laid.starts[i] : laid.starts[i + 1]]
        assert (mine @ normals.T - distances).max() < 1e-6


def test_neighbours_in_the_list_are_neighbours_on_the_surface() -> None:
    laid = on(SHAPES["box"], 0.01)
    steps = np.linalg.norm(np.diff(laid.points, axis=0), axis=1)
    assert np.median(steps) < 5 * 0.01


def test_laid_points_cannot_be_changed_and_are_laid_alike_every_time() -> None:
    first, second = (lay_points(random_body(1), 0.02) for _ in range(2))
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
def test_points_are_seen_where_the_part_owns_the_pixel(name: str, projection: str) -> None:
    made = scene(name)
    camera = made.camera
    if projection == "telephoto":
        update = {"projection": projection, "telephoto_distance_m": 5.0}
        camera = camera.model_copy(update=update)
    agreed = []
    for frame in (5, 30, 55):
        pose = made.truth.pose(frame)
        here = Scene.of(made.skeleton, camera, [pose])
        parts, size = made.skeleton.part_count, len(here.points.points)
        HR, Ho = np.empty((parts, 3, 3)), np.empty((parts, 3))
        place_parts(here.arrays, pose.Rs_parent_part, pose.p_camera_root, HR, Ho)
        uvz, seen = np.empty((size, 3), np.float32), np.zeros(size, np.uint8)
        cells = (360 // here.sight.cell + 2, 640 // here.sight.cell + 2)
        see(
            here.arrays, HR, Ho, here.lens, here.sight, 640, 360, uvz, seen,
            np.empty(cells, np.float32), np.empty(cells, np.int16),
        )  # fmt: skip
        drawn = raster(BodyMesh.of(made.skeleton), pose_transforms(made.skeleton, pose),
                       Eye.of(camera)).part  # fmt: skip
        whole = drawn.astype(np.float32)
        inner = cv2.dilate(whole, np.ones((5, 5))) == cv2.erode(whole, np.ones((5, 5)))
        part = np.repeat(np.arange(parts), np.diff(here.points.starts))
        columns, rows = np.rint(uvz[seen == 1, :2]).astype(int).T
        clear = inner[rows, columns]
        owner = drawn[rows, columns][clear]
        agreed.append((owner == part[seen == 1][clear]).mean())
        shown = np.bincount(part[seen == 1], minlength=parts)
        pixels = np.bincount(drawn[drawn >= 0], minlength=parts)
        assert (shown[pixels > 150] > 0).all()
    assert min(agreed) >= 0.97
