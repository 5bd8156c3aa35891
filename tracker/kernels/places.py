"""Where places on posed bodies are, how they move, and what they are compared with: many poses at
once.

A place moves with few degrees of freedom, those of the parts that it hangs on. So normal equations
are summed over these alone, row by row: no Jacobian is ever written out for all.
"""

from __future__ import annotations

import math

import numpy as np

from keypose.tracker.kernels import compiled
from keypose.tracker.kernels.chain import camera_twists, place_parts
from keypose.tracker.kernels.robust import robust_loss, robust_weight


@compiled
def place_poses(chain, R, t, HR, Ho, S):
    """HR (N, P, 3, 3), Ho (N, P, 3), S (N, D, 6) ← the parts and twists of poses R, t."""
    for n in range(R.shape[0]):
        place_parts(chain, R[n], t[n], HR[n], Ho[n])
        camera_twists(chain, HR[n], Ho[n], S[n])


@compiled
def put_point(places, k, HR, Ho, p):
    """p (3,) ← single point k of one pose, in the camera frame."""
    i = places.parts[k]
    for a in range(3):
        p[a] = (
            HR[i, a, 0] * places.points[k, 0]
            + HR[i, a, 1] * places.points[k, 1]
            + HR[i, a, 2] * places.points[k, 2]
            + Ho[i, a]
        )


@compiled
def put_place_of(places, j, HR, Ho, point, p):
    """p (3,) ← place j of one pose: the mean of its points. point (3,) is scratch."""
    share = 1.0 / (places.starts[j + 1] - places.starts[j])
    p[0] = p[1] = p[2] = 0.0
    for k in range(places.starts[j], places.starts[j + 1]):
        put_point(places, k, HR, Ho, point)
        for a in range(3):
            p[a] += share * point[a]


@compiled
def put_motion_of(places, j, HR, Ho, S, point, p, v):
    """The same, and v (L, 3) ← how it moves with each of the L degrees of freedom that move it."""
    share = 1.0 / (places.starts[j + 1] - places.starts[j])
    first, last = places.dof_starts[j], places.dof_starts[j + 1]
    p[0] = p[1] = p[2] = 0.0
    for m in range(last - first):
        v[m, 0] = v[m, 1] = v[m, 2] = 0.0
    for k in range(places.starts[j], places.starts[j + 1]):
        put_point(places, k, HR, Ho, point)
        x, y, z = point[0], point[1], point[2]
        p[0] += share * x
        p[1] += share * y
        p[2] += share * z
        for m in range(last - first):
            d = places.dofs[first + m]
            if places.moves[k, d]:
                v[m, 0] += share * (S[d, 0] + S[d, 4] * z - S[d, 5] * y)
                v[m, 1] += share * (S[d, 1] + S[d, 5] * x - S[d, 3] * z)
                v[m, 2] += share * (S[d, 2] + S[d, 3] * y - S[d, 4] * x)


@compiled
def place_all(places, HR, Ho, p):
    """p (N, J, 3) ← all places of all poses."""
    point = np.empty(3)
    for n in range(p.shape[0]):
        for j in range(p.shape[1]):
            put_place_of(places, j, HR[n], Ho[n], point, p[n, j])


@compiled
def move_all(places, HR, Ho, S, p, J):
    """The same, and J (N, J, D, 3), zeros before, ← how they move."""
    point, v = np.empty(3), np.empty((J.shape[2], 3))
    for n in range(p.shape[0]):
        for j in range(p.shape[1]):
            put_motion_of(places, j, HR[n], Ho[n], S[n], point, p[n, j], v)
            first = places.dof_starts[j]
            for m in range(places.dof_starts[j + 1] - first):
                for a in range(3):
                    J[n, j, places.dofs[first + m], a] = v[m, a]


@compiled
def picture_cost(places, HR, Ho, lens, uv, scale, nearest, kind, width):
    """The cost of places seen at uv (N, J, 2), scale (N, J) in 1/px; infinite with one that is
    nearer than that."""
    point, p, cost = np.empty(3), np.empty(3), 0.0
    for n in range(uv.shape[0]):
        for j in range(uv.shape[1]):
            put_place_of(places, j, HR[n], Ho[n], point, p)
            if not p[2] > nearest:
                return np.inf
            if scale[n, j] == 0:
                continue
            z = p[2] if lens.perspective == 1 else lens.distance
            du = lens.fx * p[0] / z + lens.cx - uv[n, j, 0]
            dv = lens.fy * p[1] / z + lens.cy - uv[n, j, 1]
            cost += robust_loss(kind, width, math.sqrt(du * du + dv * dv) * scale[n, j])
    return 0.5 * cost


