"""Joint limits: ranges of a part's Euler angles (R = Qz·Qy·Qx), as boxes (3, 2) in radians.

Two triples of angles give the same rotation, and a turn of any angle may be added: a rotation is
allowed when one of its triples lies in the box.
"""

from __future__ import annotations

import math

import numpy as np

from keypose.tracker.body.body import Part
from keypose.tracker.geometry.rotations import Array, euler_from_rotation

TURN = 2.0 * math.pi
SLACK = 1e-7
"""Radians by which an angle may lie outside without being called so."""

_SWEEPS = 12


def box_of(part: Part) -> Array | None:
    """The ranges of x, y, z (3, 2) in radians, infinite where free; None without any."""
    if not part.limits_deg:
        return None
    free = (-math.inf, math.inf)
    return np.radians([part.limits_deg.get(axis, free) for axis in ("x", "y", "z")])


def triples(rotations: Array, box: Array | None = None) -> Array:
    """Both Euler triples [x, y, z] (..., 2, 3) of rotations, each angle as near the box's middle
    as full turns allow; without a box within ±pi, the triple with y in ±pi/2 first."""
    z, y, x = np.moveaxis(euler_from_rotation(rotations), -1, 0)
    one = np.stack([x, y, z], axis=-1)
    other = np.stack([x + math.pi, math.pi - y, z + math.pi], axis=-1)
    both = np.stack([one, other], axis=-2)
    middle = np.zeros(3) if box is None else np.where(np.isfinite(box).all(1), box.mean(1), 0.0)
    return np.asarray(both - TURN * np.round((both - middle) / TURN))


def beyond(angles: Array, box: Array) -> Array:
    """How far the worst of the angles (..., 3) lies outside the box, radians; 0 inside."""
    out = np.maximum(box[:, 0] - angles, angles - box[:, 1])
    return np.asarray(np.maximum(out, 0.0).max(axis=-1))


def fitting(rotation: Array, box: Array | None) -> Array:
    """The triple [x, y, z] (3,) of a rotation that lies deepest in the box, the plain one first."""
    both = triples(rotation, box)
    if box is None:
        return np.asarray(both[0])
    out = beyond(both, box)
    return np.asarray(both[1] if out[1] < out[0] - SLACK else both[0])


def widened(box: Array | None, rotation: Array) -> Array | None:
    """The box with room for a rotation: a pose that is beyond a limit may stay where it is."""
    if box is None:
        return None
    angles = fitting(rotation, box)
    return np.stack([np.minimum(box[:, 0], angles), np.maximum(box[:, 1], angles)], axis=1)


def is_within(rotation: Array, box: Array | None) -> bool:
    """Whether the rotation is allowed."""
    return box is None or bool(_beyond_either(rotation, box) <= SLACK)


def nearest_within(rotation: Array, box: Array | None) -> Array:
    """The allowed rotation that is the least turn away; the rotation itself if it is allowed."""
    if box is None or is_within(rotation, box):
        return rotation
    starts = np.clip(triples(rotation, box), box[:, 0], box[:, 1])
    found = [_descended(rotation, start.tolist(), box) for start in starts]
    return max(found, key=lambda R: float((R * rotation).sum()))


def _beyond_either(rotations: Array, box: Array) -> Array:
    """How far the better of both triples lies outside."""
    return np.asarray(beyond(triples(rotations, box), box).min(axis=-1))


def _descended(wanted: Array, angles: list[float], box: Array) -> Array:
    """From angles inside the box to the best ones near them, one angle at a time.

    tr(wantedᵀ R) is a sine of each single angle, so that each has its best value in closed form.
    """
    ranges = box.tolist()
    Q = [_about(axis, angle) for axis, angle in enumerate(angles)]
    for _ in range(_SWEEPS):
        moved = 0.0
        for axis in (0, 1, 2):
            # tr(wantedᵀ Qz Qy Qx) with the turn in question moved to the end
            outer = Q[2] @ Q[1] if axis == 0 else Q[2] if axis == 1 else np.eye(3)
            inner = np.eye(3) if axis == 0 else Q[0] if axis == 1 else Q[1] @ Q[0]
            A = (inner @ wanted.T @ outer).tolist()
            i, k = ((1, 2), (2, 0), (0, 1))[axis]
            best = math.atan2(A[i][k] - A[k][i], A[i][i] + A[k][k])
            angle = _clamped(best, *ranges[axis])
            moved = max(moved, abs(angle - angles[axis]))
            angles[axis] = angle
            Q[axis] = _about(axis, angle)
        if moved < 1e-9:
            break
    return np.asarray(Q[2] @ Q[1] @ Q[0])


def of_angles(angles: Array) -> Array:
    """Qz·Qy·Qx (3, 3) of [x, y, z] in radians."""
    x, y, z = angles.tolist()
    return np.asarray(_about(2, z) @ _about(1, y) @ _about(0, x))


def _clamped(angle: float, low: float, high: float) -> float:
    """The angle of the range that is nearest on the circle."""
    if math.isinf(low) or math.isinf(high):
        return min(max(angle, low), high)
    middle, half = (low + high) / 2, (high - low) / 2
    away = math.remainder(angle - middle, TURN)
    return middle + min(max(away, -half), half)


def _about(axis: int, angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    if axis == 0:
        return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    if axis == 1:
        return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
