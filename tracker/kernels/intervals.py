"""How far interpolation between two frames of a motion leads from the motion between them.

A frame's miss is that of the body point that is farthest off: its distance in space or in the
picture as a share of what is allowed, whichever is larger, squared.

An interval is left at the first point that is off by more. It is remembered as the witness and
looked at first in the next interval, so that most intervals cost one limb of one pose. Frames are
gone through in great strides from the middle, since neighbours are off by about as much.
"""

from __future__ import annotations

import math

import numpy as np

from keypose.tracker.kernels import compiled
from keypose.tracker.kernels.rigid import exponential, logarithm, product, put, turned_back

NEAREST_M = 1e-6
"""Points nearer to the camera are not seen."""


@compiled
def _point_miss(motion, limits, lens, n, x, y, z, q):
    """The squared miss of a point at x, y, z that should be at q at frame n."""
    away = ((x - q[0]) ** 2 + (y - q[1]) ** 2 + (z - q[2]) ** 2) / limits.metres**2
    if limits.pixels == math.inf:
        return away
    T = motion.Ts_camera_world[n]
    deep = T[2, 0] * q[0] + T[2, 1] * q[1] + T[2, 2] * q[2] + T[2, 3]
    near = T[2, 0] * x + T[2, 1] * y + T[2, 2] * z + T[2, 3]
    if deep <= NEAREST_M:
        return away
    if near <= NEAREST_M:
        return math.inf
    here = near if lens.perspective else lens.distance
    there = deep if lens.perspective else lens.distance
    across = (T[0, 0] * x + T[0, 1] * y + T[0, 2] * z + T[0, 3]) / here
    across -= (T[0, 0] * q[0] + T[0, 1] * q[1] + T[0, 2] * q[2] + T[0, 3]) / there
    down = (T[1, 0] * x + T[1, 1] * y + T[1, 2] * z + T[1, 3]) / here
    down -= (T[1, 0] * q[0] + T[1, 1] * q[1] + T[1, 2] * q[2] + T[1, 3]) / there
    u, v = lens.fx * motion.zoom[n] * across, lens.fy * motion.zoom[n] * down
    return max(away, (u * u + v * v) / limits.pixels**2)


@compiled
def _part_miss(motion, body, limits, lens, n, part, work):
    """The largest squared miss of the points of a part that is placed at frame n."""
    worst, targets = 0.0, motion.points[n]
    R, p = work.HR[part], work.Ho[part]
    for m in range(body.starts[part], body.starts[part + 1]):
        a = body.points[m]
        x = R[0, 0] * a[0] + R[0, 1] * a[1] + R[0, 2] * a[2] + p[0]
        y = R[1, 0] * a[0] + R[1, 1] * a[1] + R[1, 2] * a[2] + p[1]
        z = R[2, 0] * a[0] + R[2, 1] * a[1] + R[2, 2] * a[2] + p[2]
        worst = max(worst, _point_miss(motion, limits, lens, n, x, y, z, targets[m]))
    return worst


@compiled
def _turn(motion, a, b, part, work):
    """work.turns[part] = the rotation vector from frame a to b, in the part's own frame."""
    turned_back(motion.Rs[a, part], motion.Rs[b, part], work.scratch[0])
    logarithm(work.scratch[0], work.turns[part])


@compiled
def _place(motion, body, a, b, n, part, work):
    """work.HR, work.Ho: where a part is at frame n. Its parent is placed, its turn is known."""
    share = (n - a) / (b - a)
    parent, moves = body.parents[part], body.interpolated[part]
    local = motion.Rs[n, part]
    if moves:
        for k in range(3):
            work.vector[k] = share * work.turns[part, k]
        exponential(work.vector, work.scratch[0])
        product(motion.Rs[a, part], work.scratch[0], work.scratch[1])
        local = work.scratch[1]
    if parent < 0:
        put(local, work.HR[part])
        p, q = motion.ps[a], motion.ps[b]
        for k in range(3):
            work.Ho[part, k] = p[k] + share * (q[k] - p[k]) if moves else motion.ps[n, k]
        return
    product(work.HR[parent], local, work.HR[part])
    joint = body.joints[part]
    for k in range(3):
        R = work.HR[parent, k]
        work.Ho[part, k] = work.Ho[parent, k] + R[0] * joint[0] + R[1] * joint[1] + R[2] * joint[2]


@compiled
def _stride(count):
    """A step through `count` places in a ring that meets each once and soon comes near all."""
    step = max(int(0.618 * count), 1)
    while math.gcd(step, count) != 1:
        step += 1
    return step


@compiled
def interval_misses(motion, body, limits, lens, a, b, work, out):
    """out (b − a − 1,) = the squared miss of every frame between a and b, 0 where nothing is known.

    work: arrays to write to. Where its `give_up` is set, the interval is left at the first point
        that is off by more than the limit, and `witness` is set to its frame and part.
    Returns the sum of the misses; infinite where one is above the limit.
    """
    turned, total, count = 0, 0.0, b - a - 1
    step = _stride(count) if count > 0 else 1
    place = count // 2
    for _ in range(count):
        n = a + 1 + place
        place = (place + step) % count
        worst = 0.0
        for part in range(len(body.parents)):
            if not motion.known[n]:
                break
            if part == turned:
                _turn(motion, a, b, part, work)
                turned += 1
            _place(motion, body, a, b, n, part, work)
            worst = max(worst, _part_miss(motion, body, limits, lens, n, part, work))
            if worst > limits.largest and work.give_up[0]:
                work.witness[0], work.witness[1] = n, part
                return math.inf
        out[n - a - 1] = worst
        total += worst if worst <= limits.largest else math.inf
    return total


@compiled
def _is_off(motion, body, limits, lens, a, b, work):
    """Set whether the witness's part is off by more than the limit at the witness's frame.

    Whoever was off between frames near a and b is as a rule off between these: no more than one
    limb has to be placed to leave such an interval.
    """
    n, part = work.witness[0], work.witness[1]
    if not a < n < b:
        return False
    depth, above = 0, part
    while above >= 0:
        work.way[depth] = above
        depth, above = depth + 1, body.parents[above]
    for k in range(depth - 1, -1, -1):
        _turn(motion, a, b, work.way[k], work)
        _place(motion, body, a, b, n, work.way[k], work)
    return _part_miss(motion, body, limits, lens, n, part, work) > limits.largest


@compiled
def reached_from(motion, body, limits, lens, froms, tos, work, out):
    """out[i] = whether interpolation from any of the frames `froms` to tos[i] is within limits."""
    misses = np.empty(len(motion.ps))
    for i in range(len(tos)):
        out[i] = False
        for k in range(len(froms) - 1, -1, -1):
            a, b = froms[k], tos[i]
            if a >= b or _is_off(motion, body, limits, lens, a, b, work):
                continue
            if interval_misses(motion, body, limits, lens, a, b, work, misses) < math.inf:
                out[i] = True
                break


@compiled
def interval_costs(motion, body, limits, lens, froms, tos, work, out):
    """out[i, k] = the sum of squared misses between froms[i] and tos[k]; infinite where one is
    above the limit, or tos[k] is not the later one."""
    misses = np.empty(len(motion.ps))
    for k in range(len(tos)):
        for i in range(len(froms) - 1, -1, -1):
            a, b = froms[i], tos[k]
            out[i, k] = math.inf
            if a < b and not _is_off(motion, body, limits, lens, a, b, work):
                out[i, k] = interval_misses(motion, body, limits, lens, a, b, work, misses)
