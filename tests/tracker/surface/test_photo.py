"""Photo-consistency: where the cameras agree on how a surface looks, and where they cannot."""

from __future__ import annotations

from itertools import combinations

import cv2
import numpy as np
import pytest

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.cameras.footage import LEAST_COSINE, SPACING_PX, agreement, consistency
from keypose.tracker.surface.cameras.hull import surface_of
from keypose.tracker.surface.cameras.rig import View
from keypose.tracker.surface.mesh import SurfaceMesh
from tests.tracker.surface.ball_cases import P_BALL, RADIUS_M, ball_field, pictures, studio


def ball(radius_m: float = RADIUS_M) -> SurfaceMesh:
    return surface_of(ball_field(P_BALL, radius_m))


def facing(mesh: SurfaceMesh, view: View) -> Array:
    """(V,) cosine between each normal and the way to the view."""
    ways = view.p_world_view - mesh.vertices
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    return np.asarray(np.einsum("vi,vi->v", ways, mesh.normals))


def test_on_the_true_surface_the_cameras_agree_and_beside_it_they_do_not() -> None:
    views, shots = studio(9)
    true, swollen, shrunk = (ball(r) for r in (RADIUS_M, RADIUS_M + 0.06, RADIUS_M - 0.06))
    found = [consistency(mesh, views, pictures(shots)) for mesh in (true, swollen, shrunk)]
    seen = [zncc[zncc > -1] for zncc in found]
    assert np.median(seen[0]) > 0.75
    assert np.median(seen[1]) < 0.25
    assert np.median(seen[2]) < 0.25


def test_what_fewer_than_two_cameras_see_is_worth_nothing() -> None:
    views, shots = studio(9)
    found = agreement(ball(), views, pictures(shots))
    few = found.seen_by < 2
    assert few.any()  # below, where no camera looks from
    assert not few.all()
    assert (found.zncc[few] == -1).all()
    assert (found.zncc[~few] > -1).all()
    alone = agreement(ball(), views[:1], pictures(shots[:1]))
    assert (alone.zncc == -1).all()
    assert (agreement(ball(), [], []).zncc == -1).all()


def test_a_camera_sees_what_turns_to_it_and_nothing_is_before() -> None:
    views, shots = studio(9)
    mesh = ball()
    turned = sum((facing(mesh, view) > LEAST_COSINE + 0.02).astype(int) for view in views)
    at_most = sum((facing(mesh, view) > LEAST_COSINE - 0.02).astype(int) for view in views)
    seen_by = agreement(mesh, views, pictures(shots)).seen_by
    assert (seen_by >= turned).all()
    assert (seen_by <= at_most).all()


def test_what_another_thing_hides_is_not_seen() -> None:
    views, shots = studio(9)
    mesh, view = ball(), views[0]
    between = (2 * P_BALL + view.p_world_view) / 3
    wall = ball_field(between, 0.5, voxel_m=0.05)
    screen = surface_of(wall)
    both = SurfaceMesh(
        np.vstack([mesh.vertices, screen.vertices]),
        np.vstack([mesh.faces, screen.faces + len(mesh.vertices)]),
    )
    front = facing(mesh, view) > 0.8
    free = agreement(mesh, views, pictures(shots)).seen_by[front]
    hidden = agreement(both, views, pictures(shots)).seen_by[: len(mesh.vertices)][front]
    assert (hidden < free).all()


def test_the_mean_over_pairs_is_that_of_the_pairs_taken_one_by_one() -> None:
    views, shots = studio(5)
    mesh = ball()
    found = agreement(mesh, views, pictures(shots))
    for vertex in np.nonzero(found.seen_by >= 2)[0][::200]:
        seeing = [
            _patch(mesh, vertex, view, shot.picture, views)
            for view, shot in zip(views, shots, strict=True)
            if facing(mesh, view)[vertex] > LEAST_COSINE
        ]
        if len(seeing) != found.seen_by[vertex]:
            continue  # at the very limit of what turns to a camera
        pairs = [np.corrcoef(one, other)[0, 1] for one, other in combinations(seeing, 2)]
        assert found.zncc[vertex] == pytest.approx(np.mean(pairs), abs=2e-3)


def _patch(
    mesh: SurfaceMesh, vertex: int, view: View, picture: Array, views: tuple[View, ...]
) -> Array:
    p, normal = mesh.vertices[vertex], mesh.normals[vertex]
    first = np.eye(3)[np.abs(normal).argmin()]
    first = first - normal * (first @ normal)
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    size = np.mean([v.of_view(p)[2] / v.camera.fx for v in views])
    steps = SPACING_PX * size * np.arange(-3, 4)
    places = p + steps[:, None, None] * first + steps[None, :, None] * second
    uv = view.project(places.reshape(-1, 3)).astype(np.float32)
    sampled = cv2.remap(picture.astype(np.float32), uv[None], None, cv2.INTER_LINEAR)
    return np.asarray(sampled[0], np.float64)
