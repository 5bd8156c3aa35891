"""Pair points of two surfaces, weigh each pair, and give weights and distances by vertex.

SURFACE §3. Both are soft switches, near 0 where there can be no counterpart, 1 elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.cells import grid_of, nearest
from keypose.tracker.kernels.surface import distance_to_others
from keypose.tracker.surface.fit.model import PosedSurface, SurfaceModel, SurfaceSamples
from keypose.tracker.surface.fit.options import Options
from keypose.tracker.surface.mesh import SurfaceMesh

PHOTO_SLOPE = 12.0
PHOTO_MIDDLE = 0.4
"""α_p and τ_p of SURFACE (3), for ZNCC of little noisy pictures."""
CONTACT_SLOPE = 6.0
"""α_c · τ_c: at twice the middle distance all counts."""
LEAST_SHARE = 0.1
"""Of a part's surface that counts at least, though all of it be in contact."""


def contact_weights(distance: Array, middle_m: float) -> Array:
    """ρ_c of signed distances to other parts, metres.  SURFACE (2)

    middle_m: τ_c, some three times the observed surface's resolution.
    """
    return _switch(CONTACT_SLOPE * (distance / middle_m - 1.0))


def photo_weights(consistency: Array) -> Array:
    """ρ_p of ZNCC −1 to 1.  SURFACE (3)"""
    return _switch(PHOTO_SLOPE * (consistency - PHOTO_MIDDLE))


def raise_to_floor(weights: Array, part: NDArray[np.int64], part_count: int) -> Array:
    """Weights (V,) raised where the points of a part (V,) would hardly count: a hand on the hip.

    All of a part are raised alike, so that what is least in contact still counts most.
    """
    count = np.maximum(np.bincount(part, minlength=part_count), 1)
    share = np.bincount(part, weights, part_count) / count
    lift = np.clip(LEAST_SHARE / np.maximum(share, 1e-12), 1.0, 1e3)
    return np.minimum(weights * lift[part], 1.0)


def _switch(x: Array) -> Array:
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(x, -60.0, 60.0))))


REACH_SHARE = 0.15
"""Of the surface's size: nothing is a pair that lies farther apart."""
SPURIOUS = 0.1
"""A pair counts nothing where its partner's own nearest point has less than this share of the
pair's squared distance."""
MUTUAL = 0.5
"""It counts in full where that share is larger than this."""
SPURIOUS_SHARE = 0.005
"""Of the surface's size: nearer pairs need not be mutual."""
CONTACT_SHARE = 0.015
"""Of the surface's size: τ_c, three voxels of a hull of a person at a centimetre."""


@dataclass(frozen=True, eq=False)
class TargetSurface:
    """One step's surface, ready to be paired with.

    weights: (N,) ρ_p of its points.  grid: of these, as `grid_of` makes it.
    """

    samples: SurfaceSamples
    weights: Array
    grid: Any

    @classmethod
    def of(cls, mesh: SurfaceMesh, options: Options) -> TargetSurface:
        """Prepare a mesh in the camera frame, metres."""
        samples = SurfaceSamples.of(mesh, options.points)
        photo = options.photo and mesh.consistency is not None
        weights = photo_weights(samples.consistency) if photo else np.ones(len(samples.p))
        return cls(samples, weights, grid_of(samples.p, 2 * samples.spacing_m))


@dataclass(frozen=True, eq=False)
class Pairs:
    """M pairs: model[i] is drawn to target[i] along normals[i].

    model (M,) indices; target, normals (M, 3); weights (M,), those of each side sum to 1; the
    first `forward` pairs are the model's points with what is nearest to them, the rest the other
    way round.  square: (M,) squared distances.  clear: (V,) ρ_c of the model's points.
    """

    model: NDArray[np.int64]
    target: Array
    normals: Array
    weights: Array
    forward: int
    square: Array
    clear: Array


