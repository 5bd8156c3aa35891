"""What is laid out before anything is fitted: mesh, placing, points, binding, weights."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.shapes import Box, Frustum
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.kernels.cells import grid_of
from keypose.tracker.session.settings import UpAxis
from keypose.tracker.surface.fit.model import (
    SurfaceModel,
    SurfaceSamples,
    distances_to_parts,
    shares_of,
    with_all_rotations,
)
from keypose.tracker.surface.fit.options import Options
from keypose.tracker.surface.fit.pairing import (
    LEAST_SHARE,
    clearance,
    contact_weights,
    photo_weights,
    raise_to_floor,
)
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.placing import METRES, Placement
from tests.tracker.surface.surfaces import BOXES, ROUND, bent, surface_of, two_bars


def _ball() -> SurfaceMesh:
    """A unit ball: a finely cut box pushed onto the sphere."""
    body = Body(name="one", parts=(two_bars().parts[0],))
    box = surface_of(body, Pose(np.eye(3)[None], np.zeros(3)), pieces=4)
    away = box.vertices - box.vertices.mean(axis=0)
    return SurfaceMesh(away / np.linalg.norm(away, axis=1, keepdims=True), box.faces)


def test_normals_point_outward_with_unit_length() -> None:
    ball = _ball()
    used = np.unique(ball.faces)
    product = (ball.vertices * ball.normals).sum(axis=1)[used]
    assert product.min() > 0.98


def test_a_whole_mesh_has_no_rim_and_a_hole_has_that_of_its_edges() -> None:
    ball = _ball()
    assert len(ball.rim) == 0
    assert len(SurfaceMesh(ball.vertices, ball.faces[1:]).rim) == 3


@pytest.mark.parametrize("up", get_args(UpAxis))
def test_what_is_up_in_the_files_is_up_in_the_camera(up: UpAxis) -> None:
    placement = Placement("cm", up, np.array([0.1, 0.2, 3.0]))
    axis = np.eye(3)["xyz".index(up[1])] * (1 if up[0] == "+" else -1)
    np.testing.assert_allclose(placement.points(100 * axis), [0.1, 0.2 - 1.0, 3.0], atol=1e-12)
    assert np.linalg.det(placement.R_camera_surface) == pytest.approx(1.0)


def test_a_metre_is_a_metre_in_every_unit() -> None:
    for units, metres in METRES.items():
        placed = Placement(units, "+y", np.zeros(3)).points(np.array([1 / metres, 0.0, 0.0]))
        np.testing.assert_allclose(placed, [1.0, 0.0, 0.0])


def test_points_lie_as_densely_on_large_triangles_as_on_small_ones() -> None:
    body = two_bars()
    coarse, fine = (surface_of(body, bent(body, 0.3), pieces) for pieces in (0, 4))
    for mesh in (coarse, fine):
        samples = SurfaceSamples.of(mesh, 4000)
        distances = distances_to_parts(
            Skeleton.of(body), pose_transforms(Skeleton.of(body), bent(body, 0.3)), samples.p
        )
        assert np.abs(distances).min(axis=1).max() < 1e-9
        own = (np.abs(distances) < 1e-9).argmax(axis=1)
        share = (own == 1).mean()
        faces = mesh.vertices[mesh.faces]
        area = np.linalg.norm(
            np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0]), axis=1
        )
        lower = area[len(area) // 2 :].sum() / area.sum()
        assert share == pytest.approx(lower, abs=0.01)
    assert SurfaceSamples.of(coarse, 100).spacing_m == pytest.approx(
        SurfaceSamples.of(fine, 100).spacing_m
    )


def test_normals_of_large_flat_triangles_are_their_own() -> None:
    mesh = surface_of(two_bars(), bent(two_bars(), 0.0), pieces=0)
    samples = SurfaceSamples.of(mesh, 3000)
    assert np.abs(samples.normals).max(axis=1).min() > 0.999


@pytest.mark.parametrize(
    "shape",
    [
        BOXES[0],
        ROUND[1],
        Frustum(start_m=0.0, end_m=-0.4, start_radii_m=(0.1, 0.1), end_radii_m=(0.05, 0.05)),
    ],
)
def test_distances_to_a_solid_are_nought_on_it_and_negative_inside(shape) -> None:
    mesh = shape.mesh()
    surface = mesh.vertices[mesh.faces].mean(axis=1)
    assert np.abs(shape.distance(np.asarray(mesh.vertices[:48]))).max() < 0.101
    assert np.abs(shape.distance(surface)).max() < 0.01  # round ones have 24 sides
    middle = mesh.vertices.mean(axis=0)[None]
    assert shape.distance(middle)[0] < -0.03
    far = middle + np.array([[3.0, 0.0, 0.0]])
    assert shape.distance(far)[0] == pytest.approx(3.0, abs=0.15)


def test_a_point_goes_with_the_nearest_part_and_shares_it_smoothly_about_a_joint() -> None:
    distances = np.array([[0.0, 0.2, 0.5], [0.01, 0.02, 0.5], [0.0, 0.3, 0.001]])
    parents = np.array([-1, 0, 0])
    parts, shares = shares_of(distances, parents, 0.0)
    np.testing.assert_array_equal(parts[:, 0], [0, 0, 0])
    np.testing.assert_allclose(shares, [[1, 0]] * 3)
    _, shares = shares_of(distances, parents, 0.04)
    np.testing.assert_allclose(shares.sum(axis=1), 1.0)
    np.testing.assert_allclose(shares[:, 0], [1.0, 0.625, 0.5125])


def test_a_body_of_one_part_carries_all() -> None:
    parts, shares = shares_of(np.zeros((4, 1)), np.array([-1]), 0.1)
    np.testing.assert_allclose(shares[:, 0], 1.0)
    assert (parts == 0).all()


def test_the_model_lies_on_the_mesh_it_was_made_of_and_moves_with_its_parts() -> None:
    body = two_bars()
    start, other = bent(body, 0.2, (0.3, -0.2, 0.1)), bent(body, 1.0, (0.0, 0.5, 2.9), (0.4, 0, 2))
    model = SurfaceModel.of(surface_of(body, start), body, start, 2000)
    moved = model.posed(pose_transforms(model.skeleton, other)).p
    Ts = pose_transforms(model.skeleton, other)
    distances = distances_to_parts(model.skeleton, Ts, moved)
    assert np.abs(distances[np.arange(len(moved)), model.own]).max() < 1e-9


def test_every_part_of_a_freed_body_turns_in_every_way() -> None:
    skeleton = Skeleton.of(with_all_rotations(two_bars()))
    assert skeleton.dof_count == 9


def test_weights_are_half_at_their_middle_and_switch_in_the_right_direction() -> None:
    clear = contact_weights(np.array([-0.05, 0.0, 0.03, 0.06, np.inf]), 0.03)
    assert clear[2] == pytest.approx(0.5)
    assert clear[0] < clear[1] < 0.01
    assert clear[3] > 0.99
    assert clear[4] == 1.0
    photo = photo_weights(np.array([-1.0, 0.4, 1.0]))
    np.testing.assert_allclose(photo, [0.0, 0.5, 1.0], atol=1e-3)


def test_a_part_wholly_in_contact_keeps_a_least_weight_and_others_theirs() -> None:
    weights = np.array([0.001, 0.003, 1.0, 0.5])
    kept = raise_to_floor(weights, np.array([0, 0, 1, 1]), 2)
    assert kept[:2].mean() == pytest.approx(LEAST_SHARE)
    assert kept[1] > kept[0]
    np.testing.assert_allclose(kept[2:], weights[2:])


def test_only_the_side_that_touches_another_part_counts_less() -> None:
    """SURFACE (1) with the other part's normal: the far side of a thin limb is not inside it."""
    upper, lower = two_bars().parts
    thin = Box(low_m=(-0.04, 0.03, -0.01), high_m=(0.04, 0.45, 0.01))
    at_side = lower.model_copy(update={"shape": thin, "joint_m": (0.0, 0.5, 0.105)})
    body = Body(name="beside", parts=(upper, at_side))
    start = bent(body, 0.0)
    model = SurfaceModel.of(surface_of(body, start), body, start, 3000)

    def clear(pose: Pose):
        posed = model.posed(pose_transforms(model.skeleton, pose))
        grid = grid_of(posed.p, 2 * model.spacing_m)
        return posed, clearance(model, posed, grid, Options(floor=False))

    _, at_rest = clear(start)
    assert at_rest.min() > 0.9
    posed, folded = clear(bent(body, np.pi))
    z = posed.p[:, 2] - 3.0
    middle = (model.own == 1) & (posed.p[:, 1] > 0.1) & (posed.p[:, 1] < 0.4)
    assert folded[middle & (z < 0.096)].mean() < 0.15
    assert folded[middle & (z > 0.114)].min() > 0.9
    assert folded[(model.own == 0) & (z < 0.0)].min() > 0.9
