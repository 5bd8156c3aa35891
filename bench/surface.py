"""Bodies fitted to observed surfaces: SURFACE's arms, a walker in harder ways, hulls, time, memory.

The variants of the paper are run as it has them: all pairs of nearest points, none of what has been
added since. `Keypose` is what the product does.
"""

from __future__ import annotations

import resource
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import get_args

import numpy as np
from threadpoolctl import threadpool_limits

from bench.keeping import Absent
from bench.table import Expected, Report, Table
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose, joint_positions, part_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.formats.verdict_words import verdict_words
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.surface.cameras.hulls import ply_bytes
from keypose.tracker.surface.files.sequence import MeshSequence
from keypose.tracker.surface.fit.fitter import fit_solids_to_surface
from keypose.tracker.surface.fit.model import SurfaceModel
from keypose.tracker.surface.fit.options import Options
from keypose.tracker.surface.fit.pairing import TargetSurface
from keypose.tracker.surface.fit.segment import SurfaceTracker
from keypose.tracker.surface.fit.solving import fit_pose
from keypose.tracker.surface.mesh import SurfaceMesh
from tests.rendering.arm_bodies import Kind
from tests.rendering.arms import arms_scene
from tests.rendering.walker import WalkKind, walker

PAPER = Options(mutual=False, floor=False, stiff=0.0, trust=False, offset=False)
VARIANTS: Mapping[str, Options] = {
    "ICP": replace(PAPER, contact=False, photo=False),
    "ρ_c": replace(PAPER, photo=False),
    "ρ_p": replace(PAPER, contact=False),
    "both": PAPER,
}
DISTANCES: Mapping[str, Options] = {
    "point": replace(PAPER, plane=0.0, agreement=-2.0),
    "plane": PAPER,
}
CAMERAS = (15, 8)
MOST_CM = 1.0
MOST_MS = 150.0
EVERY: Mapping[WalkKind, tuple[int, ...]] = {
    "plain": (1, 2, 3, 6, 8), "contact": (1, 2, 3), "missing20": (1,), "noise1cm": (1,),
}  # fmt: skip
"""Of how many steps one is observed."""
ASKED = 3
ROUGH = ((3.0, 1.5), (6.0, 3.0), (12.0, 5.0))
"""Degrees and centimetres by which first poses are off."""
PHANTOM = slice(6, 9)
CONTACT = slice(8, 11)
LONG = 3000
SOON = 500
GROWTH = 1.1


@dataclass(frozen=True)
class Steps:
    """Surfaces that no camera cuts off, from wherever they are read."""

    frame_count: int
    mesh: Callable[[int], SurfaceMesh]

    def cut_by(self, _: int) -> tuple[str, ...]:
        return ()


@dataclass(frozen=True, eq=False)
class Outcome:
    """errors_cm: (F, J) of every step's joints; ms: of a step; verdict: in words."""

    errors_cm: Array
    ms: float
    verdict: str

    @property
    def by_step(self) -> Array:
        return np.asarray(self.errors_cm.mean(axis=1))


def surface(report: Report) -> None:
    """The whole group."""
    with threadpool_limits(1):
        for kind, cameras in product(get_args(Kind), CAMERAS):
            _arms(report, kind, cameras)
        try:
            _walks(report)
            _first_poses(report)
            _hulls(report)
            _time(report)
            _long(report)
        except Absent as absent:
            report.note(f"left out: {absent} is not here")


def _arms(report: Report, kind: Kind, cameras: int) -> None:
    scene = arms_scene(kind, cameras)
    truth = _joints(scene.body, scene.poses)
    report.note(f"{kind}, {cameras} cameras: mean joint error, cm, by step")
    columns = ("mean", "worst", "t6–8", "t8–10", "ms", "every step")
    table = report.table(f"arms {kind} {cameras}", *columns, wide=("every step",))
    for distance, how in DISTANCES.items():
        for name, variant in VARIANTS.items():
            options = replace(variant, plane=how.plane, agreement=how.agreement)
            found = _fitted(scene.steps, scene.body, scene.poses, truth, options)
            _by_steps(table, f"{name}, {distance}", found)
    for name, options in (("Keypose", Options()), ("Keypose, point", Options(plane=0.0))):
        found = _fitted(scene.steps, scene.body, scene.poses, truth, options)
        expected = [Expected("worst step", float(found.by_step.max()), MOST_CM, "cm")]
        _by_steps(table, name, found, expected if name == "Keypose" else [])


