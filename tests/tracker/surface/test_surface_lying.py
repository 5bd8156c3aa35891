"""A body that lies beside the surface that moves with it is told from one that is only rough."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bench.keeping import DATA
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.surface.fit.judging import OFF_SHARE, lies_off
from keypose.tracker.surface.fit.model import SurfaceModel
from keypose.tracker.surface.mesh import SurfaceMesh
from tests.rendering.walker_body import Human, body_and_poses
from tests.tracker.surface.surfaces import BOXES, CAPSULES, ROUND, bent, surface_of, two_bars

POSE = bent(two_bars(), 0.4, (0.2, 0.3, -0.1))
ASIDE = np.array([1.0, 0.0, 0.0])
ROUGH_SIZES = (0.85, 0.9, 1.0, 1.1, 1.15)
WRONG_SIZES = (0.1, 0.33, 0.5, 3.0, 10.0)

needs_human = pytest.mark.skipif(
    not (DATA / "mesh_walk" / "meta.json").is_file(), reason="the animated human is not here"
)


def _times(value: Any, scale: float) -> Any:
    return tuple(_times(v, scale) for v in value) if isinstance(value, tuple) else value * scale


def _sized(body: Body, scale: float) -> Body:
    """The body so many times as large."""
    parts = []
    for part in body.parts:
        lengths = {k: v for k, v in part.shape if k.endswith("_m")}
        shape = part.shape.model_copy(update={k: _times(v, scale) for k, v in lengths.items()})
        update = {"joint_m": _times(part.joint_m, scale), "shape": shape}
        parts.append(part.model_copy(update=update))
    return body.replaced(parts)


def _aside(pose: Pose, by_m: float) -> Pose:
    return Pose(pose.Rs_parent_part, pose.p_camera_root + by_m * ASIDE)


def _turned(pose: Pose, degrees: float) -> Pose:
    """Every part by so much about some axis."""
    turns = np.random.default_rng(0).normal(size=(len(pose.Rs_parent_part), 3))
    turns *= np.radians(degrees) / np.linalg.norm(turns, axis=1, keepdims=True)
    return Pose(pose.Rs_parent_part @ exp_rotation(turns), pose.p_camera_root)


def _is_off(mesh: SurfaceMesh, body: Body, pose: Pose) -> bool:
    return lies_off(SurfaceModel.of(mesh, body, pose, 1000), pose)


@pytest.mark.parametrize("shapes", [BOXES, ROUND, CAPSULES])
def test_a_body_that_is_only_roughly_sized_or_posed_lies_in_its_surface(shapes) -> None:
    body = two_bars(shapes)
    mesh = surface_of(body, POSE)
    for scale in ROUGH_SIZES:
        assert not _is_off(mesh, _sized(body, scale), POSE)
    assert not _is_off(mesh, body, _aside(POSE, 0.05))
    assert not _is_off(mesh, body, _turned(POSE, 5.0))


@pytest.mark.parametrize("shapes", [BOXES, ROUND, CAPSULES])
def test_a_body_of_other_sizes_or_beside_its_surface_is_found_out(shapes) -> None:
    body = two_bars(shapes)
    mesh = surface_of(body, POSE)
    for scale in WRONG_SIZES:
        assert _is_off(mesh, _sized(body, scale), POSE)
    assert _is_off(mesh, body, _aside(POSE, 0.15))
    assert _is_off(mesh, body, _aside(POSE, 5.0))


def test_a_surface_that_shows_one_limb_only_or_something_more_is_no_reason_to_doubt() -> None:
    body = two_bars()
    mesh = surface_of(body, POSE)
    upper = SurfaceMesh(mesh.vertices, mesh.faces[: len(mesh.faces) // 2])
    assert not _is_off(upper, body, POSE)
    ball = mesh.vertices[: len(mesh.vertices) // 2]  # the upper bar again, shrunk to a thing
    thing = 0.3 * (ball - ball.mean(axis=0)) + ball.mean(axis=0) + 0.4 * ASIDE
    faces = np.concatenate([mesh.faces, upper.faces + len(mesh.vertices)])
    assert not _is_off(SurfaceMesh(np.concatenate([mesh.vertices, thing]), faces), body, POSE)


def test_how_far_a_body_lies_off_does_not_depend_on_the_units_it_is_reported_in() -> None:
    body, pose = two_bars(), _aside(POSE, 0.1)
    mesh = surface_of(body, POSE)
    large = SurfaceMesh(100.0 * mesh.vertices, mesh.faces)
    far = Pose(pose.Rs_parent_part, 100.0 * pose.p_camera_root)
    shares = [
        SurfaceModel.of(m, b, p, 1000).off_share(p)
        for m, b, p in ((mesh, body, pose), (large, _sized(body, 100.0), far))
    ]
    assert shares[0] == pytest.approx(shares[1], rel=1e-6)
    assert shares[0] == pytest.approx(OFF_SHARE, rel=0.3)


@needs_human
def test_a_human_is_found_out_when_beside_the_mesh_by_more_than_a_limb_and_not_before() -> None:
    human = Human.load()
    body, poses = body_and_poses(human, human.Ts_joint)
    mesh, pose = SurfaceMesh(human.vertices[0], human.faces), poses[0]
    for scale in ROUGH_SIZES:
        assert not _is_off(mesh, _sized(body, scale), pose)
    assert not _is_off(mesh, body, _aside(pose, 0.08))
    assert not _is_off(mesh, body, _turned(pose, 10.0))
    for scale in WRONG_SIZES:
        assert _is_off(mesh, _sized(body, scale), pose)
    assert _is_off(mesh, body, _aside(pose, 0.15))
    assert _is_off(mesh, body, _aside(pose, 0.35))
