"""Posed bodies as pixels, against what geometry says of simple shapes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import Body, Part
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import BodyMesh, Raster, raster
from keypose.tracker.body.shapes import Box, Cylinder, Shape
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import apply_transform, rotation_from_euler, transform
from keypose.tracker.geometry.view import ViewCamera

CAMERA = Camera(width=200, height=160, fx=300.0, fy=310.0, cx=97.3, cy=81.6)
TELEPHOTO = CAMERA.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 4.0})
CUBE = Box(low_m=(-0.3, -0.3, -0.3), high_m=(0.3, 0.3, 0.3))


def single(shape: Shape) -> Skeleton:
    return Skeleton.of(Body(name="one", parts=(Part(name="block", shape=shape),)))


def two_cubes(p_second: tuple[float, float, float]) -> Skeleton:
    first = Part(name="first", shape=CUBE)
    second = Part(name="second", parent="first", joint_m=p_second, shape=CUBE)
    return Skeleton.of(Body(name="two", parts=(first, second)))


def seen(
    skeleton: Skeleton, view: ViewCamera, R: NDArray[np.float64], p: tuple[float, ...]
) -> Raster:
    rotations = np.concatenate([R[None], np.tile(np.eye(3), (skeleton.part_count - 1, 1, 1))])
    pose = Pose(rotations, np.array(p))
    return raster(BodyMesh.of(skeleton), pose_transforms(skeleton, pose), view)


def convex_hull_mask(uv: NDArray[np.float64], width: int, height: int) -> NDArray[np.bool_]:
    """Pixels whose centre lies on the inner side of every edge of the points' convex hull."""
    pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)
    inside = np.ones((height, width), dtype=bool)
    for a in uv:
        for b in uv:
            side = _turn(b - a, uv - a)
            if np.any(a != b) and side.min() >= -1e-9:
                inside &= _turn(b - a, pixels - a) >= 0
    return inside


