"""Residuals and rows of the followed points, summed into one 7×7 block per part (DRIFT §2.3).

For a point p = (x, y, z) seen at (u, v), g = ∂E/∂p has the components
(fx E_u/z, fy E_v/z, −(x g_x + y g_y)/z); its row is [g, (p − c) × g] with c the centre that the
twists are taken about: near the body, so that single precision does not cancel. The gradient is
the target picture's, at the place where the point is at this moment.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.kernels import compiled
from keypose.tracker.kernels.layout import STEPS
from keypose.tracker.kernels.noise import FAR, LOST
from keypose.tracker.kernels.robust import HUBER, TUKEY

f4 = np.float32
GREY = f4(1 / STEPS)
X = np.uint64(0)
Y = np.uint64(1)
Z = np.uint64(2)
USE = np.uint64(3)

BLOCK = 256
HUBER_WIDTH = 1.345
TUKEY_WIDTH = 4.685
GAIN_CENTRE = 110.0
GAIN_SCALE = 0.02


@compiled
def gather(body, chosen, grey, begin, last, R, o, picture, lens, seen, need_seen, rows, taps):
    """Gather where points begin … last of one part fall in the picture, for `make_rows`.

    How many do, and how many leave the picture. Ignored pixels are neither.
    """
    height, width = picture.shape[0], picture.shape[1]
    fx, fy, cx, cy = f4(lens.fx), f4(lens.fy), f4(lens.cx), f4(lens.cy)
    flat = f4(1) / f4(lens.distance)
    left, top = f4(lens.left), f4(lens.top)
    right, bottom = f4(lens.left + width - 1), f4(lens.top + height - 1)
    first = np.uint64(lens.top * width + lens.left)
    flatly = lens.perspective == 0
    pixels = picture.reshape(height * width, 4)
    count = lost = 0
    for p in range(np.uint64(begin), np.uint64(last)):
        q = np.uint64(chosen[p])
        if need_seen and seen[q] == 0:
            continue
        a, b, d = body.points[q, X], body.points[q, Y], body.points[q, Z]
        x = R[0, 0] * a + R[0, 1] * b + R[0, 2] * d + o[0]
        y = R[1, 0] * a + R[1, 1] * b + R[1, 2] * d + o[1]
        z = R[2, 0] * a + R[2, 1] * b + R[2, 2] * d + o[2]
        s = flat if flatly else f4(1) / z
        u, v = fx * x * s + cx, fy * y * s + cy
        if not (u >= left and v >= top and u < right and v < bottom and z > f4(0.05)):
            lost += 1
            continue
        column, row = np.uint64(u), np.uint64(v)
        fu, fv = u - f4(column), v - f4(row)
        w00, w10 = (f4(1) - fu) * (f4(1) - fv), fu * (f4(1) - fv)
        w01, w11 = (f4(1) - fu) * fv, fu * fv
        k00 = row * np.uint64(width) + column - first
        k10, k01 = k00 + np.uint64(1), k00 + np.uint64(width)
        k11 = k01 + np.uint64(1)
        k = np.uint64(count)
        e = (
            f4(pixels[k00, X]) * w00
            + f4(pixels[k10, X]) * w10
            + f4(pixels[k01, X]) * w01
            + f4(pixels[k11, X]) * w11
        )
        eu = (
            f4(pixels[k00, Y]) * w00
            + f4(pixels[k10, Y]) * w10
            + f4(pixels[k01, Y]) * w01
            + f4(pixels[k11, Y]) * w11
        )
        ev = (
            f4(pixels[k00, Z]) * w00
            + f4(pixels[k10, Z]) * w10
            + f4(pixels[k01, Z]) * w01
            + f4(pixels[k11, Z]) * w11
        )
        use = (
            f4(pixels[k00, USE]) * w00
            + f4(pixels[k10, USE]) * w10
            + f4(pixels[k01, USE]) * w01
            + f4(pixels[k11, USE]) * w11
        )
        e, eu, ev, use = e * GREY, eu * GREY, ev * GREY, use * GREY
        taps[k, X], taps[k, Y], taps[k, Z], taps[k, USE] = e, eu, ev, use
        if use < f4(0.3):
            continue
        rows[0, k], rows[1, k], rows[2, k] = x, y, z
        rows[3, k], rows[4, k] = s, grey[p]
        count += 1
    return count, lost


@compiled
def make_rows(rows, taps, count, c, lens):
    """Turn gathered points into rows 0–8, in place.

    In: x, y, z, scale and source brightness in rows 0–4, [E, E_u, E_v, use] in taps (BLOCK, 4).
    """
    fx, fy, gz_share = f4(lens.fx), f4(lens.fy), f4(lens.perspective)
    for k in range(count):
        x, y, z, s, e = rows[0, k], rows[1, k], rows[2, k], rows[3, k], rows[4, k]
        gx, gy = taps[k, 1] * fx * s, taps[k, 2] * fy * s
        gz = -(x * gx + y * gy) * s * gz_share
        x, y, z = x - c[0], y - c[1], z - c[2]
        rows[0, k], rows[1, k], rows[2, k] = gx, gy, gz
        rows[3, k], rows[4, k], rows[5, k] = y * gz - z * gy, z * gx - x * gz, x * gy - y * gx
        rows[6, k] = taps[k, 0] - e
        rows[7, k] = (e - f4(GAIN_CENTRE)) * f4(GAIN_SCALE)
        rows[8, k] = f4(1)


@compiled
def weigh(rows, count, loss, scale, weights, histogram):
    """Robust weights of the residuals in rows[6], and their histogram in quarter grey levels."""
    for k in range(count):
        r = abs(rows[6, k])
        histogram[int(r * f4(4)) if r < f4(0.25 * FAR) else FAR] += 1
        weight = f4(1)
        if loss == HUBER:
            if r > scale:
                weight = scale / r
        elif loss == TUKEY:
            rest = f4(1) - (r / scale) * (r / scale)
            weight = rest * rest if rest > 0 else f4(0)
        weights[k] = weight


@compiled
def add_products(rows, weights, count, total):
    """total (9, 9) += Σ w row rowᵀ over rows 0–6, upper triangle.

    Written out so that the 28 sums stay in registers over one loop: twice as fast as 28 loops.
    """
    s00 = s01 = s02 = s03 = s04 = s05 = s06 = f4(0)
    s11 = s12 = s13 = s14 = s15 = s16 = f4(0)
    s22 = s23 = s24 = s25 = s26 = f4(0)
    s33 = s34 = s35 = s36 = f4(0)
    s44 = s45 = s46 = f4(0)
    s55 = s56 = f4(0)
    s66 = f4(0)
    for k in range(count):
        w = weights[k]
        r0, r1, r2, r3 = rows[0, k], rows[1, k], rows[2, k], rows[3, k]
        r4, r5, r6 = rows[4, k], rows[5, k], rows[6, k]
        v0, v1, v2, v3, v4, v5, v6 = w * r0, w * r1, w * r2, w * r3, w * r4, w * r5, w * r6
        s00 += v0 * r0
        s01 += v0 * r1
        s02 += v0 * r2
        s03 += v0 * r3
        s04 += v0 * r4
        s05 += v0 * r5
        s06 += v0 * r6
        s11 += v1 * r1
        s12 += v1 * r2
        s13 += v1 * r3
        s14 += v1 * r4
        s15 += v1 * r5
        s16 += v1 * r6
        s22 += v2 * r2
        s23 += v2 * r3
        s24 += v2 * r4
        s25 += v2 * r5
        s26 += v2 * r6
        s33 += v3 * r3
        s34 += v3 * r4
        s35 += v3 * r5
        s36 += v3 * r6
        s44 += v4 * r4
        s45 += v4 * r5
        s46 += v4 * r6
        s55 += v5 * r5
        s56 += v5 * r6
        s66 += v6 * r6
    total[0, 0] += s00
    total[0, 1] += s01
    total[0, 2] += s02
    total[0, 3] += s03
    total[0, 4] += s04
    total[0, 5] += s05
    total[0, 6] += s06
    total[1, 1] += s11
    total[1, 2] += s12
    total[1, 3] += s13
    total[1, 4] += s14
    total[1, 5] += s15
    total[1, 6] += s16
    total[2, 2] += s22
    total[2, 3] += s23
    total[2, 4] += s24
    total[2, 5] += s25
    total[2, 6] += s26
    total[3, 3] += s33
    total[3, 4] += s34
    total[3, 5] += s35
    total[3, 6] += s36
    total[4, 4] += s44
    total[4, 5] += s45
    total[4, 6] += s46
    total[5, 5] += s55
    total[5, 6] += s56
    total[6, 6] += s66


@compiled
def add_gain_products(rows, weights, count, total):
    """total (9, 9) += Σ w row rowᵀ for columns 7 and 8, the gain and the bias."""
    for b in range(7, 9):
        weighted = rows[b, :count] * weights[:count]
        for a in range(b + 1):
            s = f4(0)
            for k in range(count):
                s += weighted[k] * rows[a, k]
            total[a, b] += s


@compiled
def without_gain(total):
    """Remove a gain (column 7) and a bias (column 8) that explain the residuals best (Schur)."""
    aa, bb, ab = total[7, 7] + 1e-3, total[8, 8] + 1e-3, total[7, 8]
    det = aa * bb - ab * ab
    for i in range(6):
        gain = (bb * total[i, 7] - ab * total[i, 8]) / det
        bias = (aa * total[i, 8] - ab * total[i, 7]) / det
        for k in range(i, 7):
            total[i, k] -= gain * total[k, 7] + bias * total[k, 8]


@compiled
def sum_points(
    body,
    chosen,
    grey,
    starts,
    HR,
    Ho,
    centre,
    picture,
    lens,
    seen,
    need_seen,
    loss,
    scale,
    gain,
    N,
    histogram,
    rows,
):
    """N (P, 7, 7) ← Σ w [row, r]ᵀ[row, r] of every part; histogram of |r|; the number of points.

    Rows 0–5 are [g, (p − c) × g], 6 the residual r, 7 the source's brightness and 8 a one, for gain
    and bias. `loss` and `scale` choose the weights; `need_seen` drops points that the target pose
    hides (`seen` (S,) uint8); `gain` lets each part be brighter or darker than its source.
    """
    total = np.empty((9, 9))
    weights, taps = np.empty(BLOCK, np.float32), np.empty((BLOCK, 4), np.float32)
    c = centre.astype(np.float32)
    histogram[:] = 0
    points = 0
    for i in range(body.parents.shape[0]):
        R, o = HR[i].astype(np.float32), Ho[i].astype(np.float32)
        total[:] = 0.0
        first = starts[i]
        while first < starts[i + 1]:
            last = min(first + BLOCK, starts[i + 1])
            count, lost = gather(
                body, chosen, grey, first, last, R, o, picture, lens, seen, need_seen, rows, taps
            )
            make_rows(rows, taps, count, c, lens)
            weigh(rows, count, loss, f4(scale), weights, histogram)
            add_products(rows, weights, count, total)
            if gain:
                add_gain_products(rows, weights, count, total)
            histogram[LOST] += lost
            points += count
            first = last
        if gain:
            without_gain(total)
        for a in range(7):
            for b in range(a, 7):
                N[i, a, b] = total[a, b]
                N[i, b, a] = total[a, b]
    return points


@compiled
def count_inside(body, chosen, grey, starts, HR, Ho, picture, lens, landed):
    """landed (P,) ← how many of each part's followed points find a usable pixel."""
    taps, unseen = np.empty((BLOCK, 4), np.float32), np.empty(0, np.uint8)
    rows = np.empty((9, BLOCK), np.float32)
    for i in range(body.parents.shape[0]):
        R, o = HR[i].astype(np.float32), Ho[i].astype(np.float32)
        landed[i] = 0
        for first in range(starts[i], starts[i + 1], BLOCK):
            last = min(first + BLOCK, starts[i + 1])
            landed[i] += gather(
                body, chosen, grey, first, last, R, o, picture, lens, unseen, False, rows, taps
            )[0]


@compiled
def sum_residuals(body, chosen, grey, starts, HR, Ho, picture, lens, histogram, rows):
    """histogram of |r| of the followed points at a target pose; their number."""
    taps, unseen = np.empty((BLOCK, 4), np.float32), np.empty(0, np.uint8)
    histogram[:] = 0
    points = 0
    for i in range(body.parents.shape[0]):
        R, o = HR[i].astype(np.float32), Ho[i].astype(np.float32)
        first = starts[i]
        while first < starts[i + 1]:
            last = min(first + BLOCK, starts[i + 1])
            count, lost = gather(
                body, chosen, grey, first, last, R, o, picture, lens, unseen, False, rows, taps
            )
            for k in range(count):
                r = abs(taps[k, 0] - rows[4, k])
                histogram[int(r * f4(4)) if r < f4(0.25 * FAR) else FAR] += 1
            histogram[LOST] += lost
            points += count
            first = last
    return points