def _by_steps(table: Table, name: str, found: Outcome, expected: Sequence[Expected] = ()) -> None:
    steps = found.by_step
    every = " ".join(f"{e:.1f}" for e in steps)
    table.row(
        name,
        float(steps[1:].mean()),
        float(steps.max()),
        float(steps[PHANTOM].mean()),
        float(steps[CONTACT].mean()),
        found.ms,
        every,
        expected=expected,
    )


def _walks(report: Report) -> None:
    report.note("a walker of known joints, 59 steps, one keyframe: mean joint error, cm")
    table = report.table(
        "walker", "mean", "worst step", "worst joint", "ms", "verdict", wide=("verdict",)
    )
    for kind in EVERY:
        walk = walker(kind)
        for every in EVERY[kind]:
            found = _fitted(
                walk.steps[::every], walk.body, walk.poses[::every], walk.joints[::every]
            )
            name = kind if every == 1 else f"{kind}, every {every}"
            _of_walk(table, name, found, MOST_CM if every <= ASKED else None)
    walk = walker("contact")
    plain = _fitted(walk.steps, walk.body, walk.poses, walk.joints, VARIANTS["ICP"])
    _of_walk(table, "contact, plain ICP", plain, None)


def _first_poses(report: Report) -> None:
    report.note("the walker's own solids laid into its first mesh (F): mean joint error, cm")
    walk, skeleton = walker("plain"), Skeleton.of(walker("plain").body)
    table = report.table("first pose", "posed", "laid", "s")
    for degrees, centimetres in ROUGH:
        rough = _disturbed(walk.poses[0], np.radians(degrees), centimetres / 100)
        began = time.perf_counter()
        laid = fit_solids_to_surface(walk.steps[0], skeleton, rough).pose
        seconds = time.perf_counter() - began
        errors = [
            100 * np.linalg.norm(_joints(walk.body, [pose])[0, :19] - walk.joints[0], axis=1).mean()
            for pose in (rough, laid)
        ]
        table.row(f"{degrees:g}° and {centimetres:g} cm off", *map(float, errors), seconds)


def _disturbed(pose: Pose, turn: float, shift: float) -> Pose:
    rng = np.random.default_rng(0)
    turns, away = rng.normal(size=(len(pose.Rs_parent_part), 3)), rng.normal(size=3)
    turns *= turn / np.linalg.norm(turns, axis=1, keepdims=True)
    moved = pose.p_camera_root + away * shift / np.linalg.norm(away)
    return Pose(pose.Rs_parent_part @ exp_rotation(turns), moved)


def _hulls(report: Report) -> None:
    report.note("hulls of the same walker, textured, from rings of cameras")
    table = report.table(
        "hulls", "mean", "worst step", "worst joint", "ms", "verdict", wide=("verdict",)
    )
    for cameras in (4, 8, 15):
        walk = walker("plain", cameras)
        for name, options in (("both", Options()), ("without photo", Options(photo=False))):
            found = _fitted(walk.steps, walk.body, walk.poses, walk.joints, options)
            _of_walk(table, f"{cameras} cameras, {name}", found, None)


def _of_walk(table: Table, name: str, found: Outcome, most: float | None) -> None:
    mean = float(found.errors_cm[1:].mean())
    expected = [] if most is None else [Expected("mean", mean, most, "cm")]
    worst = float(found.by_step.max()), float(found.errors_cm.max())
    table.row(name, mean, *worst, found.ms, found.verdict, expected=expected)


