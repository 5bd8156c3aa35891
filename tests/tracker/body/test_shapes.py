"""What holds for every shape."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import get_args

import cv2
import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, cKDTree

from keypose.tracker.body.body import Body
from keypose.tracker.body.modify import height, resized, scaled, with_height
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.shapes import KINDS, Capsule, Disc, Frustum, Shape, Solid
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.surface_points import sample_points
from keypose.tracker.errors import BodyError
from keypose.tracker.fitting.sizes.proportions import Proportions
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import apply_transform, exp_rotation, transform
from keypose.tracker.geometry.view import ViewCamera
from tests.tracker.shape_cases import SHAPES, every_shape, pair_of, solid_of

Floats = NDArray[np.float64]

CAMERA = Camera(width=320, height=240, fx=300.0, fy=300.0, cx=159.5, cy=119.5)
ROOT = Path(__file__).parents[3]
HOME = "keypose.tracker.body.shapes"
LISTED = set(get_args(get_args(Shape)[0]))
"""What a file may have."""


def test_every_shape_of_the_list_is_among_these() -> None:
    assert {type(shape) for shape in SHAPES.values()} == LISTED


# --- its surface


@every_shape
def test_a_mesh_is_closed_convex_and_faces_outward(shape: Solid) -> None:
    solid = solid_of(shape.mesh())
    assert solid.is_watertight
    assert solid.is_winding_consistent
    outward = np.einsum("fi,fi->f", solid.face_normals, solid.triangles_center - solid.centroid)
    assert np.all(outward > 0)
    assert solid.volume == pytest.approx(ConvexHull(solid.vertices).volume, rel=1e-3)
    assert solid.euler_number == 2


@every_shape
def test_faces_of_one_side_meet_smoothly_and_those_of_two_in_a_crease(shape: Solid) -> None:
    mesh = shape.mesh()
    solid = solid_of(mesh)
    creased = np.diff(mesh.sides[solid.face_adjacency], axis=1)[:, 0] != 0
    angles = np.rad2deg(solid.face_adjacency_angles)
    assert (angles[creased] > 40).all()
    assert (angles[~creased] < 40).all()
    edges = np.sort(mesh.vertices[solid.face_adjacency_edges[creased]].round(9), axis=1)
    lines = np.sort(shape.wireframe().creases.round(9), axis=1)
    assert {tuple(line) for line in lines.reshape(-1, 6)} == {
        tuple(edge) for edge in edges.reshape(-1, 6)
    }


@every_shape
def test_the_distance_is_that_to_the_mesh_and_negative_inside(shape: Solid) -> None:
    """To a hundredth of the width, as the mesh has 24 sides; of ellipses to first order."""
    solid = solid_of(shape.mesh())
    low, high = solid.bounds
    share = np.random.default_rng(3).uniform(-0.4, 1.4, (600, 3))
    points = low + share * (high - low)
    _, off, _ = trimesh.proximity.closest_point_naive(solid, points)
    depth = (points @ solid.face_normals.T - np.sum(
        solid.face_normals * solid.triangles_center, axis=1
    )).max(axis=1)  # fmt: skip
    expected = np.where(depth < 0, -off, off)
    given = shape.distance(points)
    ground = 0.01 * shape.width_m
    assert (np.sign(given) == np.sign(expected))[off > ground].all()
    assert (np.abs(given - expected) < ground + first_order(shape) * off).all()


def first_order(shape: Solid) -> float:
    """The share by which a distance may be wrong: all of it for round and straight sides."""
    flat = isinstance(shape, Capsule) and 2 * shape.radius_m > shape.length_m
    return 0.7 if isinstance(shape, Frustum | Disc) or flat else 0.02


@every_shape
@pytest.mark.parametrize("turn", [(0.3, 0.5, -0.4), (1.4, 0.0, 0.2), (0.0, 0.0, 0.0)])
def test_its_lines_go_around_all_that_is_seen_of_it(shape: Solid, turn: tuple[float, ...]) -> None:
    T = transform(exp_rotation(turn), np.array([0.1, -0.1, 3.0]))
    lines = shape.wireframe(0.001)
    points = np.concatenate([lines.creases.reshape(-1, 3), lines.rings.reshape(-1, 3)])
    hull = cv2.convexHull(seen_at(T, points))
    for uv in seen_at(T, shape.mesh().vertices):
        assert cv2.pointPolygonTest(hull, uv.tolist(), True) > -0.01


def seen_at(T: Floats, points: Floats) -> np.ndarray:
    return np.asarray(CAMERA.project(apply_transform(T, points))).astype(np.float32)


@every_shape
def test_centre_far_end_and_marks_lie_in_the_solid(shape: Solid) -> None:
    low, high = solid_of(shape.mesh()).bounds
    np.testing.assert_allclose(shape.centre, (low + high) / 2, atol=1e-9)
    points = np.array([shape.centre, shape.far_end, *shape.marks()])
    assert (shape.distance(points) < 1e-9).all()
    assert np.linalg.norm(shape.far_end) >= np.abs([low[1], high[1]]).max() - 1e-9
    assert len(shape.marks()) >= 2


@every_shape
@pytest.mark.parametrize("kind", KINDS)
def test_another_shape_in_its_place_is_as_long_and_as_wide(shape: Solid, kind: str) -> None:
    other = KINDS[kind].like(shape)
    assert other.kind == kind
    assert type(other).model_validate_json(other.model_dump_json()) == other
    assert other.length_m == pytest.approx(shape.length_m)
    assert other.width_m == pytest.approx(shape.width_m)
    assert other.centre[1] == pytest.approx(shape.centre[1])
    assert other.span_y == pytest.approx(shape.span_y)


# --- its sizes


@every_shape
def test_a_size_that_is_set_is_that_size_and_no_other_one_changes(shape: Solid) -> None:
    before = {size.key: size.metres for size in shape.sizes()}
    for key, metres in before.items():
        changed = type(shape).model_validate(shape.with_size(key, 1.1 * metres).model_dump())
        after = {size.key: size.metres for size in changed.sizes()}
        assert after == pytest.approx({**before, key: 1.1 * metres})


@every_shape
def test_length_comes_first_and_is_what_the_mesh_extends_along_y(shape: Solid) -> None:
    first = shape.sizes()[0]
    assert first.key == "length"
    low, high = solid_of(shape.mesh()).bounds
    assert first.metres == pytest.approx(shape.length_m) == pytest.approx(high[1] - low[1])
    # the mean over the cross-section's two ends and both directions
    assert shape.width_m <= (high - low)[[0, 2]].max() + 1e-9
    assert shape.width_m >= 2 * min(shape.half_widths(low[1]) + shape.half_widths(high[1])) - 1e-9


@every_shape
def test_the_handle_of_every_size_is_on_the_shape_and_goes_along_with_it(shape: Solid) -> None:
    for size in shape.sizes():
        assert shape.distance(np.array([size.p_part]))[0] < 1e-9
        changed = shape.with_size(size.key, 1.1 * size.metres)
        (new,) = (other for other in changed.sizes() if other.key == size.key)
        if size.key == "length":
            assert new.p_part[1] == pytest.approx(1.1 * size.p_part[1])
        elif not size.key.endswith("radius"):
            axis = 0 if size.key.endswith("width") else 2
            assert abs(new.p_part[axis]) == pytest.approx(1.1 * abs(size.p_part[axis]))


@every_shape
def test_scaled_by_two_ratios_its_whole_surface_is(shape: Solid) -> None:
    bigger = shape.scaled(1.2, 1.1)
    ratios = np.array([1.1, 1.2, 1.1])
    bounds = [solid_of(each.mesh()).bounds for each in (shape, bigger)]
    np.testing.assert_allclose(bounds[1], bounds[0] * ratios, atol=1e-9)
    assert bigger.width_m == pytest.approx(1.1 * shape.width_m)
    for y in (-1.0, 0.0, 0.2, 1.0):
        assert min(shape.half_widths(y)) > 0
        assert bigger.half_widths(1.2 * y) == pytest.approx(1.1 * np.array(shape.half_widths(y)))


# --- in a body


@every_shape
def test_a_body_of_it_survives_the_way_to_a_file_and_back(shape: Solid) -> None:
    body = pair_of(shape)
    noted = body.model_dump(mode="json")
    noted["parts"][0]["shape"]["centre"] = "what another program noted"
    read = Body.model_validate(noted)
    assert Body.model_validate_json(body.model_dump_json()) == body
    assert read.model_dump(mode="json") == noted
    assert read.parts[0].shape.centre == shape.centre


@every_shape
def test_points_can_be_laid_all_over_it(shape: Solid) -> None:
    sampled = sample_points(Skeleton.of(pair_of(shape)), 0.02)
    own = sampled.points[: sampled.starts[1]].astype(np.float64)
    assert np.abs(shape.distance(own)).max() < 0.01 * shape.width_m
    solid = solid_of(shape.mesh())
    assert len(own) == pytest.approx(solid.area / 0.02**2, rel=0.05)
    gaps, _ = cKDTree(own).query(solid.triangles_center)
    assert gaps.max() < 2.5 * 0.02


@every_shape
def test_a_picture_of_it_is_filled_as_its_outline_says(shape: Solid) -> None:
    skeleton = Skeleton.of(pair_of(shape))
    Ts = pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 3.0)))
    shown = raster(BodyMesh.of(skeleton), Ts, ViewCamera.of(CAMERA)).part
    assert set(np.unique(shown)) == {-1, 0, 1, 2}
    filled = np.zeros(shown.shape, np.uint8)
    for T in Ts:
        hull = cv2.convexHull(seen_at(T, shape.mesh().vertices))
        cv2.fillConvexPoly(filled, np.rint(hull).astype(np.int32), 1)
    assert (shown >= 0).sum() == pytest.approx(filled.sum(), rel=0.12)


@every_shape
def test_a_body_of_it_takes_other_sizes(shape: Solid) -> None:
    body = pair_of(shape)
    assert height(with_height(body, 1.5)) == pytest.approx(1.5)
    assert scaled(body, 2.0).parts[1].shape.length_m == pytest.approx(2 * shape.length_m)
    longer = resized(body, "left_limb", length_factor=1.2)
    for i in (1, 2):
        assert longer.parts[i].shape.length_m == pytest.approx(1.2 * shape.length_m)
    assert Proportions.of(body).metres() == pytest.approx([shape.length_m, shape.width_m] * 2)
    with pytest.raises(BodyError, match=r"^This size is not possible: "):
        scaled(body, 1e6)


@every_shape
def test_its_flat_sides_and_the_lines_along_it_lie_on_it_and_face_outward(shape: Solid) -> None:
    middle = shape.mesh().vertices.mean(axis=0)
    for points, normal in shape.mesh().flats():
        assert np.linalg.norm(normal) == pytest.approx(1)
        assert np.ptp(points @ normal) == pytest.approx(0, abs=1e-9)
        assert (points[0] - middle) @ normal > 0
    lines, normals = shape.wireframe().along()
    assert np.isfinite(normals).all()
    has_length = np.linalg.norm(np.ptp(lines, axis=1), axis=1) > 1e-9
    starts = lines[has_length].mean(axis=1)
    assert shape.distance(starts) == pytest.approx(0, abs=0.004)
    assert (shape.distance(starts + 0.01 * normals[has_length]) > 0).all()


def test_nothing_asks_which_shape_it_has_before_it() -> None:
    """Single shapes are named only where bodies are made and the loops warmed up; a further one
    takes its file and its name in the list."""
    makers = {
        "tracker/warming.py",
        "tracker/body/modify.py", "tracker/body/body.py", "tracker/body/preset_names.py",
    }  # fmt: skip
    kinds = {kind.__name__ for kind in LISTED}
    quoted = re.compile("|".join(f"[\"']{kind}[\"']" for kind in KINDS.keys() - {"box"}))
    python = [*(ROOT / "tracker").rglob("*.py"), *(ROOT / "app").rglob("*.py")]
    for path in sorted([*python, *(ROOT / "static").rglob("*.js")]):
        place, text = path.relative_to(ROOT).as_posix(), path.read_text("utf-8")
        if place in makers or place.startswith("tracker/body/shapes/"):
            continue
        assert not quoted.search(text), place
        for node in ast.walk(ast.parse(text)) if path.suffix == ".py" else ():
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(HOME):
                assert not kinds & {alias.name for alias in node.names}, place