@compiled
def add_picture(places, HR, Ho, S, lens, uv, scale, nearest, kind, width, A, b):
    """The same, and A (N, D, D), b (N, D) += the normal equations of every pose."""
    point, p = np.empty(3), np.empty(3)
    v, g = np.empty((b.shape[1], 3)), np.empty((b.shape[1], 2))
    cost, near = 0.0, False
    for n in range(uv.shape[0]):
        for j in range(uv.shape[1]):
            put_motion_of(places, j, HR[n], Ho[n], S[n], point, p, v)
            near = near or not p[2] > nearest
            if scale[n, j] == 0:
                continue
            z = p[2] if lens.perspective == 1 else lens.distance
            du = lens.fx * p[0] / z + lens.cx - uv[n, j, 0]
            dv = lens.fy * p[1] / z + lens.cy - uv[n, j, 1]
            away = math.sqrt(du * du + dv * dv) * scale[n, j]
            cost += robust_loss(kind, width, away)
            w = robust_weight(kind, width, away) * scale[n, j] * scale[n, j]
            first = places.dof_starts[j]
            count = places.dof_starts[j + 1] - first
            a, c = lens.fx / z, lens.fy / z
            x, y = p[0] / z * lens.perspective, p[1] / z * lens.perspective
            for m in range(count):
                g[m, 0] = a * (v[m, 0] - x * v[m, 2])
                g[m, 1] = c * (v[m, 1] - y * v[m, 2])
            for m in range(count):
                d, gu, gv = places.dofs[first + m], w * g[m, 0], w * g[m, 1]
                b[n, d] += gu * du + gv * dv
                for k in range(count):
                    A[n, d, places.dofs[first + k]] += gu * g[k, 0] + gv * g[k, 1]
    return np.inf if near else 0.5 * cost


@compiled
def depth_cost(places, HR, Ho, depth, scale, kind, width):
    """The cost of places so much farther away than the root: depth (N, J), scale (N, J) in 1/m."""
    point, p, cost = np.empty(3), np.empty(3), 0.0
    for n in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            if scale[n, j] == 0:
                continue
            put_place_of(places, j, HR[n], Ho[n], point, p)
            away = (p[2] - Ho[n, 0, 2] - depth[n, j]) * scale[n, j]
            cost += robust_loss(kind, width, abs(away))
    return 0.5 * cost


@compiled
def add_depth(chain, places, HR, Ho, S, depth, scale, kind, width, A, b):
    """The same, and A (N, D, D), b (N, D) += the normal equations of every pose."""
    point, p, v = np.empty(3), np.empty(3), np.empty((b.shape[1], 3))
    cost = 0.0
    for n in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            if scale[n, j] == 0:
                continue
            put_motion_of(places, j, HR[n], Ho[n], S[n], point, p, v)
            away = p[2] - Ho[n, 0, 2] - depth[n, j]
            size = abs(away) * scale[n, j]
            cost += robust_loss(kind, width, size)
            w = robust_weight(kind, width, size) * scale[n, j] * scale[n, j]
            first = places.dof_starts[j]
            count = places.dof_starts[j + 1] - first
            for m in range(count):
                if chain.dof_turns[places.dofs[first + m]] == 0:
                    v[m, 2] = 0.0  # it shifts the root as well
            for m in range(count):
                d, g = places.dofs[first + m], w * v[m, 2]
                b[n, d] += g * away
                for k in range(count):
                    A[n, d, places.dofs[first + k]] += g * v[k, 2]
    return 0.5 * cost


@compiled
def find_windows(chain, corners, lens, nearest, R, t, windows):
    """windows (N, 4) ← left, top, right and bottom pixel of the corners (P, K, 3) of a body's parts
    in poses R, t; infinite where one is nearer than that, or nowhere."""
    parts = corners.shape[0]
    HR, Ho = np.empty((parts, 3, 3)), np.empty((parts, 3))
    for n in range(windows.shape[0]):
        place_parts(chain, R[n], t[n], HR, Ho)
        left = top = np.inf
        right = bottom = -np.inf
        is_near = False
        for i in range(parts):
            for k in range(corners.shape[1]):
                a, b, c = corners[i, k, 0], corners[i, k, 1], corners[i, k, 2]
                x = HR[i, 0, 0] * a + HR[i, 0, 1] * b + HR[i, 0, 2] * c + Ho[i, 0]
                y = HR[i, 1, 0] * a + HR[i, 1, 1] * b + HR[i, 1, 2] * c + Ho[i, 1]
                z = HR[i, 2, 0] * a + HR[i, 2, 1] * b + HR[i, 2, 2] * c + Ho[i, 2]
                is_near = is_near or not z > nearest
                away = z if lens.perspective == 1 else lens.distance
                u, v = x / away * lens.fx + lens.cx, y / away * lens.fy + lens.cy
                left, right = min(left, u), max(right, u)
                top, bottom = min(top, v), max(bottom, v)
        if is_near or not np.isfinite(left + right + top + bottom):
            left = top = -np.inf
            right = bottom = np.inf
        windows[n, 0], windows[n, 1] = left, top
        windows[n, 2], windows[n, 3] = right, bottom
