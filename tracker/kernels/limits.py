"""What joint limits cost, and their normal equations: see `keypose.tracker.body.joint_limits`."""

from __future__ import annotations

import math

import numpy as np

from keypose.tracker.kernels import compiled
from keypose.tracker.kernels.rigid import put_place, turned_back


@compiled
def beyond(value, low, high):
    """By how much a value lies outside a range, signed."""
    return max(value - high, 0.0) + min(value - low, 0.0)


@compiled
def near_middle(value, low, high):
    """The angle that differs by full turns and lies nearest to the middle of a range, or to 0 where
    it has an open end."""
    middle = 0.5 * (low + high) if np.isfinite(low) and np.isfinite(high) else 0.0
    return value - 2 * math.pi * math.floor((value - middle) / (2 * math.pi) + 0.5)


@compiled
def put_triple(ranges, i, x, y, z, angles):
    """angles (3,) ← a triple, as near the middle of part i's ranges as full turns allow.

    By how much it lies outside comes back.
    """
    angles[0] = near_middle(x, ranges.low[i, 0], ranges.high[i, 0])
    angles[1] = near_middle(y, ranges.low[i, 1], ranges.high[i, 1])
    angles[2] = near_middle(z, ranges.low[i, 2], ranges.high[i, 2])
    outside = 0.0
    for a in range(3):
        outside += abs(beyond(angles[a], ranges.low[i, a], ranges.high[i, a]))
    return outside


@compiled
def put_angles(ranges, i, R, angles):
    """angles (3,) ← x, y, z of part i's rotation: of both triples the one less far outside."""
    flat = math.hypot(R[0, 0], R[1, 0])
    y = math.atan2(-R[2, 0], flat)
    if flat < 1e-9:
        z, x = math.atan2(-R[0, 1], R[1, 1]), 0.0
    else:
        z, x = math.atan2(R[1, 0], R[0, 0]), math.atan2(R[2, 1], R[2, 2])
    outside = put_triple(ranges, i, x, y, z, angles)
    if outside == 0.0:
        return
    other = np.empty(3)
    if put_triple(ranges, i, x + math.pi, math.pi - y, z + math.pi, other) < outside - 1e-9:
        put_place(other, angles)


@compiled
def lagging(outside, allowed, onset):
    """What counts of an angle that lies outside, signed, and by which share its slope counts.

    allowed: signed, what does not count.  onset: within so much the slope grows from 0 to 1.
    """
    low, high = min(allowed, 0.0), max(allowed, 0.0)
    outside -= min(max(outside, low), high)
    if onset == 0.0 or outside == 0.0:
        return outside, 1.0
    share = min(abs(outside) / onset, 1.0)
    return math.copysign(abs(outside) - onset * (share - share * share / 2), outside), share


@compiled
def slope_of(ranges, angle, angles, row):
    """row (3,) ← the change of x, y or z with a small turn about each of the part's own axes."""
    cos_y = math.cos(angles[1])
    if abs(cos_y) < ranges.least_cos:
        cos_y = math.copysign(ranges.least_cos, cos_y)
    sin_x, cos_x = math.sin(angles[0]), math.cos(angles[0])
    if angle == 1:
        row[0], row[1], row[2] = 0.0, cos_x, -sin_x
        return
    row[0], row[1], row[2] = 0.0, sin_x / cos_y, cos_x / cos_y
    if angle == 0:
        sin_y = math.sin(angles[1])
        row[0], row[1], row[2] = 1.0, row[1] * sin_y, row[2] * sin_y


@compiled
def twist_slope(ranges, M, row):
    """row (3,) ← the same of a twist, M (3, 3) being the rotation from where swings are counted."""
    along = max(M[1, 1] + 1, ranges.least_determined)
    row[0], row[1], row[2] = M[1, 0] / along, (M[1, 1] + 1) / along, M[1, 2] / along


@compiled
def excess_of(ranges, i, R, angles, M, outside, share):
    """outside, share (4,) ← what counts of x, y, z and twist of part i, and of their slopes."""
    outside[:] = 0.0
    if ranges.bounded[i]:
        put_angles(ranges, i, R, angles)
        for a in range(3):
            over = beyond(angles[a], ranges.low[i, a], ranges.high[i, a])
            outside[a], share[a] = lagging(over, ranges.allowed[i, a], ranges.onset)
    k = ranges.twist[i]
    if k >= 0:
        turned_back(ranges.R_rest[k], R, M)
        low, high = ranges.twist_low[k], ranges.twist_high[k]
        twist = near_middle(math.atan2(M[0, 2] - M[2, 0], M[0, 0] + M[2, 2]), low, high)
        over = beyond(twist, low, high)
        outside[3], share[3] = lagging(over, ranges.allowed[i, 3], ranges.onset)


@compiled
def limit_cost(ranges, R):
    """The cost of all joints of poses R (N, P, 3, 3)."""
    angles, M, outside, share = np.empty(3), np.empty((3, 3)), np.zeros(4), np.ones(4)
    total = 0.0
    for n in range(R.shape[0]):
        for i in range(R.shape[1]):
            excess_of(ranges, i, R[n, i], angles, M, outside, share)
            for a in range(4):
                total += outside[a] * outside[a]
    return 0.5 * total / (ranges.sigma * ranges.sigma)


@compiled
def add_limits(chain, ranges, R, A, b):
    """The same, and A (N, D, D), b (N, D) += the normal equations of every pose."""
    angles, M, outside, share = np.empty(3), np.empty((3, 3)), np.zeros(4), np.ones(4)
    row, total, precision = np.empty(3), 0.0, 1 / (ranges.sigma * ranges.sigma)
    for n in range(R.shape[0]):
        for i in range(R.shape[1]):
            excess_of(ranges, i, R[n, i], angles, M, outside, share)
            for a in range(4):
                if outside[a] == 0:
                    continue
                total += outside[a] * outside[a]
                if a == 3:
                    twist_slope(ranges, M, row)
                else:
                    slope_of(ranges, a, angles, row)
                for d in range(ranges.dof_starts[i], ranges.dof_starts[i + 1]):
                    if chain.dof_turns[d] == 0:
                        continue
                    g = precision * share[a] * row[chain.dof_axis[d]]
                    b[n, d] += g * outside[a]
                    for e in range(ranges.dof_starts[i], ranges.dof_starts[i + 1]):
                        if chain.dof_turns[e] == 1:
                            A[n, d, e] += g * share[a] * row[chain.dof_axis[e]]
    return 0.5 * total * precision
