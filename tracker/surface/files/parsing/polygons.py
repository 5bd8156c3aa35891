"""Faces of any number of corners, cut into triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.surface.files.parsing.raw import require_counts


def fan(corners: NDArray[np.int64], counts: NDArray[np.int64], vertices: int) -> NDArray[np.int64]:
    """(F, 3) triangles around the first corner of every polygon.

    corners: (sum of counts,) vertex indices, polygon after polygon; counts: (P,). Polygons of fewer
    than three corners are none. Refused where there are more triangles than are read.
    """
    triangles = np.maximum(counts - 2, 0)
    total = int(triangles.sum())
    require_counts(vertices, total)
    first = np.repeat(np.cumsum(counts) - counts, triangles)
    place = np.arange(total) - np.repeat(np.cumsum(triangles) - triangles, triangles)
    return np.stack(
        [corners[first], corners[first + place + 1], corners[first + place + 2]], axis=1
    )


def runs(
    values: NDArray[np.float64], starts: NDArray[np.int64], counts: NDArray[np.int64]
) -> NDArray[np.int64]:
    """The integers values[s : s + n] of every start s and count n, one after the other."""
    place = np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.asarray(values[np.repeat(starts, counts) + place], dtype=np.int64)
