"""Every term against finite differences: its gradient, and what its rows say of its residuals."""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.joint_limits import Limits, TwistLimits
from keypose.tracker.body.pose import Pose, moved
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.fitting.pose.refinement import EdgeDistances
from keypose.tracker.fitting.pose.texture import TextureMatch, texture_of
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.solver.pose_terms import (
    DepthFromRoot,
    JointLimits,
    PointsInPicture,
    PointsInSpace,
    PosePrior,
    RootPosition,
)
from keypose.tracker.solver.posed import BodyPoint, BodyPoints, Posed, free_skeleton
from keypose.tracker.solver.projection import image_points
from keypose.tracker.solver.robust import Cauchy, Huber, Kernel, Tukey
from keypose.tracker.solver.terms import (
    DiagonalTerm,
    RowTerm,
    SummedTerm,
    Term,
    total_cost,
    total_equations,
)
from keypose.tracker.surface.fit.model import SurfaceModel
from keypose.tracker.surface.fit.options import Options
from keypose.tracker.surface.fit.pairing import TargetSurface, pairs_of
from keypose.tracker.surface.fit.solving import PairDistances
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.tracking.scene import Scene
from tests.tracker.surface.surfaces import surface_of
from tests.tracker.tracking_cases import smooth_picture

Floats = NDArray[np.float64]

SKELETON = free_skeleton(preset("adult_male"))
TRACKED = Skeleton.of(preset("adult_male"))
PARTS = SKELETON.part_count
POINTS: tuple[BodyPoint, ...] = (
    *(((i, (0.0, 0.02, 0.01)),) for i in range(PARTS)),
    ((5, (0.0, 0.1, 0.02)), (9, (0.01, 0.0, 0.0))),
)
FLAT = Camera(width=640, height=480, fx=700, fy=710, cx=322, cy=235)
TELEPHOTO = FLAT.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 4.0})
WIDE = Camera(width=320, height=240, fx=230, fy=232, cx=160, cy=120)
"""The body stays within its picture, whatever its pose."""
STEP = 1e-6


def _random(seed: int, turn_rad: float) -> Pose:
    """A pose in front of the camera whose parts are turned by about so much."""
    rng = np.random.default_rng(seed)
    Rs = exp_rotation(rng.normal(0, turn_rad, (PARTS, 3)))
    return Pose(Rs, np.array([0.2, -0.1, 4.0]))


def _in_space(points: BodyPoints) -> Term:
    rng = np.random.default_rng(1)
    return PointsInSpace(points, rng.normal((0, 0, 4), 0.4, (len(POINTS), 3)), 0.005)


def _in_picture(camera: Camera, kernel: Kernel) -> Callable[[BodyPoints], Term]:
    rng = np.random.default_rng(2)
    uv, scale = rng.normal((320, 240), 90, (len(POINTS), 2)), rng.uniform(0, 0.5, len(POINTS))
    return lambda points: PointsInPicture(points, camera, uv, scale, 0.05, kernel)


def _from_root(kernel: Kernel) -> Callable[[BodyPoints], Term]:
    rng = np.random.default_rng(3)
    depth, scale = rng.normal(0, 0.3, len(POINTS)), rng.uniform(0, 12, len(POINTS))
    return lambda points: DepthFromRoot(points, depth, scale, kernel)


def _limits(allowed: Floats | None, onset_rad: float = 0.0) -> Callable[[BodyPoints], Term]:
    """Narrow ones of every angle and twist, swings counted from all kinds of directions."""
    width, R_rest = np.full((PARTS, 3), 1e-4), _random(9, 0.4).Rs_parent_part
    twists = TwistLimits(-width[:, 0], width[:, 0], R_rest)
    limits = Limits(-width, width, np.arange(PARTS), twists)
    return lambda points: JointLimits(limits, 0.03, allowed, onset_rad)


def _in_sizes(points: BodyPoints) -> Term:
    """That of a keyframe posed by hand, whose turns out of the picture are held more loosely."""
    axes = np.where(SKELETON.dof_turns == 1, np.array([8.0, 8.0, 8.0])[SKELETON.dof_axis], 0.0)
    return PosePrior.of(_random(7, 0.1), axes)