def pairs_of(
    model: SurfaceModel, posed: PosedSurface, observed: TargetSurface, options: Options
) -> Pairs:
    """Nearest points, both ways."""
    surface_samples = observed.samples
    grid = grid_of(posed.p, 2 * model.spacing_m)
    clear = clearance(model, posed, grid, options)
    reach = REACH_SHARE * model.size_m
    to_seen, far_there = _nearest(posed, surface_samples, observed.grid, reach, options)
    to_model, far_back = _nearest(surface_samples, posed, grid, reach, options)
    own = clear * model.trust
    there = own * observed.weights[to_seen] * (to_seen >= 0)
    back = own[to_model] * observed.weights * (to_model >= 0)
    if options.mutual:
        near = (SPURIOUS_SHARE * model.size_m) ** 2
        there = there * _mutual_pair_weight(far_there, far_back[to_seen], near)
        back = back * _mutual_pair_weight(far_back, far_there[to_model], near)
    return Pairs(
        np.concatenate([np.arange(len(posed.p)), np.maximum(to_model, 0)]),  # −1 weighs nothing
        np.concatenate([surface_samples.p[to_seen], surface_samples.p]),
        np.concatenate([surface_samples.normals[to_seen], surface_samples.normals]),
        np.concatenate([_normalise(there), _normalise(back)]),
        len(posed.p),
        np.concatenate([far_there, far_back]),
        clear,
    )


def clearance(model: SurfaceModel, posed: PosedSurface, grid: Any, options: Options) -> Array:
    """ρ_c (V,) of the model's points.  SURFACE (2)"""
    if not options.contact:
        return np.ones(len(posed.p))
    middle = CONTACT_SHARE * model.size_m
    distance = contact_distances(model, posed, grid, 2 * middle)
    clear = contact_weights(distance, middle)
    return raise_to_floor(clear, model.own, model.skeleton.part_count) if options.floor else clear


def contact_distances(model: SurfaceModel, posed: PosedSurface, grid: Any, reach: float) -> Array:
    """(V,) signed distances to the nearest other part, infinite beyond reach.  SURFACE (1)"""
    distance = np.empty(len(posed.p))
    distance_to_others(posed.p, posed.normals, model.own, model.apart, grid, reach, distance)
    return distance


def _nearest(
    of: PosedSurface | SurfaceSamples,
    among: PosedSurface | SurfaceSamples,
    grid: Any,
    reach: float,
    options: Options,
) -> tuple[NDArray[np.int64], Array]:
    """By point of the one surface the index of the other's nearest, −1 where none is within reach,
    and its squared distance."""
    index, square = np.empty(len(of.p), np.int64), np.empty(len(of.p))
    nearest(of.p, of.normals, among.p, among.normals, grid, reach, options.agreement, index, square)
    return index, square


def _mutual_pair_weight(square: Array, partner: Array, near: float) -> Array:
    """How much a pair counts when its partner has a better one of its own.

    A hand whose surface is missing is near the hip's, but that has the hip to lie on; so has the
    model's arm beside a volume that is not there. square, partner: squared distances of a point to
    its nearest, and of that one to its own nearest.
    """
    share = (partner + near) / (square + near)
    return np.asarray(np.clip((share - SPURIOUS) / (MUTUAL - SPURIOUS), 0.0, 1.0))


def _normalise(weights: Array) -> Array:
    """Weights that sum to 1."""
    return np.asarray(weights / max(weights.sum(), 1e-12))


Kind: TypeAlias = Literal["contact", "distance"]

_ANY_NORMAL = -2.0
"""A cosine that every pair of normals has."""


def vertex_scalars(model: SurfaceModel, mesh: SurfaceMesh, pose: Pose, kind: Kind) -> Array:
    """(V,) of a step's mesh in the camera frame, the body at a pose.

    contact: ρ_c of the body's nearest point, 0 to 1.
    distance: metres to the body's surface, REACH_SHARE of its size where that is farther.
    """
    posed = model.posed(pose_transforms(model.skeleton, pose))
    grid, reach = grid_of(posed.p, 2 * model.spacing_m), REACH_SHARE * model.size_m
    index, square = np.empty(len(mesh.vertices), np.int64), np.empty(len(mesh.vertices))
    nearest(
        mesh.vertices, mesh.normals, posed.p, posed.normals, grid, reach, _ANY_NORMAL, index, square
    )
    if kind == "distance":
        return np.sqrt(square)
    clear = clearance(model, posed, grid, Options(floor=False))
    return np.where(index >= 0, clear[index], 1.0)
