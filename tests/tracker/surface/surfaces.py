"""Two bars on a joint, and their surfaces in known poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from keypose.tracker.body.body import Body, Part
from keypose.tracker.body.pose import Pose, joint_positions, pose_transforms
from keypose.tracker.body.shapes import Box, Capsule, Cylinder, Shape
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import SurfaceError
from keypose.tracker.geometry.rotations import Array, apply_transform, exp_rotation
from keypose.tracker.surface.mesh import SurfaceMesh

BOXES = (
    Box(low_m=(-0.06, -0.05, -0.09), high_m=(0.06, 0.5, 0.09)),
    Box(low_m=(-0.04, 0.03, -0.07), high_m=(0.04, 0.45, 0.07)),
)
ROUND = (
    Cylinder(start_m=-0.05, end_m=0.5, radius_m=0.08),
    Cylinder(start_m=0.03, end_m=0.45, radius_m=0.05),
)
CAPSULES = tuple(Capsule.like(shape) for shape in ROUND)


def two_bars(shapes: Sequence[Shape] = BOXES) -> Body:
    """A bar of half a metre, and a thinner one that hangs from its end."""
    upper = Part(name="upper", shape=shapes[0], tracked=("tx", "ty", "tz", "rx"))
    lower = Part(
        name="lower", parent="upper", joint_m=(0.0, 0.5, 0.0), shape=shapes[1],
        landmarks={"end": (0.0, 0.45, 0.0)},
    )  # fmt: skip
    return Body(name="bars", parts=(upper, lower))


def bent(body: Body, bend: float, turn: Sequence[float] = (0, 0, 0), at=(0.0, 0.0, 3.0)) -> Pose:
    """The lower bar bent about x, the whole turned by a rotation vector."""
    return Pose(exp_rotation(np.array([turn, (bend, 0.0, 0.0)])), np.array(at))


def surface_of(body: Body, pose: Pose, pieces: int = 3) -> SurfaceMesh:
    """The shapes' own meshes, finely cut, in a pose; where they overlap both stay."""
    Ts = pose_transforms(Skeleton.of(body), pose)
    vertices, faces = [], []
    for part, T in zip(body.parts, Ts, strict=True):
        mesh = part.shape.mesh()
        points, triangles = np.asarray(mesh.vertices), mesh.faces
        for _ in range(pieces):
            points, triangles = _cut(points, triangles)
        faces.append(triangles + sum(len(v) for v in vertices))
        vertices.append(apply_transform(T, points))
    return SurfaceMesh(np.concatenate(vertices), np.concatenate(faces))


def _cut(points: Array, faces):
    """Every triangle into four."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    ends, which = np.unique(edges, axis=0, return_inverse=True)
    middle = len(points) + which.reshape(-1, 3)
    points = np.concatenate([points, points[ends].mean(axis=1)])
    a, b, c = faces.T
    ab, bc, ca = middle.T
    four = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    return points, np.concatenate([np.stack(face, axis=1) for face in four])


def joints(body: Body, pose: Pose) -> Array:
    """Joints and ends, metres."""
    skeleton = Skeleton.of(body)
    return joint_positions(skeleton, pose_transforms(skeleton, pose))


@dataclass
class Given:
    """Steps out of a list; a sentence in it is what is wrong with that step."""

    meshes: list[SurfaceMesh | str]

    @property
    def frame_count(self) -> int:
        return len(self.meshes)

    def mesh(self, frame: int) -> SurfaceMesh:
        mesh = self.meshes[frame]
        if isinstance(mesh, str):
            raise SurfaceError(mesh)
        return mesh
