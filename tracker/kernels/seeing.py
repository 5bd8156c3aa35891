"""Which surface points a pose shows, and which of them to follow.

No mesh is rasterised: a point is seen when its normal faces the camera and no other part owns its
cell of a coarse buffer. So the same points are followed from frame to frame.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.kernels import compiled
from keypose.tracker.kernels.layout import STEPS

f4 = np.float32
# Unsigned indices: signed ones are checked for counting from the end.
X = np.uint64(0)
Y = np.uint64(1)
Z = np.uint64(2)
USE = np.uint64(3)


@compiled
def nearest_parts(body, HR, Ho, lens, visibility, width, height, uvz, seen, depth, owner):
    """Project the points that face the camera; keep the nearest part of every cell.

    Fills uvz (S, 3) float32: pixel and z; seen (S,) uint8: 1 where facing and inside the picture;
    depth, owner (rows, columns): nearest z and its part.
    """
    depth[:] = f4(1e9)
    owner[:] = -1
    per_cell = f4(1) / f4(visibility.cell)
    flat = f4(1) / f4(lens.distance)
    least = f4(visibility.facing) * f4(visibility.facing)
    fx, fy, cx, cy = f4(lens.fx), f4(lens.fy), f4(lens.cx), f4(lens.cy)
    left, top = f4(lens.left), f4(lens.top)
    right, bottom = f4(lens.left + width - 1), f4(lens.top + height - 1)
    first_column, first_row = first_cell(lens, visibility)
    eye, near = np.empty(3, np.float32), f4(lens.perspective)
    for i in range(body.parents.shape[0]):
        R, o = HR[i].astype(np.float32), Ho[i].astype(np.float32)
        eye_in_part(HR[i], Ho[i], lens.perspective, eye)
        for q in range(np.uint64(body.starts[i]), np.uint64(body.starts[i + 1])):
            seen[q] = 0
            a, b, c = body.points[q, X], body.points[q, Y], body.points[q, Z]
            sa, sb, sc = a * near - eye[0], b * near - eye[1], c * near - eye[2]
            toward = body.normals[q, X] * sa + body.normals[q, Y] * sb + body.normals[q, Z] * sc
            if not toward < 0:
                continue
            z = R[2, 0] * a + R[2, 1] * b + R[2, 2] * c + o[2]
            if not z > f4(0.05):
                continue
            x = R[0, 0] * a + R[0, 1] * b + R[0, 2] * c + o[0]
            y = R[1, 0] * a + R[1, 1] * b + R[1, 2] * c + o[1]
            scale = f4(1) / z if lens.perspective == 1 else flat
            u, v = fx * x * scale + cx, fy * y * scale + cy
            if not (u >= left and v >= top and u < right and v < bottom):
                continue
            column = np.uint64((u + f4(0.5)) * per_cell) - first_column
            row = np.uint64((v + f4(0.5)) * per_cell) - first_row
            if z < depth[row, column]:
                depth[row, column] = z
                owner[row, column] = i
            if toward * toward >= least * (sa * sa + sb * sb + sc * sc):
                uvz[q, X], uvz[q, Y], uvz[q, Z] = u, v, z
                seen[q] = 1


@compiled
def first_cell(lens, visibility):
    """Column and row of the occlusion buffer's first cell, counted from the whole picture's."""
    return np.uint64(lens.left // visibility.cell), np.uint64(lens.top // visibility.cell)


@compiled
def eye_in_part(R, o, perspective, eye):
    """eye (3) ← the camera's centre in a part's frame; for a telephoto camera, minus its axis."""
    for a in range(3):
        if perspective == 1:
            eye[a] = -(R[0, a] * o[0] + R[1, a] * o[1] + R[2, a] * o[2])
        else:
            eye[a] = -R[2, a]


@compiled
def see(body, HR, Ho, lens, visibility, width, height, uvz, seen, depth, owner):
    """`nearest_parts`, then seen ← 0 where another part covers a point; the number still seen."""
    nearest_parts(body, HR, Ho, lens, visibility, width, height, uvz, seen, depth, owner)
    per_cell, tolerance = f4(1) / f4(visibility.cell), f4(visibility.tolerance)
    first_column, first_row = first_cell(lens, visibility)
    count = 0
    for i in range(body.parents.shape[0]):
        for q in range(np.uint64(body.starts[i]), np.uint64(body.starts[i + 1])):
            if seen[q] == 0:
                continue
            column = np.uint64((uvz[q, X] + f4(0.5)) * per_cell) - first_column
            row = np.uint64((uvz[q, Y] + f4(0.5)) * per_cell) - first_row
            if owner[row, column] != i and uvz[q, Z] > depth[row, column] + tolerance:
                seen[q] = 0
            else:
                count += 1
    return count


@compiled
def room(body, visibility, width, height):
    """Arrays to look at a body with: HR, Ho, uvz, seen, depth, owner, chosen, grey, starts."""
    parts, size = body.parents.shape[0], body.points.shape[0]
    cells = (height // visibility.cell + 2, width // visibility.cell + 2)
    return (
        np.empty((parts, 3, 3)),
        np.empty((parts, 3)),
        np.empty((size, 3), np.float32),
        np.zeros(size, np.uint8),
        np.empty(cells, np.float32),
        np.empty(cells, np.int16),
        np.empty(size + 1, np.int32),
        np.empty(size + 1, np.float32),
        np.empty(parts + 1, np.int64),
    )


@compiled
def pick(body, uvz, seen, picture, lens, scale, of, every, chosen, grey, starts):
    """Choose which seen points to follow, with their brightness in the source picture.

    Of every `of` neighbours (after taking each `every`-th point) the one with the largest gradient
    is kept; points on pixels that may not be a source (channel 3 below `least`) are left out. Fills
    chosen (S,) int32, grey (S,) float32, starts (P + 1,) by part; `lens` and `scale` are the
    pyramid level's.
    """
    right, bottom = lens.left + picture.shape[1] - 1, lens.top + picture.shape[0] - 1
    k, half = f4(scale), f4(0.5)
    count = 0
    for i in range(body.parents.shape[0]):
        starts[i] = count
        group, best = 0, f4(-1)
        for q in range(np.uint64(body.starts[i]), np.uint64(body.starts[i + 1]), np.uint64(every)):
            if seen[q] == 0:
                continue
            column, row = np.int64(uvz[q, X] * k + half), np.int64(uvz[q, Y] * k + half)
            if column < lens.left or row < lens.top or column >= right or row >= bottom:
                continue
            across, down = np.uint64(column - lens.left), np.uint64(row - lens.top)
            if picture[down, across, USE] < body.least[i]:
                continue
            gx, gy = f4(picture[down, across, Y]), f4(picture[down, across, Z])
            if group == 0 or gx * gx + gy * gy > best:
                best = gx * gx + gy * gy
                chosen[count] = q
            group += 1
            if group == of:
                count += 1
                group = 0
        if group * 2 >= of:
            count += 1
    starts[body.parents.shape[0]] = count
    for p in range(count):
        grey[p] = brightness(picture, lens, uvz[chosen[p], 0] * k, uvz[chosen[p], 1] * k)
    return count


@compiled
def brightness(picture, lens, u, v):
    """Grey levels between four pixels; u, v must leave room for the pixel right and below."""
    column = max(min(int(u), lens.left + picture.shape[1] - 2), lens.left)
    row = max(min(int(v), lens.top + picture.shape[0] - 2), lens.top)
    fu, fv = u - f4(column), v - f4(row)
    x, y = column - lens.left, row - lens.top
    upper = f4(picture[y, x, 0]) * (f4(1) - fu) + f4(picture[y, x + 1, 0]) * fu
    lower = f4(picture[y + 1, x, 0]) * (f4(1) - fu) + f4(picture[y + 1, x + 1, 0]) * fu
    return (upper * (f4(1) - fv) + lower * fv) * f4(1 / STEPS)
