"""The pose at which two surfaces lie on each other is found, and what cannot be seen is not."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.shapes import Box, Frustum
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation
from keypose.tracker.surface.fit.chain import PointReliability
from keypose.tracker.surface.fit.fitter import fit_solids_to_surface
from keypose.tracker.surface.fit.measuring import measure
from keypose.tracker.surface.fit.model import SurfaceModel
from keypose.tracker.surface.fit.options import Options
from keypose.tracker.surface.fit.pairing import TargetSurface, photo_weights, vertex_scalars
from keypose.tracker.surface.fit.solving import UNSEEN, fit_pose
from keypose.tracker.surface.mesh import SurfaceMesh
from tests.tracker.surface.surfaces import (
    BOXES,
    CAPSULES,
    ROUND,
    bent,
    joints,
    surface_of,
    two_bars,
)

BODY = two_bars()
TAPERING = (
    Frustum(start_m=-0.05, end_m=0.5, start_radii_m=(0.04, 0.03), end_radii_m=(0.1, 0.08)),
    Frustum(start_m=0.03, end_m=0.45, start_radii_m=(0.03, 0.02), end_radii_m=(0.08, 0.06)),
)
START = bent(BODY, 0.4, (0.2, 0.3, -0.1))
OPTIONS = Options(points=1200)
MODEL = SurfaceModel.of(surface_of(BODY, START), BODY, START, OPTIONS.points)


def _disturbed(pose: Pose, turn: float, shift: float, seed: int = 0) -> Pose:
    rng = np.random.default_rng(seed)
    turns = rng.normal(size=(len(pose.Rs_parent_part), 3))
    turns *= turn / np.linalg.norm(turns, axis=1, keepdims=True)
    away = rng.normal(size=3)
    away *= shift / np.linalg.norm(away)
    return Pose(pose.Rs_parent_part @ exp_rotation(turns), pose.p_camera_root + away)


def _error_m(found: Pose, truth: Pose) -> float:
    return float(np.linalg.norm(joints(BODY, found) - joints(BODY, truth), axis=1).max())


@pytest.mark.parametrize("turn", [0.0, 1e-4, 0.15, 3.1])
@pytest.mark.parametrize("plane", [0.0, 1.0])
def test_a_known_pose_is_found_again_from_nearby(turn: float, plane: float) -> None:
    truth = bent(BODY, 0.4 + turn, (0.2, turn - 0.3, -0.1), (0.1, -0.2, 2.5))
    observed = TargetSurface.of(surface_of(BODY, truth), OPTIONS)
    options = replace(OPTIONS, plane=plane, solves=60)
    start = _disturbed(truth, 0.1, 0.03)
    found = fit_pose(MODEL, observed, start, options)
    assert _error_m(start, truth) > 0.03
    assert _error_m(found.pose, truth) < (0.004 if plane == 1.0 else 0.008)


def test_at_the_right_pose_nothing_moves() -> None:
    observed = TargetSurface.of(surface_of(BODY, START), OPTIONS)
    assert _error_m(fit_pose(MODEL, observed, START, OPTIONS).pose, START) < 1e-4


def test_a_pose_that_does_not_lower_the_energy_is_rejected() -> None:
    observed = TargetSurface.of(surface_of(BODY, START), OPTIONS)
    start = _disturbed(START, 0.5, 0.1, seed=3)
    energies = [
        fit_pose(MODEL, observed, start, replace(OPTIONS, solves=n)).energy for n in range(12)
    ]
    assert all(later <= before for before, later in pairwise(energies))
    assert energies[-1] < 0.5 * energies[0]


def _thickened(mesh: SurfaceMesh, by_m: float, end: Array) -> SurfaceMesh:
    """By as much everywhere; on what lies near an end, the cameras do not agree."""
    unsure = np.linalg.norm(mesh.vertices - end, axis=1) < 0.15
    vertices = mesh.vertices + by_m * mesh.normals
    return replace(mesh, vertices=vertices, consistency=np.where(unsure, -1.0, 0.9))


def test_a_body_does_not_slide_along_its_tapering_limbs_where_the_surface_is_thicker() -> None:
    body = two_bars(TAPERING)
    mesh, truth = surface_of(body, START), joints(body, START)
    model = SurfaceModel.of(mesh, body, START, OPTIONS.points)
    observed = TargetSurface.of(_thickened(mesh, 0.006, truth[-1]), OPTIONS)
    errors = {}
    for offset in (False, True):
        found = fit_pose(model, observed, START, replace(OPTIONS, offset=offset)).pose
        errors[offset] = np.linalg.norm(joints(body, found) - truth, axis=1).max()
    assert errors[True] < 0.001
    assert errors[False] > 0.003


@pytest.mark.parametrize("shapes", [ROUND, CAPSULES])
def test_the_turn_of_a_round_limb_about_its_length_is_reported_and_stays(shapes) -> None:
    body = two_bars(shapes)
    start = bent(body, 0.5)
    model = SurfaceModel.of(surface_of(body, start), body, start, 1500)
    truth = bent(body, 0.6, (0.1, 0.0, 0.05))
    observed = TargetSurface.of(surface_of(body, truth), OPTIONS)
    fit = fit_pose(model, observed, start, OPTIONS)
    step = measure(model, observed, fit)
    assert step.least_seen[1] < UNSEEN
    turned = log_rotation(start.Rs_parent_part[1].T @ fit.pose.Rs_parent_part[1])
    assert abs(turned[1]) < 0.02
    assert np.linalg.norm(joints(body, fit.pose) - joints(body, truth), axis=1).max() < 0.006


def test_the_turn_of_a_flat_limb_is_seen() -> None:
    observed = TargetSurface.of(surface_of(BODY, START), OPTIONS)
    step = measure(MODEL, observed, fit_pose(MODEL, observed, START, OPTIONS))
    assert step.least_seen.min() > 0.8
    assert step.rank == MODEL.skeleton.dof_count
    assert step.rms_m < 1e-3


def _with_phantom(mesh: SurfaceMesh) -> SurfaceMesh:
    """A volume beside the lower bar that is not there; the cameras do not agree on it."""
    ghost = Box(low_m=(-0.04, 0.03, -0.2), high_m=(0.04, 0.45, -0.09))
    body = two_bars((BOXES[0], ghost))
    beside = surface_of(body, START)
    own = beside.faces.min(axis=1) >= beside.faces[: len(beside.faces) // 2].max() + 1
    faces = np.concatenate([mesh.faces, beside.faces[own] + len(mesh.vertices)])
    agreed = np.concatenate([np.full(len(mesh.vertices), 0.9), np.full(len(beside.vertices), -1.0)])
    return SurfaceMesh(np.concatenate([mesh.vertices, beside.vertices]), faces, agreed)


def test_a_volume_that_the_cameras_do_not_agree_on_draws_nothing() -> None:
    mesh = _with_phantom(surface_of(BODY, START))
    plain = replace(OPTIONS, mutual=False)
    errors = {}
    for photo in (False, True):
        options = replace(plain, photo=photo)
        found = fit_pose(MODEL, TargetSurface.of(mesh, options), START, options)
        errors[photo] = _error_m(found.pose, START)
    assert errors[True] < 0.003
    assert errors[False] > 3 * errors[True]


def test_what_of_the_first_surface_the_steps_do_not_bear_out_counts_less() -> None:
    model = SurfaceModel.of(_with_phantom(surface_of(BODY, START)), BODY, START, OPTIONS.points)
    mesh = surface_of(BODY, START)
    still = replace(OPTIONS, mutual=False, solves=0)
    fit = fit_pose(model, TargetSurface.of(mesh, OPTIONS), START, still)
    record = PointReliability.of(model)
    for _ in range(5):
        record = record.after(model, fit)
    trust = record.apply_to(model).trust
    far = np.sqrt(fit.pairs.square[: fit.pairs.forward])
    assert trust[far < 0.01].mean() > 0.95
    assert np.median(trust[(far > 0.03) & (record.steps > 0)]) < 0.2


def test_what_is_explained_by_another_place_draws_nothing_even_without_pictures() -> None:
    mesh = replace(_with_phantom(surface_of(BODY, START)), consistency=None)
    errors = {}
    for mutual in (False, True):
        options = replace(OPTIONS, mutual=mutual)
        found = fit_pose(MODEL, TargetSurface.of(mesh, options), START, options)
        errors[mutual] = _error_m(found.pose, START)
    assert errors[True] < 0.5 * errors[False]


def test_a_part_whose_surface_is_missing_stays_where_the_rest_carries_it() -> None:
    truth = bent(BODY, 0.4, (0.25, 0.3, -0.1), (0.02, 0.0, 3.0))
    whole = surface_of(BODY, truth)
    upper = SurfaceMesh(whole.vertices, whole.faces[: len(whole.faces) // 2])
    observed = TargetSurface.of(upper, OPTIONS)
    fit = fit_pose(MODEL, observed, START, OPTIONS)
    assert _error_m(fit.pose, truth) < 0.02
    assert measure(MODEL, observed, fit).counts[1] < 0.2


@pytest.mark.parametrize("far", [0.0, 0.15])
def test_the_bodys_own_solids_are_laid_into_a_surface(far: float) -> None:
    rough = _disturbed(START, far, far / 3, seed=4)
    found = fit_solids_to_surface(surface_of(BODY, START), Skeleton.of(BODY), rough)
    assert _error_m(found.pose, START) < 0.006
    assert found.message.endswith(".")


def test_solids_of_other_sizes_come_near_as_well() -> None:
    thicker = (
        Box(low_m=(-0.07, -0.05, -0.11), high_m=(0.07, 0.5, 0.11)),
        Box(low_m=(-0.03, 0.03, -0.05), high_m=(0.03, 0.45, 0.05)),
    )
    body = two_bars(thicker)
    rough = _disturbed(START, 0.15, 0.05, seed=5)
    found = fit_solids_to_surface(surface_of(BODY, START), Skeleton.of(body), rough)
    assert _error_m(found.pose, START) < 0.025 < 0.04 < _error_m(rough, START)


def test_colours_give_distance_and_agreement_of_every_vertex() -> None:
    mesh = _with_phantom(surface_of(BODY, START))
    distance = vertex_scalars(MODEL, mesh, START, "distance")
    ghost = np.arange(len(mesh.vertices)) >= len(mesh.vertices) * 3 // 4
    used = np.isin(np.arange(len(mesh.vertices)), mesh.faces)
    assert distance[used & ~ghost].mean() < 0.015
    assert distance[used & ghost].mean() > 0.03
    assert mesh.consistency is not None
    photo = photo_weights(mesh.consistency)
    assert photo[ghost].max() < 0.01 < 0.9 < photo[: len(photo) // 2].min()
    contact = vertex_scalars(MODEL, mesh, START, "contact")
    assert contact.shape == (len(mesh.vertices),)
    assert 0.0 <= contact.min() <= contact.max() <= 1.0
