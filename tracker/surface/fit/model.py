"""Move a surface with the body: points spread evenly over its mesh, carried by the nearest parts.

SURFACE §4.1: the skeleton is posed in the mesh of a step t_0 at which the mesh is whole, and every
point of the mesh goes with the nearest part.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import ALL_DOFS, ROTATIONS, Body
from keypose.tracker.body.joint_limits import Limits
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, apply_transform, frozen
from keypose.tracker.kernels.surface import pose_surface
from keypose.tracker.solver.pose_terms import JointLimits
from keypose.tracker.surface.mesh import SurfaceMesh

_GOLDEN = np.array([0.7548776662466927, 0.5698402909980532])
"""Multiples of these fill a square evenly, whatever their number."""

LARGE_FACE = 3.0
"""A face longer than so many spacings is flat by intent: its own normal is the surface's."""


@dataclass(frozen=True, eq=False)
class SurfaceSamples:
    """N points of a mesh, as many on every square centimetre; read-only.

    p, normals:  (N, 3) metres and unit vectors, in the mesh's frame.
    consistency: (N,) agreement of the cameras, −1 to 1; 1 where there are no images.
    face:        (N,) of the mesh that each lies on.
    spacing_m:   between neighbours, about.
    """

    p: Array
    normals: Array
    consistency: Array
    face: NDArray[np.int64]
    spacing_m: float

    @classmethod
    def of(cls, mesh: SurfaceMesh, count: int) -> SurfaceSamples:
        """`count` points, the same ones for the same mesh."""
        corners = mesh.vertices[mesh.faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        doubled = np.linalg.norm(normals, axis=1)
        upto = np.cumsum(doubled)
        spacing = float(np.sqrt(upto[-1] / 2 / count))
        face = np.searchsorted(upto, (np.arange(count) + 0.5) * (upto[-1] / count))
        shares = _shares(count)
        consistency = np.ones(count)
        if mesh.consistency is not None:
            consistency = np.einsum("nk,nk->n", shares, mesh.consistency[mesh.faces[face]])
        return cls(
            frozen(np.einsum("nk,nki->ni", shares, corners[face])),
            frozen(_normals(mesh, face, shares, normals, spacing)),
            frozen(consistency),
            face,
            spacing,
        )

    def select(self, which: NDArray[np.bool_]) -> SurfaceSamples:
        """Some of them."""
        return SurfaceSamples(
            frozen(self.p[which]),
            frozen(self.normals[which]),
            frozen(self.consistency[which]),
            self.face[which],
            self.spacing_m,
        )


def _shares(count: int) -> Array:
    """(N, 3) of a face's corners, spread evenly over the triangle."""
    a, b = ((np.arange(1, count + 1)[:, None] * _GOLDEN) % 1.0).T
    folded = a + b > 1
    a, b = np.where(folded, 1 - a, a), np.where(folded, 1 - b, b)
    return np.stack([1 - a - b, a, b], axis=1)


def _normals(
    mesh: SurfaceMesh, face: NDArray[np.int64], shares: Array, of_faces: Array, spacing: float
) -> Array:
    """Take the normals of the corners, which even out noise; on large faces the face's own."""
    smooth = np.einsum("nk,nki->ni", shares, mesh.normals[mesh.faces[face]])
    corners = mesh.vertices[mesh.faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    flat = longest[face] > LARGE_FACE * spacing
    normals = np.where(flat[:, None], of_faces[face], smooth)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.divide(normals, length, out=np.zeros_like(normals), where=length > 0))


SEEN_SHARE = 0.25
"""Of the body: so much is near the surface even where the mesh shows no more than half of it."""


def distances_to_parts(skeleton: Skeleton, Ts_camera_part: Array, p_camera: Array) -> Array:
    """(V, P) metres from points (V, 3) to the solids of all parts, negative inside.

    From the solid, not from its bone: a bone takes a share of its thicker neighbour's surface.
    """
    columns = []
    for part, T in zip(skeleton.body.parts, Ts_camera_part, strict=True):
        p_part = (p_camera - T[:3, 3]) @ T[:3, :3]
        columns.append(part.shape.distance(p_part))
    return np.stack(columns, axis=1)


def shares_of(
    distances: Array, parents: NDArray[np.int64], blend_m: float
) -> tuple[NDArray[np.int64], Array]:
    """Parts (V, 2) that carry each point and their shares (V, 2), which sum to 1.

    distances (V, P): to all parts.  blend_m: joined parts share a point whose distances to them
    differ by less than this; at 0 the nearest carries it alone.
    """
    two = np.argsort(distances, axis=1, kind="stable")[:, :2]
    if two.shape[1] < 2:
        two = np.repeat(two, 2, axis=1)
    ahead = np.take_along_axis(distances, two, axis=1) @ np.array([-1.0, 1.0])
    joined = (parents[two[:, 0]] == two[:, 1]) | (parents[two[:, 1]] == two[:, 0])
    first = np.ones(len(two))
    if blend_m > 0:
        first = np.where(joined, 0.5 + 0.5 * np.clip(ahead / blend_m, 0.0, 1.0), 1.0)
    return two, np.stack([first, 1.0 - first], axis=1)


def apart_m(to_solids: Array, p_surface: Array, p_solids: Array, far_m: float) -> float:
    """How far a body and its surface lie apart, metres.

    The larger of two: how far the surface's points are from the nearest solid, on average, which
    is large for a body that lies elsewhere or is too small; and how far the nearest quarter of the
    solids is from the surface, which is large for one that is too large.

    to_solids: (V,) distances of the surface's points p_surface (V, 3).  p_solids: (N, 3) on the
    solids.  far_m: what is farther counts as that, for it may be a thing held in a hand.
    """
    from scipy.spatial import cKDTree

    surface_off = np.minimum(np.abs(to_solids), far_m).mean()
    to_surface, _ = cKDTree(p_surface).query(p_solids)
    return float(max(surface_off, np.quantile(to_surface, SEEN_SHARE)))


SEAM_SHARE = 0.025
"""Of the surface's size: parts nearer than that at t_0 are joined there, and do not touch."""
BLEND_SHARE = 0.02
"""Of the surface's size: within it two joined parts share the surface, where that is smooth."""
HARDNESS = 1e-3
"""Per radian² beyond a joint's limit and (surface size)²: as strong as a limb's surface on its
turning. Surfaces of rough proportions would turn a foot around."""
FAR_SHARE = 0.1
"""Of the surface's size: a place so far from every solid may be of something else."""


def with_all_rotations(body: Body) -> Body:
    """The body with every part free to turn in every way: a surface shows more than a picture."""
    parts = (
        part.model_copy(update={"tracked": ALL_DOFS if part.parent is None else ROTATIONS})
        for part in body.parts
    )
    return body.replaced(parts)


@dataclass(frozen=True, eq=False)
class SurfaceModel:
    """V points of the surface at t_0, in the frames of the parts that carry them; read-only.

    p_part, n_part: (V, 2, 3) points and unit normals in the frames of parts (V, 2).
    shares:    (V, 2) of the two parts; the second is 0 where the first carries the point alone.
    apart:     (V, P) whether a point may come into contact with a part: it is not joined to it.
    groups:    (V,) index of its pair of parts among `pairs` (G, 2).
    size_m:    diagonal of the box around the surface.
    spacing_m: between neighbouring points, about.
    limits:    of the joints, wide enough for what was posed.
    trust:     (V,) how much each point counts beside the others, above 0 to 1.
    """

    skeleton: Skeleton
    p_part: Array
    n_part: Array
    parts: NDArray[np.int64]
    shares: Array
    apart: NDArray[np.bool_]
    groups: NDArray[np.int64]
    pairs: NDArray[np.int64]
    size_m: float
    spacing_m: float
    limits: Limits
    trust: Array

    @classmethod
    def of(
        cls, mesh: SurfaceMesh, body: Body, pose: Pose, count: int, smooth: bool = False
    ) -> SurfaceModel:
        """The mesh (camera frame, metres) of the step at which the body has this pose."""
        skeleton = Skeleton.of(with_all_rotations(body))
        samples = SurfaceSamples.of(mesh, count)
        size = float(np.linalg.norm(mesh.extent))
        Ts = pose_transforms(skeleton, pose)
        distances = distances_to_parts(skeleton, Ts, samples.p)
        parts, shares = shares_of(distances, skeleton.parents, BLEND_SHARE * size * smooth)
        return cls._bind(skeleton, samples, pose, Ts, parts, shares, size)

    @classmethod
    def of_solids(cls, body: Body, pose: Pose, count: int, size_m: float) -> SurfaceModel:
        """The body's own solids, for a first pose: what of them lies inside another is left out.

        size_m: of the surface that it is fitted to.
        """
        skeleton = Skeleton.of(with_all_rotations(body))
        Ts = pose_transforms(skeleton, pose)
        mesh, part_of_face = _solids(skeleton, Ts)
        samples = SurfaceSamples.of(mesh, count)
        own = part_of_face[samples.face]
        others = distances_to_parts(skeleton, Ts, samples.p)
        others[np.arange(len(own)), own] = np.inf
        bare = others.min(axis=1) > 0.0
        parts = np.stack([own, own], axis=1)[bare]
        shares = np.tile([1.0, 0.0], (len(parts), 1))
        return cls._bind(skeleton, samples.select(bare), pose, Ts, parts, shares, size_m)

    @classmethod
    def _bind(
        cls,
        skeleton: Skeleton,
        samples: SurfaceSamples,
        pose: Pose,
        Ts_camera_part: Array,
        parts: NDArray[np.int64],
        shares: Array,
        size_m: float,
    ) -> SurfaceModel:
        """Points of a posed surface, in the frames of the parts that carry them."""
        Ts = Ts_camera_part[parts]
        Rs, origins = Ts[..., :3, :3], Ts[..., :3, 3]
        pairs, groups = np.unique(parts, axis=0, return_inverse=True)
        apart = _apart(samples.p, parts[:, 0], skeleton.part_count, SEAM_SHARE * size_m)
        return cls(
            skeleton,
            frozen(np.einsum("vkji,vkj->vki", Rs, samples.p[:, None] - origins)),
            frozen(np.einsum("vkji,vj->vki", Rs, samples.normals)),
            parts,
            frozen(shares),
            apart,
            groups.ravel().astype(np.int64),
            pairs,
            size_m,
            samples.spacing_m,
            Limits.of(skeleton.body).widened([pose.Rs_parent_part]),
            frozen(np.ones(len(parts))),
        )

    @cached_property
    def limit_term(self) -> JointLimits:
        """The pull of joints back into their limits, in metres² as a step's energy."""
        return JointLimits(self.limits, 1 / np.sqrt(HARDNESS * self.size_m**2))

    @property
    def own(self) -> NDArray[np.int64]:
        """(V,) the part that carries most of each point."""
        return np.ascontiguousarray(self.parts[:, 0])

    def with_trust(self, trust: Array) -> SurfaceModel:
        """The same with its points counting by trust (V,)."""
        return replace(self, trust=frozen(trust))

    def off_share(self, pose: Pose) -> float:
        """How far the body's solids and the surface lie apart, over the surface's size.

        pose: the one at which the surface was bound.
        """
        Ts = pose_transforms(self.skeleton, pose)
        p_surface = self.posed(Ts).p
        to_solids = distances_to_parts(self.skeleton, Ts, p_surface).min(axis=1)
        solids = SurfaceSamples.of(_solids(self.skeleton, Ts)[0], len(p_surface))
        return apart_m(to_solids, p_surface, solids.p, FAR_SHARE * self.size_m) / self.size_m

    def posed(self, Ts_camera_part: Array) -> PosedSurface:
        """The surface with its parts at Ts_camera_part (P, 4, 4)."""
        count = len(self.p_part)
        each, p, n = np.empty((count, 2, 3)), np.empty((count, 3)), np.empty((count, 3))
        pose_surface(self.p_part, self.n_part, self.parts, self.shares, Ts_camera_part, each, p, n)
        return PosedSurface(each, p, n)


@dataclass(frozen=True, eq=False)
class PosedSurface:
    """Where the model's points are, camera frame, metres.

    p_each: (V, 2, 3) as each of two parts carries them.  p, normals: (V, 3) as both do.
    """

    p_each: Array
    p: Array
    normals: Array


def _solids(skeleton: Skeleton, Ts_camera_part: Array) -> tuple[SurfaceMesh, NDArray[np.int64]]:
    """The meshes of all parts as one, and the part of each face."""
    meshes = [part.shape.mesh() for part in skeleton.body.parts]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    vertices = [apply_transform(T, m.vertices) for T, m in zip(Ts_camera_part, meshes, strict=True)]
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    part = np.repeat(np.arange(len(meshes)), [len(mesh.faces) for mesh in meshes])
    return SurfaceMesh(np.concatenate(vertices), np.concatenate(faces)), part


def _apart(p: Array, own: NDArray[np.int64], part_count: int, seam_m: float) -> NDArray[np.bool_]:
    """(V, P) whether a point is farther from a part's surface than a seam is wide."""
    from scipy.spatial import cKDTree

    apart = np.ones((len(p), part_count), dtype=bool)
    for part in range(part_count):
        mine = own == part
        if mine.any():
            far, _ = cKDTree(p[mine]).query(p, distance_upper_bound=seam_m)
            apart[:, part] = np.isinf(far)
    return apart
