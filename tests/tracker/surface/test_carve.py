"""Photo hulls: what the pictures show to be empty is taken away, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.cameras import carve
from keypose.tracker.surface.cameras.carve import (
    STRIDE,
    carve_field,
    carve_seen_through,
    depth_maps,
)
from keypose.tracker.surface.cameras.hull import hull_field, hull_mesh
from tests.rendering.arm_bodies import arm_mesh, arms_body
from tests.rendering.arm_motions import P_CENTRE, arm_poses
from tests.rendering.arms import shots_of
from tests.rendering.ring import ring_of
from tests.tracker.surface.ball_cases import pictures, silhouettes, studio

VOXEL_M = 0.02
STEP = 5


def far_from_arms(p: Array) -> Array:
    """(N,) metres to the nearest of the tripod's true arms, by their many true points."""
    body, pose = arms_body("tripod"), arm_poses("tripod")[STEP]
    mesh, rng = arm_mesh("tripod"), np.random.default_rng(0)
    corners = mesh.vertices[mesh.faces[rng.integers(0, len(mesh.faces), 40_000)]]
    shares = rng.dirichlet((1, 1, 1), len(corners))
    points = np.einsum("nk,nki->ni", shares, corners)
    Ts = pose_transforms(Skeleton.of(body), pose)
    cloud = np.concatenate([points @ T[:3, :3].T + T[:3, 3] for T in Ts])
    return np.asarray(cKDTree(cloud).query(p)[0])


def test_phantom_volume_that_cameras_see_through_is_carved_and_the_arms_stay(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(carve, "STRIDE", 4)  # coarser depths do, in a quarter of the time
    views = ring_of(15, P_CENTRE)
    shots = shots_of("tripod", arm_poses("tripod")[STEP], views, [0, STEP])
    visual = hull_field(views, silhouettes(shots), VOXEL_M)
    photo = carve_field(visual, views, pictures(shots))
    far = [(far_from_arms(hull_mesh(field).vertices) > 0.02).sum() for field in (visual, photo)]
    assert far[0] > 100
    assert far[1] < 0.5 * far[0]
    taken = np.argwhere((visual.depths > 0) & (photo.depths <= 0))
    places = visual.p_origin + VOXEL_M * taken
    assert np.median(far_from_arms(places)) > 0.01  # it was not skin


def test_depths_are_found_to_about_a_pixels_size() -> None:
    views, shots = studio(9)
    field = hull_field(views, silhouettes(shots), VOXEL_M)
    maps = depth_maps(field, views, pictures(shots))
    pixel_m = 3.4 / views[0].camera.fx
    for depths, shot in zip(maps, shots, strict=True):
        true = shot.depth[::STRIDE, ::STRIDE]
        found = np.isfinite(depths) & np.isfinite(true)
        assert found.sum() > 0.25 * np.isfinite(true).sum()
        assert np.median(np.abs(depths[found] - true[found])) < 1.5 * pixel_m


def test_what_one_view_alone_sees_through_stays() -> None:
    views, shots = studio(9)
    field = hull_field(views, silhouettes(shots), VOXEL_M)
    far_away = [np.full(shot.depth.shape, np.inf, np.float32) for shot in shots]
    far_away[0] = np.full_like(far_away[0], 99.0)
    one = carve_seen_through(field, views, far_away, 1, 0.02)
    np.testing.assert_array_equal(one.depths, field.depths)
    far_away[1] = far_away[0]
    assert not (carve_seen_through(field, views, far_away, 1, 0.02).depths > 0).any()