def _before_picture() -> Scene:
    return Scene.of(SKELETON, WIDE, [_random(7, 0.1)])


def _textures(fine: bool, width: float) -> Callable[[BodyPoints], Term]:
    """A picture's own texture laid onto it elsewhere; width: of the robust kernel."""
    scene, pose = _before_picture(), _random(7, 0.1)
    picture = smooth_picture(4, WIDE.width, WIDE.height)
    match = TextureMatch(scene, [picture], [texture_of(scene, [picture], pose, 1.0)])
    match.update_visibility(pose)
    made = match.term(Posed.of(SKELETON, pose), 0, fine)
    return lambda points: replace(made, width=np.array([width]), noise=np.array([9.0]))


def _edges(camera: Camera) -> Callable[[BodyPoints], Term]:
    rng = np.random.default_rng(6)
    part, angle = rng.integers(0, PARTS, 200), rng.uniform(0, 2 * np.pi, 200)
    normal, p_part = np.stack([np.cos(angle), np.sin(angle)], axis=1), rng.normal(0, 0.1, (200, 3))
    posed = Posed.of(SKELETON, _random(7, 0.1))
    target = (normal * camera.project(posed.points(part, p_part))).sum(-1) + rng.normal(0, 3, 200)
    weights = rng.uniform(0, 0.3, 200)
    return lambda points: EdgeDistances(camera, part, p_part, normal, target, weights, 4.0)


def _pairs(plane: float, offset: bool, smooth: bool) -> Callable[[BodyPoints], Term]:
    """A body's own surface, and that in another pose."""
    pose, body = _random(7, 0.1), SKELETON.body
    surfaces = [_surface(pose), _surface(_random(7, 0.15))]
    options = Options(points=400)
    model = SurfaceModel.of(surfaces[0], body, pose, 400, smooth)
    posed = Posed.of(SKELETON, pose)
    at = model.posed(posed.Ts_camera_part)
    pairs = pairs_of(model, at, TargetSurface.of(surfaces[1], options), options)
    assert (pairs.weights > 0).sum() > 100
    return lambda points: PairDistances(model, pairs, posed, at, plane, offset)


def _surface(pose: Pose) -> SurfaceMesh:
    return surface_of(SKELETON.body, pose, 1)


TERMS: dict[str, Callable[[BodyPoints], Term]] = {
    "points in space": _in_space,
    "points in a picture": _in_picture(FLAT, Huber(1e9)),
    "points in a picture, far ones pulling no harder": _in_picture(FLAT, Huber()),
    "points in a picture, far ones pulling less": _in_picture(FLAT, Cauchy()),
    "points in a picture, far ones not counting": _in_picture(FLAT, Tukey(40.0)),
    "points in a telephoto picture": _in_picture(TELEPHOTO, Huber(1e9)),
    "points in a telephoto picture, robust": _in_picture(TELEPHOTO, Huber()),
    "depth from the root": _from_root(Huber(1e9)),
    "depth from the root, far ones pulling no harder": _from_root(Huber()),
    "joint limits": _limits(None),
    "joint limits that set in slowly": _limits(None, 0.3),
    "joint limits as somebody posed beyond them": _limits(np.full((PARTS, 4), 2e-4)),
    "prior": lambda points: PosePrior.of(
        _random(7, 0.1), np.where(SKELETON.dof_turns == 1, 9.0, 400.0)
    ),
    "robust prior": lambda points: PosePrior(
        *_arrays(_random(7, 0.1)), np.where(SKELETON.dof_turns == 1, 9.0, 400.0), Huber(1e9)
    ),
    "depth of the root": lambda points: RootPosition.depth(np.array([0.1, 0.0, 4.2]), 0.05),
    "place of the root along rays": lambda points: RootPosition(
        np.array([0.1, 0.0, 4.2]), np.array([[60.0, 0, -1.5], [0, 60.0, 0.4]])
    ),
    "prior of turns alone": _in_sizes,
    "textures": _textures(fine=False, width=1e5),
    "textures, far ones pulling no harder": _textures(fine=False, width=10.0),
    "textures, each part brighter or darker": _textures(fine=True, width=1e5),
    "edges in a picture": _edges(FLAT),
    "edges in a telephoto picture": _edges(TELEPHOTO),
    "pairs of surface points": _pairs(plane=0.0, offset=False, smooth=False),
    "pairs along the surface's normals": _pairs(plane=1.0, offset=False, smooth=True),
    "pairs of a surface that stands out": _pairs(plane=1.0, offset=True, smooth=True),
}
"""Every term. One that is added goes here."""
TESTED_ELSEWHERE = {"TermIn": "test_two_views.py", "Textures": "test_bundle.py"}
"""What wraps a term, and what has no cost, with the test of each."""