def _time(report: Report) -> None:
    walk = walker("plain")
    options = Options()
    model = SurfaceModel.of(walk.steps[0], walk.body, walk.poses[0], options.points)
    observed = [TargetSurface.of(mesh, options) for mesh in walk.steps]
    fit_pose(model, observed[1], walk.poses[0], options)
    table = report.table("time", "least ms", "median ms")
    spent = []
    pose = walk.poses[0]
    for step in observed[1:]:
        began = time.perf_counter()
        fit = fit_pose(model, step, pose, options)
        spent.append(1e3 * (time.perf_counter() - began))
        pose = fit.pose
    median = float(np.median(spent))
    report.note(f"{len(model.own)} points a side, {walk.skeleton.part_count} parts, one thread")
    table.row(
        "a step, all its solves",
        min(spent),
        median,
        expected=[Expected("median", median, MOST_MS, "ms")],
    )


def _long(report: Report) -> None:
    """Steps read from the disk, there and back again; the memory they take."""
    walk = walker("plain")
    there_and_back = [*range(59), *range(57, 0, -1)]
    with tempfile.TemporaryDirectory() as folder:
        for number in range(LONG):
            mesh = walk.steps[there_and_back[number % len(there_and_back)]]
            Path(folder, f"step_{number:04d}.ply").write_bytes(ply_bytes(mesh))
        peaks: dict[int, float] = {}
        with MeshSequence.open(Path(folder)) as sequence:
            began = time.perf_counter()
            tracker = SurfaceTracker(
                Steps(sequence.frame_count, sequence.mesh),
                walk.body,
                {0: walk.poses[0]},
                0,
                Options().at("preview"),
            )

            def note(done: int) -> None:
                if done >= SOON:
                    peaks.setdefault(SOON, _peak_mb())

            result = tracker.run_segment((0, LONG - 1), lambda step, number: note(number))
            peaks[LONG] = _peak_mb()
    seconds = time.perf_counter() - began
    truth = walk.joints[[there_and_back[k % len(there_and_back)] for k in range(LONG)]]
    found = _of_path(walk.body, result.trajectory.Rs_parent_part, result.trajectory.ps_camera_root)
    error = float(np.linalg.norm(found - truth, axis=2).mean() * 100)
    table = report.table("3,000 steps, preview", "cm", "MB at 500", "MB at the end", "s")
    table.row(
        "read from PLY files",
        error,
        peaks[SOON],
        peaks[LONG],
        seconds,
        expected=[
            Expected("memory, of that at 500", peaks[LONG] / peaks[SOON], GROWTH),
        ],
    )


def _peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _fitted(
    steps: Sequence[SurfaceMesh],
    body: Body,
    poses: Sequence[Pose],
    truth: Array,
    options: Options | None = None,
) -> Outcome:
    """From one keyframe at the first step; joints as far as `truth` (F, J, 3) tells them."""
    began = time.perf_counter()
    tracker = SurfaceTracker(
        Steps(len(steps), steps.__getitem__), body, {0: poses[0]}, 0, options or Options()
    )
    result = tracker.run_segment((0, len(steps) - 1), lambda step, number: None)
    ms = 1e3 * (time.perf_counter() - began) / (len(steps) - 1)
    path = result.trajectory
    found = _of_path(body, path.Rs_parent_part, path.ps_camera_root)[:, : truth.shape[1]]
    return Outcome(100 * np.linalg.norm(found - truth, axis=2), ms, verdict_words(result.verdict))


def _joints(body: Body, poses: Sequence[Pose]) -> Array:
    Rs = np.array([pose.Rs_parent_part for pose in poses])
    return _of_path(body, Rs, np.array([pose.p_camera_root for pose in poses]))


def _of_path(body: Body, Rs_parent_part: Array, ps_camera_root: Array) -> Array:
    """(F, J, 3) joints, then landmarks, metres."""
    skeleton = Skeleton.of(body)
    Ts = part_transforms(skeleton, Rs_parent_part, ps_camera_root)
    return joint_positions(skeleton, Ts)
