"""From depths on a grid to triangles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.surface.cameras.hull import surface_of
from keypose.tracker.surface.mesh import SurfaceMesh
from tests.tracker.surface.ball_cases import P_BALL, RADIUS_M, ball_field


def volume(mesh: SurfaceMesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float(np.einsum("fi,fi->", np.cross(a, b), c) / 6)


def edge_counts(mesh: SurfaceMesh) -> set[int]:
    ends = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return set(np.unique(ends, axis=0, return_counts=True)[1].tolist())


def test_a_ball_becomes_a_closed_surface_with_its_outside_outward() -> None:
    mesh = surface_of(ball_field(P_BALL, RADIUS_M))
    assert edge_counts(mesh) == {2}
    assert volume(mesh) == pytest.approx(4 / 3 * np.pi * RADIUS_M**3, rel=0.02)
    outward = (mesh.vertices - P_BALL) / RADIUS_M
    assert np.einsum("vi,vi->v", mesh.normals, outward).min() > 0.9


def test_vertices_lie_where_the_depth_is_zero_to_a_small_part_of_a_voxel() -> None:
    mesh = surface_of(ball_field(P_BALL, RADIUS_M, voxel_m=0.03))
    off_m = np.linalg.norm(mesh.vertices - P_BALL, axis=1) - RADIUS_M
    assert np.abs(off_m).max() < 0.1 * 0.03


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_mirrored_thing_is_still_outside_out(axis: int) -> None:
    field = ball_field(P_BALL, RADIUS_M)
    dented = field.depths.copy()
    dented[: len(dented) // 2, :9, : len(dented) // 3] = -0.01
    turned = replace(field, depths=np.ascontiguousarray(np.flip(dented, axis)))
    assert volume(surface_of(turned)) == pytest.approx(
        volume(surface_of(replace(field, depths=dented))), rel=1e-6
    )