def _turn(direction: NDArray[np.float64], to: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(direction[0] * to[..., 1] - direction[1] * to[..., 0])


def corners(low: float, high: float) -> NDArray[np.float64]:
    return np.array([(x, y, z) for x in (low, high) for y in (low, high) for z in (low, high)])


@pytest.mark.parametrize("camera", [CAMERA, TELEPHOTO])
def test_a_turned_box_covers_exactly_the_hull_of_its_projected_corners(camera: Camera) -> None:
    R, p = rotation_from_euler(0.4, 0.7, -0.3), (0.1, -0.1, 3.5)
    part = seen(single(CUBE), ViewCamera.of(camera), R, p).part
    p_camera = apply_transform(transform(R, np.array(p)), corners(-0.3, 0.3))
    expected = convex_hull_mask(camera.project(p_camera), camera.width, camera.height)
    np.testing.assert_array_equal(part == 0, expected)
    assert expected.sum() > 2000


@pytest.mark.parametrize("camera", [CAMERA, TELEPHOTO])
def test_depth_is_that_of_the_plane_hit_by_the_pixels_ray(camera: Camera) -> None:
    R, p = rotation_from_euler(0.0, 0.6, 0.2), np.array([0.0, 0.0, 3.0])
    picture = seen(single(CUBE), ViewCamera.of(camera), R, tuple(p))
    rows, columns = np.nonzero(picture.part == 0)
    depth = picture.depth[rows, columns].astype(float)
    p_part = (camera.back_project(np.column_stack([columns, rows]), depth) - p) @ R
    assert np.abs(np.abs(p_part).max(axis=1) - 0.3).max() < 1e-5


def test_a_long_cylinder_seen_from_the_side_is_as_wide_as_its_tangents_say() -> None:
    radius, distance = 0.2, 3.0
    skeleton = single(Cylinder(start_m=-2.0, end_m=2.0, radius_m=radius))
    part = seen(skeleton, ViewCamera.of(CAMERA), np.eye(3), (0.0, 0.0, distance)).part
    tangent = radius / np.sqrt(distance**2 - radius**2)
    width = (part[80] == 0).sum()
    assert width == pytest.approx(2 * CAMERA.fx * tangent, abs=1.5)


def test_the_nearer_part_hides_the_farther_one_whatever_their_order() -> None:
    view = ViewCamera.of(CAMERA)
    for z, nearer in ((1.0, 0), (-1.0, 1)):
        picture = seen(two_cubes((0.1, 0.0, z)), view, np.eye(3), (0.0, 0.0, 4.0))
        row, column = round(CAMERA.cy), round(CAMERA.cx)
        assert picture.part[row, column] == nearer
        assert picture.depth[row, column] == pytest.approx(3.7 + min(z, 0.0), abs=1e-4)


def test_faces_belong_to_the_part_that_is_seen() -> None:
    skeleton = two_cubes((0.7, 0.0, 0.2))
    picture = seen(skeleton, ViewCamera.of(CAMERA), np.eye(3), (-0.3, 0.0, 4.0))
    drawn = picture.part >= 0
    face_part = BodyMesh.of(skeleton).face_part
    np.testing.assert_array_equal(face_part[picture.face[drawn]], picture.part[drawn])
    assert (picture.face[~drawn] == -1).all()
    assert np.isinf(picture.depth[~drawn]).all()
    assert set(np.unique(picture.part)) == {-1, 0, 1}


def test_an_orthographic_view_does_not_depend_on_distance() -> None:
    R = rotation_from_euler(0.3, 0.5, 0.1)
    view = ViewCamera.orthographic("front", np.array([0.0, 0.0, 3.0]), 100.0, (120, 100))
    near = seen(single(CUBE), view, R, (0.05, 0.0, 3.0))
    far = seen(single(CUBE), view, R, (0.05, 0.0, 40.0))
    np.testing.assert_array_equal(near.part, far.part)
    drawn = near.part >= 0
    np.testing.assert_allclose(far.depth[drawn] - near.depth[drawn], 37.0, atol=1e-4)


@pytest.mark.parametrize(
    ("view", "axis", "sign", "right", "down"),
    [
        ("front", 2, 1, (0, 1), (1, 1)),
        ("top", 1, 1, (0, 1), (2, -1)),
        ("side", 0, -1, (2, 1), (1, 1)),
    ],
)
def test_every_view_looks_along_its_axis(
    view: str, axis: int, sign: int, right: tuple[int, int], down: tuple[int, int]
) -> None:
    centre = np.array([0.3, -0.2, 5.0])
    eye = ViewCamera.orthographic(view, centre, 100.0, (81, 61))  # type: ignore[arg-type]
    for (named, direction), expected in ((right, (1.0, 0.0)), (down, (0.0, 1.0))):
        step = np.eye(3)[named] * direction
        p_eye = apply_transform(eye.T_view_camera, np.array([centre, centre + 0.1 * step]))
        uv = eye.project(p_eye)
        np.testing.assert_allclose(uv[0], (40.0, 30.0), atol=1e-9)
        np.testing.assert_allclose(uv[1] - uv[0], 10.0 * np.array(expected), atol=1e-9)
    ahead = apply_transform(eye.T_view_camera, (centre + sign * np.eye(3)[axis])[None])[0]
    np.testing.assert_allclose(ahead, (0.0, 0.0, 1.0), atol=1e-12)


def test_a_body_partly_behind_the_camera_is_cut_off_and_the_rest_is_drawn() -> None:
    skeleton = single(Box(low_m=(-0.2, 0.1, -3.0), high_m=(0.2, 0.2, 3.0)))
    picture = seen(skeleton, ViewCamera.of(CAMERA), np.eye(3), (0.0, 0.0, 1.0))
    drawn = picture.part >= 0
    horizon = np.nonzero(drawn.any(axis=1))[0].min()
    assert horizon == np.ceil(CAMERA.cy + CAMERA.fy * 0.1 / 4.0)
    assert drawn[-1].all()
    assert np.nanmin(picture.depth) >= 0.05 - 1e-6


@pytest.mark.parametrize("p", [(50.0, 0.0, 4.0), (0.0, 0.0, -4.0), (0.0, -1e6, 4.0)])
def test_a_body_out_of_the_picture_leaves_it_empty(p: tuple[float, float, float]) -> None:
    picture = seen(single(CUBE), ViewCamera.of(CAMERA), np.eye(3), p)
    assert (picture.part == -1).all()
    assert np.isinf(picture.depth).all()


def test_the_camera_inside_a_part_sees_its_inner_side() -> None:
    picture = seen(single(CUBE), ViewCamera.of(CAMERA), np.eye(3), (0.0, 0.0, 0.0))
    assert picture.depth[80, 97] == pytest.approx(0.3, abs=1e-5)


def test_sizes_and_types_are_as_promised() -> None:
    picture = seen(single(CUBE), ViewCamera.of(CAMERA), np.eye(3), (0.0, 0.0, 4.0))
    for values, dtype in ((picture.part, "i2"), (picture.face, "i4"), (picture.depth, "f4")):
        assert values.shape == (160, 200)
        assert values.dtype == np.dtype(dtype)


def test_an_eye_resampled_or_cropped_sees_the_same_directions() -> None:
    view = ViewCamera.of(CAMERA)
    p = np.array([[0.2, -0.1, 2.0], [-0.3, 0.2, 3.0]])
    fine = view.resized(600, 480).cropped(30, 60, 100, 100)
    np.testing.assert_allclose(fine.project(p), (view.project(p) + 0.5) * 3 - 0.5 - (30, 60))
    np.testing.assert_allclose(fine.back_project(fine.project(p), p[:, 2]), p)