MANY = [name for name in TERMS if not name.startswith(("textures", "edges", "pairs"))]
"""Those that are not made for one pose."""
ROUGH = {name: (1e-3, 0.02) for name in TERMS if name.startswith("textures")}
"""Steps and tolerance of sums in single precision over pictures with slopes of their own."""


def _classes_of_terms() -> set[str]:
    """The names of all terms of the tracker, read from its source."""
    kinds = {kind.__name__ for kind in (Term, RowTerm, SummedTerm, DiagonalTerm)}
    sources = (Path(__file__).parents[3] / "tracker").rglob("*.py")
    return {
        node.name
        for path in sources
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.ClassDef)
        and node.name not in kinds
        and ({ast.unparse(base) for base in node.bases} & kinds or _has_equations(node))
    }


def _has_equations(node: ast.ClassDef) -> bool:
    """Whether a class has the method of a term without being derived from one."""
    methods = [part for part in node.body if isinstance(part, ast.FunctionDef)]
    return any(
        method.name == "equations" and [arg.arg for arg in method.args.args] == ["self", "posed"]
        for method in methods
    )


def test_every_term_of_the_tracker_is_compared_here() -> None:
    compared = {type(make(BodyPoints(SKELETON, POINTS))).__name__ for make in TERMS.values()}
    assert _classes_of_terms() == compared | set(TESTED_ELSEWHERE)


def _arrays(pose: Pose) -> tuple[Floats, Floats]:
    return pose.Rs_parent_part, pose.p_camera_root


def _difference(
    value: Callable[[Posed], Any], pose: Pose, skeleton: Skeleton = SKELETON, size: float = STEP
) -> Floats:
    """(..., D) central differences of a value over motions of a pose."""
    columns = []
    for d in range(skeleton.dof_count):
        x = np.zeros(skeleton.dof_count)
        x[d] = size
        ahead, behind = (Posed.of(skeleton, moved(skeleton, pose, s * x)) for s in (1, -1))
        columns.append((np.asarray(value(ahead)) - np.asarray(value(behind))) / (2 * size))
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("turn_rad", [1e-3, 0.3, 1.0], ids=["near identity", "bent", "large"])
@pytest.mark.parametrize("name", TERMS)
def test_the_gradient_of_every_term_is_that_of_its_cost(name: str, turn_rad: float) -> None:
    term = TERMS[name](BodyPoints(SKELETON, POINTS))
    pose = _random(3, turn_rad)
    found = term.equations(Posed.of(SKELETON, pose))
    size, tolerance = ROUGH.get(name, (STEP, 2e-6))
    expected = _difference(term.cost, pose, size=size)
    assert np.allclose(found.b, expected, atol=tolerance * max(np.abs(expected).max(), 1.0))
    assert found.cost == pytest.approx(term.cost(Posed.of(SKELETON, pose))) or name in ROUGH
    assert np.allclose(found.A, found.A.T)
    assert np.linalg.eigvalsh(found.A).min() >= -1e-9 * np.abs(found.A).max()


@pytest.mark.parametrize("turn_rad", [1e-3, 0.3, 1.0], ids=["near identity", "bent", "large"])
@pytest.mark.parametrize("name", ["points in space", "points in a picture", "joint limits",
                                  "points in a telephoto picture", "depth from the root",
                                  "depth of the root", "place of the root along rays"])  # fmt: skip
