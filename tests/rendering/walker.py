"""A walking human as observed surfaces, with exact joints: as it is, and in ways that are harder.

plain      the surface itself.
contact    arms and legs brought together halfway: what touches is one surface, the union's.
missing20  a fifth of the surface missing at every step but the first, in holes that wander.
noise1cm   every vertex moved at random, 1 cm standard deviation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from bench.keeping import digest, place_for
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.surface.mesh import SurfaceMesh
from tests.rendering.arms import made_by, observed
from tests.rendering.kept_meshes import keep_meshes, kept_meshes
from tests.rendering.ring import Skin, ring_of
from tests.rendering.walker_body import Human, body_and_poses
from tests.rendering.winding import united

WalkKind: TypeAlias = Literal["plain", "contact", "missing20", "noise1cm"]

MADE_BY = ("arms", "walker", "walker_body", "winding", "ring", "shade", "texture")
UNION_VOXEL_M = 0.008
HULL_VOXEL_M = 0.01
REACH_M = 3.1
HOLE_M = 0.09
"""Radius of a hole in the surface."""

LEG_IN_DEG = 6.0
HAND_AT_M = 0.12
"""Of `brought_together`, halfway: the turn of the thighs, the hands' distance from the middle."""


@dataclass(frozen=True, eq=False)
class Walk:
    """steps: observed meshes, metres in the camera frame.

    joints: (F, P, 3) true joints, of the parts in their order.  poses: the true ones.
    """

    steps: list[SurfaceMesh]
    joints: Array
    body: Body
    poses: list[Pose]

    @property
    def skeleton(self) -> Skeleton:
        return Skeleton.of(self.body)


def walker(kind: WalkKind = "plain", cameras: int | None = None, seed: int = 0) -> Walk:
    """cameras: of so many the hull, with photo-consistency; None: the surface itself.

    Absent where the shared data is not here.
    """
    human = Human.load()
    if kind == "contact":
        human = brought_together(human)
    body, poses = body_and_poses(human, human.Ts_joint)
    joints = human.Ts_joint[..., :3, 3]
    return Walk(_steps(human, kind, cameras, seed), joints, body, poses)


def _steps(human: Human, kind: WalkKind, cameras: int | None, seed: int) -> list[SurfaceMesh]:
    if cameras is None and kind != "contact":
        plain = [SurfaceMesh(p, human.faces) for p in human.vertices]
        return [_spoilt(mesh, kind, seed, i) for i, mesh in enumerate(plain)]
    key = digest(*made_by(*MADE_BY), repr((kind, cameras, seed)).encode())
    place = place_for(f"walker-{kind}-{cameras}-{seed}", key, ".npz")
    if not place.is_file():
        steps = (
            [united(p, human.faces, UNION_VOXEL_M) for p in human.vertices]
            if cameras is None
            else _hulls(human, cameras, seed)
        )
        keep_meshes(place, steps)
    return [_spoilt(mesh, kind, seed, i) for i, mesh in enumerate(kept_meshes(place))]


def _hulls(human: Human, cameras: int, seed: int) -> list[SurfaceMesh]:
    """What a ring of cameras makes of the textured surface."""
    skin = Skin(human.vertices[0], human.faces, seed)
    views = ring_of(cameras, human.vertices.mean(axis=(0, 1)), REACH_M)
    steps = []
    for step, p in enumerate(human.vertices):
        shots = [skin.seen_by(view, p, [seed, step, i]) for i, view in enumerate(views)]
        steps.append(observed(views, shots, HULL_VOXEL_M))
    return steps


def brought_together(human: Human) -> Human:
    """The same walk with the hands brought to the thighs and these turned inward, about halfway.

    The skin follows as linear blending has it, from each step's own pose.
    """
    share = np.sin(np.linspace(0, np.pi, human.frame_count)) ** 2
    Ts = human.Ts_joint.copy()
    vertices = human.vertices.copy()
    for frame in range(human.frame_count):
        for side, arm, hand, thigh in ((1, 5, 9, 11), (-1, 6, 10, 12)):
            leg_in = [0.0, 0.0, side * np.radians(LEG_IN_DEG)]
            _turn(Ts[frame], human.parents, thigh, share[frame] * np.array(leg_in))
            _, y, z = Ts[frame, hand, :3, 3] - Ts[frame, arm, :3, 3]
            _turn(Ts[frame], human.parents, arm, share[frame] * np.array([-np.arctan2(z, y), 0, 0]))
            x, y, _ = Ts[frame, hand, :3, 3] - Ts[frame, arm, :3, 3]
            wanted = Ts[frame, 0, 0, 3] + side * HAND_AT_M - Ts[frame, arm, 0, 3]
            inward = np.arctan2(x, y) - np.arcsin(wanted / np.hypot(x, y))
            _turn(Ts[frame], human.parents, arm, share[frame] * np.array([0, 0, inward]))
        moved = Ts[frame] @ np.linalg.inv(human.Ts_joint[frame])
        blend = np.einsum("vj,jab->vab", human.weights, moved)
        p = human.vertices[frame]
        vertices[frame] = np.einsum("vab,vb->va", blend[:, :3, :3], p) + blend[:, :3, 3]
    return replace(human, vertices=vertices, Ts_joint=Ts)


def _turn(Ts: Array, parents: Array, joint: int, turn: Array) -> None:
    """Turn a joint and all below it by a rotation vector of the camera frame, in place."""
    T = np.eye(4)
    T[:3, :3] = exp_rotation(turn)
    T[:3, 3] = Ts[joint, :3, 3] - T[:3, :3] @ Ts[joint, :3, 3]
    below = [joint]
    for j in range(joint + 1, len(parents)):
        if parents[j] in below:
            below.append(j)
    Ts[below] = T @ Ts[below]


def _spoilt(mesh: SurfaceMesh, kind: WalkKind, seed: int, step: int) -> SurfaceMesh:
    rng = np.random.default_rng([seed, step])
    if kind == "noise1cm":
        return replace(mesh, vertices=mesh.vertices + rng.normal(0, 0.01, mesh.vertices.shape))
    if kind == "missing20" and step > 0:
        return _with_holes(mesh, 0.2, rng)
    return mesh


def _with_holes(mesh: SurfaceMesh, share: float, rng: np.random.Generator) -> SurfaceMesh:
    """Without this share of the surface's area."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    middles, kept = (a + b + c) / 3, np.ones(len(mesh.faces), bool)
    while areas[~kept].sum() < share * areas.sum():
        centre = middles[rng.choice(np.nonzero(kept)[0])]
        kept &= np.linalg.norm(middles - centre, axis=1) > HOLE_M
    used, faces = np.unique(mesh.faces[kept], return_inverse=True)
    agreed = None if mesh.consistency is None else mesh.consistency[used]
    return SurfaceMesh(mesh.vertices[used], faces.reshape(-1, 3), agreed)
