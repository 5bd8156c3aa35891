"""The union of all that a closed surface encloses, also where the surface cuts through itself."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels import compiled
from keypose.tracker.surface.cameras.hull import Field, surface_of
from keypose.tracker.surface.mesh import SurfaceMesh


def united(vertices: Array, faces: NDArray[np.int64], voxel_m: float) -> SurfaceMesh:
    """The outer surface: places the surface winds about at least once, on a grid, smoothed."""
    p_origin = vertices.min(axis=0) - 4 * voxel_m
    shape = tuple(int(n) for n in np.ceil(np.ptp(vertices, axis=0) / voxel_m) + 9)
    winding = np.zeros(shape, np.float32)
    # Half a voxel's odd fraction aside, so that no column passes through a vertex.
    wind((vertices - p_origin) / voxel_m + 0.5e-3, faces, winding)
    filled = np.clip(np.cumsum(winding, axis=2), 0.0, 1.0)
    depths = voxel_m * 2 * (ndimage.gaussian_filter(filled, 1.0) - 0.5)
    return surface_of(Field(p_origin, voxel_m, depths.astype(np.float32)))


@compiled
def wind(p: Array, faces: NDArray[np.int64], winding: NDArray[np.float32]) -> None:
    """Add ±1 where a column along z enters or leaves, shared by the two grid points about it.

    p (V, 3) in grid points. The sum along a column is how often the surface winds about a point.
    """
    for k in range(faces.shape[0]):
        a, b, c = p[faces[k, 0]], p[faces[k, 1]], p[faces[k, 2]]
        area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
        if area == 0.0:
            continue
        low_i, high_i = min(a[0], b[0], c[0]), max(a[0], b[0], c[0])
        low_j, high_j = min(a[1], b[1], c[1]), max(a[1], b[1], c[1])
        for i in range(math.ceil(low_i), math.floor(high_i) + 1):
            for j in range(math.ceil(low_j), math.floor(high_j) + 1):
                s = ((i - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (j - a[1])) / area
                t = ((b[0] - a[0]) * (j - a[1]) - (i - a[0]) * (b[1] - a[1])) / area
                if s < 0.0 or t < 0.0 or s + t > 1.0:
                    continue
                z = a[2] + s * (b[2] - a[2]) + t * (c[2] - a[2])
                sign = -1.0 if area > 0.0 else 1.0
                nearest = math.floor(z + 0.5)
                share = nearest + 0.5 - z
                winding[i, j, nearest] += sign * share
                winding[i, j, nearest + 1] += sign * (1.0 - share)
