"""Which part carries a point of the surface: the one whose solid is nearest (SURFACE §4.1); and
whether the solids lie in it at all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array

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
