"""Points in the cells of a grid, and the nearest of them.

A grid is (low (3,), 1/cell, counts (3,), starts (cells + 1,), order (N,)): the points of cell c are
order[starts[c]:starts[c + 1]], cells counted with z fastest.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.kernels import compiled

MOST_CELLS = 400_000


@compiled
def grid_of(points, cell):
    """The grid of points (N, 3); cells grow where there would be too many of them."""
    low, high = np.empty(3), np.empty(3)
    for k in range(3):
        low[k], high[k] = points[:, k].min(), points[:, k].max()
    while True:
        counts = np.empty(3, np.int64)
        for k in range(3):
            counts[k] = np.int64((high[k] - low[k]) / cell) + 1
        if float(counts[0]) * counts[1] * counts[2] <= MOST_CELLS:
            break
        cell *= 1.26
    per = 1.0 / cell
    starts = np.zeros(counts[0] * counts[1] * counts[2] + 1, np.int64)
    place = np.empty(len(points), np.int64)
    for i in range(len(points)):
        x = min(np.int64((points[i, 0] - low[0]) * per), counts[0] - 1)
        y = min(np.int64((points[i, 1] - low[1]) * per), counts[1] - 1)
        z = min(np.int64((points[i, 2] - low[2]) * per), counts[2] - 1)
        place[i] = (x * counts[1] + y) * counts[2] + z
        starts[place[i] + 1] += 1
    for c in range(1, len(starts)):
        starts[c] += starts[c - 1]
    order, used = np.empty(len(points), np.int64), starts[:-1].copy()
    for i in range(len(points)):
        order[used[place[i]]] = i
        used[place[i]] += 1
    return low, per, counts, starts, order


@compiled
def nearest(queries, toward, points, normals, grid, reach, least, found, square):
    """Find for every query (N, 3) the nearest point whose normal agrees with the query's.

    toward, normals: unit normals of queries and points; they agree where their product is at least
    `least`.  Fills found (N,): the index, −1 where there is none within `reach`; square (N,): the
    squared distance.
    """
    low, per, counts, starts, order = grid
    cell = 1.0 / per
    furthest = np.int64(reach * per) + 1
    span = np.empty((3, 2), np.int64)
    home = np.empty(3, np.int64)
    for i in range(len(queries)):
        best, which = reach * reach, -1
        for k in range(3):
            home[k] = np.int64(np.floor((queries[i, k] - low[k]) * per))
        for ring in range(furthest + 1):
            inside = (ring - 1) * cell
            if ring > 0 and best <= inside * inside:
                break
            for k in range(3):
                span[k, 0], span[k, 1] = max(0, home[k] - ring), min(counts[k] - 1, home[k] + ring)
            for x in range(span[0, 0], span[0, 1] + 1):
                rim_x = abs(x - home[0]) == ring
                for y in range(span[1, 0], span[1, 1] + 1):
                    rim = rim_x or abs(y - home[1]) == ring
                    step = 1 if rim else 2 * ring
                    z = span[2, 0] if rim else home[2] - ring
                    while z <= span[2, 1]:
                        if z >= span[2, 0]:
                            c = (x * counts[1] + y) * counts[2] + z
                            for s in range(starts[c], starts[c + 1]):
                                q = order[s]
                                a = points[q, 0] - queries[i, 0]
                                b = points[q, 1] - queries[i, 1]
                                d = points[q, 2] - queries[i, 2]
                                far = a * a + b * b + d * d
                                if far < best and (
                                    toward[i, 0] * normals[q, 0]
                                    + toward[i, 1] * normals[q, 1]
                                    + toward[i, 2] * normals[q, 2]
                                    >= least
                                ):
                                    best, which = far, q
                        z += step
        found[i], square[i] = which, best
