"""Where rays of several cameras meet."""

from __future__ import annotations

import numpy as np

from keypose.tracker.geometry.rotations import Array

LEAST_DEPTH_M = 0.1
"""Of what is seen: nearer to a camera there is nobody."""


def where_rays_meet(xy: Array, scale: Array, Ts_camera_world: Array) -> Array:
    """Points (F, J, 3) in the world, each where the rays of all cameras meet best; NaN where fewer
    than two see it.  Linear, weighed once by the distances that come out.

    xy (V, F, J, 2): as x/z and y/z of each camera.  scale (V, F, J): 1/σ, 0 where not seen.
    Ts_camera_world (V, F, 4, 4).
    """
    weight, Ts = scale**2, Ts_camera_world
    points = _solved(*_meeting(xy, Ts, weight))
    z = np.einsum("vfa,fja->vfj", Ts[..., 2, :3], points) + Ts[..., None, 2, 3]
    points = _solved(*_meeting(xy, Ts, weight / np.maximum(z, LEAST_DEPTH_M) ** 2))
    return np.where(((scale > 0).sum(axis=0) > 1)[..., None], points, np.nan)


def _meeting(xy: Array, Ts: Array, weight: Array) -> tuple[Array, Array]:
    """Equations A (F, J, 3, 3), b (F, J, 3) of points that lie on rays of cameras (V, F, 4, 4)."""
    R, t = Ts[..., None, :3, :3], Ts[..., None, :3, 3]
    rows = R[..., :2, :] - xy[..., None] * R[..., 2:, :]
    right = xy * t[..., 2:] - t[..., :2]
    A = np.einsum("vfj,vfjka,vfjkb->fjab", weight, rows, rows)
    return A, np.einsum("vfj,vfjka,vfjk->fja", weight, rows, right)


def _solved(A: Array, b: Array) -> Array:
    scale = np.einsum("...ii->...", A)[..., None, None] + 1.0
    return np.asarray(np.linalg.solve(A + 1e-12 * scale * np.eye(3), b[..., None])[..., 0])
