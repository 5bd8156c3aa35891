"""The inner loops of surface fitting: a surface that moves with a body, and its pull on the pose.

Every point of the model moves with one part or with two, as shares say: rows of two, the second
share 0 where one part alone carries it.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.kernels import compiled


@compiled
def pose_surface(p_part, n_part, parts, shares, Ts_camera_part, p_each, p_camera, n_camera):
    """Points and normals of a posed surface.

    p_part, n_part (V, 2, 3) in the frames of parts (V, 2).  Fills p_each (V, 2, 3): where each of
    the two parts would carry the point; p_camera, n_camera (V, 3): where their shares do.
    """
    for i in range(len(p_part)):
        for k in range(3):
            p_camera[i, k] = n_camera[i, k] = 0.0
        for j in range(2):
            share = shares[i, j]
            T = Ts_camera_part[parts[i, j]]
            for k in range(3):
                p = T[k, 3]
                n = 0.0
                for m in range(3):
                    p += T[k, m] * p_part[i, j, m]
                    n += T[k, m] * n_part[i, j, m]
                p_each[i, j, k] = p
                p_camera[i, k] += share * p
                n_camera[i, k] += share * n


@compiled
def distance_to_others(points, normals, part, apart, grid, reach, distance):
    """Signed distance of every point to the nearest point of another part.  SURFACE (1)

    points, normals (V, 3); part (V,): whose each is.  apart (V, P): whether a point may touch a
    part; where it is joined to it, it may not.  grid: of the points, as in `cells`. The sign is
    that of the side of the other part's surface: negative inside it. Fills distance (V,), which is
    infinite where no other part is within reach.
    """
    low, per, counts, starts, order = grid
    rings = np.int64(reach * per) + 1
    home = np.empty(3, np.int64)
    for i in range(len(points)):
        best, which = reach * reach, -1
        for k in range(3):
            home[k] = np.int64((points[i, k] - low[k]) * per)
        for x in range(max(0, home[0] - rings), min(counts[0] - 1, home[0] + rings) + 1):
            for y in range(max(0, home[1] - rings), min(counts[1] - 1, home[1] + rings) + 1):
                row = (x * counts[1] + y) * counts[2]
                z0, z1 = max(0, home[2] - rings), min(counts[2] - 1, home[2] + rings)
                for s in range(starts[row + z0], starts[row + z1 + 1]):
                    q = order[s]
                    if part[q] == part[i] or not apart[i, part[q]]:
                        continue
                    a = points[i, 0] - points[q, 0]
                    b = points[i, 1] - points[q, 1]
                    c = points[i, 2] - points[q, 2]
                    far = a * a + b * b + c * c
                    if far < best:
                        best, which = far, q
        distance[i] = np.inf
        if which >= 0:
            side = 0.0
            for k in range(3):
                side += (points[i, k] - points[which, k]) * normals[which, k]
            distance[i] = np.sqrt(best) if side >= 0 else -np.sqrt(best)


@compiled
def pull(p_each, shares, groups, model, target, normals, weights, n_model, plane, A, b):
    """The normal equations of pairs, summed over the points that the same parts carry.

    Pair i draws model point model[i] to target (N, 3), with weights (N,): along normals (N, 3)
    where `plane` is 1, in all three directions where it is 0, between where it is between. A row of
    its Jacobian has 18 columns. The first 6 are of a symmetric matrix Q by which the whole surface
    swells: a point with the normal m (n_model, (V, 3)) moves by mᵀQm along it; they are Qxx, Qyy,
    Qzz, √2 Qxy, √2 Qyz, √2 Qzx. Then 6 for each of the point's two parts, (n, p × n), of its twist
    [velocity at the origin, turn].
    groups (V,): which of the G pairs of parts carries a point. Fills A (G, 18, 18) and b (G, 18),
    the sums of each pair of parts; the weighted sum of squares comes back.
    """
    A[:] = 0.0
    b[:] = 0.0
    row, n = np.empty(18), np.empty(3)
    total = 0.0
    for i in range(len(model)):
        if weights[i] <= 0:
            continue
        v = model[i]
        g = groups[v]
        x, y, z = n_model[v]
        for axis in range(4):
            w = weights[i] * (plane if axis == 3 else 1.0 - plane)
            if w == 0.0:
                continue
            for k in range(3):
                n[k] = normals[i, k] if axis == 3 else (1.0 if axis == k else 0.0)
            r = 0.0
            for k in range(3):
                p = shares[v, 0] * p_each[v, 0, k] + shares[v, 1] * p_each[v, 1, k]
                r += n[k] * (p - target[i, k])
            out = n[0] * x + n[1] * y + n[2] * z
            twice = np.sqrt(2.0) * out
            row[0], row[1], row[2] = out * x * x, out * y * y, out * z * z
            row[3], row[4], row[5] = twice * x * y, twice * y * z, twice * z * x
            used = 18 if shares[v, 1] > 0 else 12
            for j in range(used // 6 - 1):
                s, p, at = shares[v, j], p_each[v, j], 6 * j + 6
                for k in range(3):
                    row[at + k] = s * n[k]
                row[at + 3] = s * (p[1] * n[2] - p[2] * n[1])
                row[at + 4] = s * (p[2] * n[0] - p[0] * n[2])
                row[at + 5] = s * (p[0] * n[1] - p[1] * n[0])
            for j in range(used):
                b[g, j] += w * row[j] * r
                for k in range(j + 1):
                    A[g, j, k] += w * row[j] * row[k]
            total += w * r * r
    for g in range(len(A)):
        for j in range(18):
            for k in range(j):
                A[g, k, j] = A[g, j, k]
    return total