@pytest.mark.parametrize("skeleton", [SKELETON, TRACKED], ids=["free", "as tracked"])
def test_the_equations_of_residuals_are_the_products_of_how_they_change(
    skeleton: Skeleton, name: str, turn_rad: float
) -> None:
    term = TERMS[name](BodyPoints(skeleton, POINTS))
    pose = _random(4, turn_rad)
    found = term.equations(Posed.of(skeleton, pose)).A
    J = _difference(lambda posed: _residuals(term, posed), pose, skeleton)
    expected = J.T @ J
    assert np.allclose(found, expected, atol=1e-5 * max(np.abs(expected).max(), 1.0))


def _residuals(term: Term, posed: Posed) -> Floats:
    """What a term compares, in standard deviations."""
    match term:
        case PointsInPicture():
            away = image_points(term.camera, term.points.of(posed)) - term.uv
            return np.asarray((away * term.scale[:, None]).ravel())
        case DepthFromRoot():
            deeper = term.points.of(posed)[:, 2] - posed.p_camera_root[2] - term.depth
            return np.asarray(deeper * term.scale)
        case JointLimits():
            return np.asarray(term.limits.excess(posed.Rs_parent_part)[0].ravel() / term.sigma_rad)
        case _:
            assert isinstance(term, RowTerm)
            return term.rows(posed).r


@pytest.mark.parametrize("backward", [True, False])
def test_a_prior_that_holds_axes_unevenly_has_the_gradient_of_small_deviations(
    backward: bool,
) -> None:
    precision = np.random.default_rng(5).uniform(1, 9, SKELETON.dof_count)
    pose = _random(6, 0.8)
    near = moved(SKELETON, pose, np.random.default_rng(7).normal(0, 1e-4, SKELETON.dof_count))
    term = PosePrior.of(pose, precision, backward)
    b = term.equations(Posed.of(SKELETON, near)).b
    assert np.allclose(b, _difference(term.cost, near), atol=2e-3 * np.abs(b).max())


@pytest.mark.parametrize("name", MANY)
def test_many_poses_at_once_are_as_each_by_itself(name: str) -> None:
    term = TERMS[name](BodyPoints(SKELETON, POINTS))
    poses = [_random(seed, 0.4) for seed in range(3)]
    Rs, ps = (np.stack([_arrays(pose)[k] for pose in poses]) for k in range(2))
    together = Posed(SKELETON, Rs, ps)
    each = [Posed.of(SKELETON, pose) for pose in poses]
    assert term.cost(together) == pytest.approx(sum(term.cost(posed) for posed in each))
    found = term.equations(together)
    for k, posed in enumerate(each):
        alone = term.equations(posed)
        assert np.allclose(found.A[k], alone.A, atol=1e-9 * np.abs(alone.A).max())
        assert np.allclose(found.b[k], alone.b, atol=1e-9 * np.abs(alone.b).max())


def test_terms_add_up() -> None:
    terms = [make(BodyPoints(SKELETON, POINTS)) for make in TERMS.values()]
    posed = Posed.of(SKELETON, _random(8, 0.5))
    found = total_equations(terms, posed)
    parts = [term.equations(posed) for term in terms]
    assert total_cost(terms, posed) == pytest.approx(sum(term.cost(posed) for term in terms))
    assert np.allclose(found.A, np.sum([part.A for part in parts], axis=0))
    assert np.allclose(found.b, np.sum([part.b for part in parts], axis=0))


def test_no_pose_has_a_point_behind_the_camera() -> None:
    term = TERMS["points in a picture"](BodyPoints(SKELETON, POINTS))
    pose = _random(9, 0.1)
    assert np.isfinite(term.cost(Posed.of(SKELETON, pose)))
    behind = Pose(pose.Rs_parent_part, np.array([0.0, 0.0, -0.3]))
    assert term.cost(Posed.of(SKELETON, behind)) == np.inf
