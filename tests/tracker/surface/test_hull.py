"""Visual hulls: what all silhouettes have in common."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.errors import SurfaceError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.cameras.hull import (
    LIMIT_VOXELS,
    Silhouette,
    focus_of,
    hull_field,
    hull_mesh,
    outline_distances,
    touching,
)
from keypose.tracker.surface.cameras.rig import View
from tests.tracker.surface.ball_cases import P_BALL, RADIUS_M, silhouettes, studio
from tests.tracker.surface.test_nets import edge_counts, volume

VOXEL_M = 0.02


def plain_depth(p: Array, views: tuple[View, ...], shapes: list[Silhouette], least: int) -> float:
    """The compiled loop, once more in plain numpy, for one place."""
    depths = []
    for view, shape in zip(views, shapes, strict=True):
        u, v = view.project(p)
        z = view.of_view(p)[2]
        distances = outline_distances(shape)
        height, width = distances.shape
        if not (0 <= u < width - 1 and 0 <= v < height - 1):
            continue
        i, j, s, t = int(v), int(u), u % 1, v % 1
        square = distances[i : i + 2, j : j + 2]
        value = np.array([1 - t, t]) @ square @ np.array([1 - s, s])
        depths.append(value * z / view.camera.fx)
    limit = LIMIT_VOXELS * VOXEL_M
    return float(np.clip(min(depths), -limit, limit)) if len(depths) >= least else -limit


def test_the_hull_of_a_ball_holds_the_ball_and_little_more() -> None:
    views, shots = studio(9)
    mesh = hull_mesh(hull_field(views, silhouettes(shots), VOXEL_M))
    from_middle = np.linalg.norm(mesh.vertices - P_BALL, axis=1)
    assert from_middle.min() > RADIUS_M - 0.01
    assert from_middle.max() < RADIUS_M + 0.12  # below, where no camera looks from
    true = 4 / 3 * np.pi * RADIUS_M**3
    assert true < volume(mesh) < 1.15 * true
    assert edge_counts(mesh) == {2}


def test_the_depth_of_every_place_is_what_plain_geometry_says() -> None:
    views, shots = studio(5)
    shapes = silhouettes(shots)
    field = hull_field(views, shapes, VOXEL_M)
    rng = np.random.default_rng(1)
    for _ in range(40):
        at = tuple(rng.integers(0, n) for n in field.depths.shape)
        p = field.p_origin + VOXEL_M * np.array(at)
        expected = plain_depth(p, views, shapes, 3)
        # A cell that surely is outside is not looked into.
        assert field.depths[at] == pytest.approx(expected, abs=1e-5) or expected < 0


def test_what_is_outside_a_picture_is_no_evidence() -> None:
    views, shots = studio(9)
    shapes = silhouettes(shots)
    half = shots[0].inside.shape[1] // 2  # the first camera's picture ends amid the ball
    narrow = views[0].camera.model_copy(update={"width": half})
    views = (replace(views[0], camera=narrow), *views[1:])
    shapes[0] = Silhouette(shapes[0].inside[:, :half])
    mesh = hull_mesh(hull_field(views, shapes, VOXEL_M))
    assert np.ptp(mesh.vertices, axis=0).min() > 1.9 * RADIUS_M


def test_where_a_picture_cannot_tell_it_takes_nothing_away() -> None:
    views, shots = studio(9)
    shapes = silhouettes(shots)
    known = np.ones(shots[0].inside.shape, bool)
    known[:, :320] = False
    shapes[0] = Silhouette(shapes[0].inside & known, known)
    mesh = hull_mesh(hull_field(views, shapes, VOXEL_M))
    assert np.ptp(mesh.vertices, axis=0).min() > 1.9 * RADIUS_M


def test_two_things_are_two_pieces_and_a_speck_is_none() -> None:
    views, shots = studio(9, ((-0.5, 0.0, 0.0), (0.5, 0.0, 0.0)))
    shapes = silhouettes(shots)
    p_speck = P_BALL + np.array([0.0, -0.5, 0.0])
    for view, shape in zip(views, shapes, strict=True):
        u, v = np.rint(view.project(p_speck)).astype(int)
        shape.inside[v - 5 : v + 6, u - 5 : u + 6] = True
    mesh = hull_mesh(hull_field(views, shapes, VOXEL_M))
    pieces = np.unique(np.sign(mesh.vertices[:, 0]))
    assert len(pieces) == 2
    assert mesh.vertices[:, 1].min() > P_BALL[1] - RADIUS_M - 0.05


def test_silhouettes_that_have_nothing_in_common_are_reported_in_a_sentence() -> None:
    views, shots = studio(5)
    shapes = silhouettes(shots)
    shapes[2] = Silhouette(np.zeros_like(shapes[2].inside))
    with pytest.raises(SurfaceError, match="No place lies within all silhouettes"):
        hull_field(views, shapes, VOXEL_M)


def test_one_silhouette_makes_no_hull() -> None:
    views, shots = studio(5)
    with pytest.raises(SurfaceError, match="at least 2"):
        hull_field(views[:1], silhouettes(shots[:1]), VOXEL_M)


def test_voxels_too_fine_for_the_memory_are_refused_before_it_is_taken() -> None:
    views, shots = studio(5)
    with pytest.raises(SurfaceError, match="choose larger"):
        hull_field(views, silhouettes(shots), 0.0006)


def test_the_place_looked_at_is_where_the_axes_meet() -> None:
    views, _ = studio(9)
    p, reach_m = focus_of(views)
    np.testing.assert_allclose(p, P_BALL, atol=1e-4)
    assert reach_m == pytest.approx(3.4, rel=0.1)


def test_cells_touch_also_at_their_corners() -> None:
    cells = np.array([(0, 0, 0), (1, 1, 1), (5, 0, 0), (5, 1, 0), (9, 9, 9)])
    pieces = touching(cells)
    assert pieces[0] == pieces[1]
    assert pieces[2] == pieces[3]
    assert len(set(pieces.tolist())) == 3
