"""The scene of three arms: hulls as a ring of cameras yields them, with exact poses beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from bench.keeping import ROOT, digest, place_for
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.surface.cameras.footage import consistency
from keypose.tracker.surface.cameras.hull import SMOOTHING_VOXELS, Silhouette, hull_field, hull_mesh
from keypose.tracker.surface.cameras.rig import View
from keypose.tracker.surface.mesh import SurfaceMesh
from tests.rendering.arm_bodies import Kind, arm_mesh, arms_body
from tests.rendering.arm_motions import P_CENTRE, arm_poses
from tests.rendering.kept_meshes import keep_meshes, kept_meshes
from tests.rendering.ring import Carvings, Shot, ring_of

MADE_BY = ("arms", "arm_bodies", "arm_motions", "ring", "shade", "texture")
VOXEL_M = 0.01


@dataclass(frozen=True, eq=False)
class ArmsScene:
    """steps: observed meshes, metres in the camera frame; poses: the true ones; views: who saw."""

    steps: list[SurfaceMesh]
    body: Body
    poses: list[Pose]
    views: tuple[View, ...]

    @property
    def skeleton(self) -> Skeleton:
        return Skeleton.of(self.body)


def arms_scene(kind: Kind, cameras: int, seed: int = 0, voxel_m: float = VOXEL_M) -> ArmsScene:
    """`make_scene`, or as it was kept of a run before: making one takes up to a minute."""
    key = digest(*made_by(*MADE_BY), repr((kind, cameras, seed, voxel_m)).encode())
    place = place_for(f"arms-{kind}-{cameras}-{seed}-{1000 * voxel_m:g}mm", key, ".npz")
    if not place.is_file():
        keep_meshes(place, make_scene(kind, cameras, seed, voxel_m).steps)
    views = ring_of(cameras, P_CENTRE)
    return ArmsScene(kept_meshes(place), arms_body(kind), arm_poses(kind), views)


def make_scene(
    kind: Kind,
    cameras: int,
    seed: int = 0,
    voxel_m: float = VOXEL_M,
    smoothing_voxels: float = SMOOTHING_VOXELS,
) -> ArmsScene:
    """The hulls of all steps, of which nothing is kept."""
    body, poses, views = arms_body(kind), arm_poses(kind), ring_of(cameras, P_CENTRE)
    steps = []
    for step in range(len(poses)):
        shots = shots_of(kind, poses[step], views, [seed, step])
        steps.append(observed(views, shots, voxel_m, smoothing_voxels))
    return ArmsScene(steps, body, poses, views)


def shots_of(kind: Kind, pose: Pose, views: Sequence[View], seed: list[int]) -> list[Shot]:
    """What the views see of the arms in a pose; noise follows from the seed."""
    Ts = pose_transforms(Skeleton.of(arms_body(kind)), pose)
    carvings = Carvings((arm_mesh(kind),) * 3, seed[0])
    return [carvings.seen_by(view, Ts, [*seed, i]) for i, view in enumerate(views)]


def observed(
    views: Sequence[View],
    shots: Sequence[Shot],
    voxel_m: float,
    smoothing_voxels: float = SMOOTHING_VOXELS,
) -> SurfaceMesh:
    """The hull of what the views see, with the photo-consistency of its vertices."""
    pictures = [shot.picture for shot in shots]
    field = hull_field(views, [Silhouette(shot.inside) for shot in shots], voxel_m)
    mesh = hull_mesh(field, smoothing_voxels)
    return replace(mesh, consistency=consistency(mesh, views, pictures))


def made_by(*rendering: str) -> list[Path]:
    """The files whose text decides what a scene looks like; rendering: those of this folder."""
    surface = ("hull", "footage")
    kernels = ("carving", "patches", "raster")
    return [
        *(ROOT / "tests" / "rendering" / f"{name}.py" for name in rendering),
        *(ROOT / "tracker" / "surface" / "cameras" / f"{name}.py" for name in surface),
        *(ROOT / "tracker" / "kernels" / f"{name}.py" for name in kernels),
    ]
