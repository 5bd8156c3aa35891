"""Joint limits: ranges of a part's Euler angles (R = Qz·Qy·Qx), as boxes (3, 2) in radians, and of
its twist about its own length.

Two triples of angles give the same rotation, and a turn of any angle may be added: a rotation is
allowed when one of its triples lies in the box, and its twist in its range.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Part
from keypose.tracker.body.joint_limits import TwistLimits
from keypose.tracker.geometry.rotations import (
    Array,
    euler_from_rotation,
    exp_rotation,
    frozen,
    log_rotation,
)

TURN = 2.0 * math.pi
SLACK = 1e-7
"""Radians by which an angle may lie outside without being called so."""

FREE = frozen(np.tile([-math.inf, math.inf], (3, 1)))
"""A box without limits."""

_SWEEPS = 12
"""Sweeps over the three angles at most; most descents end sooner."""
_ROUNDS = 20
"""Times at most that angles and twist are corrected in turn."""
_HALVINGS = 20
"""Halvings of the way to the middle of the range."""
_STEP = math.radians(2.0)
"""So finely a turn is looked at for where it meets a limit."""
_REFINEMENTS = 3
"""Times that the step in which it meets one is looked at more finely."""
_FINER = 16
"""By how much more finely each time."""


@dataclass(frozen=True, eq=False)
class JointRange:
    """The rotations that a joint allows: a box (3, 2) of angles, and limits of twist if any."""

    box: Array
    twist: TwistLimits | None = None

    def beyond(self, rotations: Array) -> Array:
        """(...) how far rotations (..., 3, 3) lie outside, radians; 0 inside."""
        out = _beyond_either(rotations, self.box)
        if self.twist is not None:
            out = np.maximum(out, np.abs(self.twist.excess(rotations)))
        return out

    def widened(self, rotation: Array) -> JointRange:
        """Widen for a rotation: a pose that is beyond a limit may stay where it is."""
        angles = fitting(rotation, self.box)
        low, high = np.minimum(self.box[:, 0], angles), np.maximum(self.box[:, 1], angles)
        twist = self.twist
        if twist is not None:
            twist = twist.widened(twist.excess(rotation))
        return JointRange(np.stack([low, high], axis=1), twist)


def box_of(part: Part) -> Array | None:
    """The ranges of x, y, z (3, 2) in radians, infinite where free; None without any."""
    if not part.limits_deg:
        return None
    free = (-math.inf, math.inf)
    return np.radians([part.limits_deg.get(axis, free) for axis in ("x", "y", "z")])


def twist_of(part: Part) -> TwistLimits | None:
    """The limits of a part's twist."""
    return None if part.twist is None else TwistLimits.of([part]).one(0)


def is_twisted(part: Part, rotations: Array) -> NDArray[np.bool_]:
    """(...) Whether rotations (..., 3, 3) turn a part about its own length farther than it may."""
    limits = twist_of(part)
    if limits is None:
        return np.zeros(rotations.shape[:-2], dtype=np.bool_)
    return np.asarray(np.abs(limits.excess(rotations)) > SLACK)


def range_of(part: Part) -> JointRange | None:
    """All that limits a part's rotation; None without any."""
    box, twist = box_of(part), twist_of(part)
    if twist is None:
        return None if box is None else JointRange(box)
    return JointRange(FREE if box is None else box, twist)


def triples(rotations: Array, box: Array | None = None) -> Array:
    """Both Euler triples [x, y, z] (..., 2, 3) of rotations, each angle as near the box's middle
    as full turns allow; without a box within ±pi, the triple with y in ±pi/2 first."""
    z, y, x = np.moveaxis(euler_from_rotation(rotations), -1, 0)
    first_triple = np.stack([x, y, z], axis=-1)
    second_triple = np.stack([x + math.pi, math.pi - y, z + math.pi], axis=-1)
    both = np.stack([first_triple, second_triple], axis=-2)
    middle = np.zeros(3) if box is None else _middle(box)
    return np.asarray(both - TURN * np.round((both - middle) / TURN))


def beyond(angles: Array, box: Array) -> Array:
    """How far the worst of the angles (..., 3) lies outside the box, radians; 0 inside."""
    out = np.maximum(box[:, 0] - angles, angles - box[:, 1])
    return np.asarray(np.maximum(out, 0.0).max(axis=-1))


def fitting(rotations: Array, box: Array | None) -> Array:
    """The triple of angles [x, y, z] (..., 3) of each rotation (..., 3, 3) that lies deepest in
    the box; of two as deep the first of `triples`."""
    both = triples(rotations, box)
    if box is None:
        return np.asarray(both[..., 0, :])
    out = beyond(both, box)
    second = out[..., 1] < out[..., 0] - SLACK
    return np.where(second[..., None], both[..., 1, :], both[..., 0, :])


def is_within(rotation: Array, allowed: JointRange | None) -> bool:
    """Whether the rotation is allowed."""
    return allowed is None or bool(allowed.beyond(rotation) <= SLACK)


def nearest_within(rotation: Array, allowed: JointRange | None) -> Array:
    """The allowed rotation that is the least turn away; the rotation itself if it is allowed.

    What is twisted too far is turned back about its own length, so that it points where it did.
    """
    if allowed is None or is_within(rotation, allowed):
        return rotation
    nearest = _nearest_in_box(rotation, allowed.box)
    for _ in range(_ROUNDS):
        if is_within(nearest, allowed):
            return nearest
        nearest = _nearest_in_box(_untwisted(nearest, allowed.twist), allowed.box)
    return _toward_middle(nearest, allowed)


def furthest_share(path: Callable[[Array], Array], angle: float, allowed: JointRange) -> float:
    """The share of a turn at which it first meets a limit, so that it cannot come out on the other
    side; 1 where it meets none.

    path: rotations (N, 3, 3) of shares (N,).  angle: radians of the whole turn.
    """
    low, high = 0.0, 1.0
    count = max(3, math.ceil(abs(angle) / _STEP) + 1)
    for _ in range(1 + _REFINEMENTS):
        shares = np.linspace(low, high, count)
        outside = allowed.beyond(path(shares)) > SLACK
        if not outside.any():
            return high
        first = int(np.argmax(outside))
        if first == 0:
            return low
        low, high = float(shares[first - 1]), float(shares[first])
        count = 1 + _FINER
    return low


def _untwisted(rotation: Array, twist: TwistLimits | None) -> Array:
    """Turned back about its own length to its limit of twist."""
    if twist is None:
        return rotation
    back = np.array([0.0, -float(twist.excess(rotation)), 0.0])
    return np.asarray(rotation @ exp_rotation(back))


def _toward_middle(rotation: Array, allowed: JointRange) -> Array:
    """Where angles and twist do not agree soon: on the way to the middle of the box."""
    middle = of_angles(_middle(allowed.box))
    turn_to_middle = log_rotation(rotation.T @ middle)
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        share = (low + high) / 2
        inside = is_within(rotation @ exp_rotation(share * turn_to_middle), allowed)
        low, high = (low, share) if inside else (share, high)
    return np.asarray(rotation @ exp_rotation(high * turn_to_middle))


def _nearest_in_box(rotation: Array, box: Array) -> Array:
    """The rotation with angles in the box that is the least turn away."""
    if _beyond_either(rotation, box) <= SLACK:
        return rotation
    starts = np.clip(triples(rotation, box), box[:, 0], box[:, 1])
    candidates = [_descended(rotation, start.tolist(), box) for start in starts]
    return max(candidates, key=lambda R: float((R * rotation).sum()))


def _beyond_either(rotations: Array, box: Array) -> Array:
    """How far the better of both triples lies outside."""
    return np.asarray(beyond(triples(rotations, box), box).min(axis=-1))


def _descended(wanted: Array, angles: list[float], box: Array) -> Array:
    """Descend from angles inside the box to the best ones near them, one angle at a time.

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


def resting_rotation(part: Part) -> Array:
    """(3, 3) the middle of a joint's range; at rest where there are no limits."""
    box = box_of(part)
    return np.eye(3) if box is None else of_angles(_middle(box))


def _middle(box: Array) -> Array:
    """(3,) the middle of each range, 0 where it is free."""
    bounded = np.isfinite(box).all(axis=1, keepdims=True)
    return np.asarray(np.where(bounded, box, 0.0).mean(axis=1))


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
    """The rotation (3, 3) about x, y or z (0, 1, 2) by radians."""
    c, s = math.cos(angle), math.sin(angle)
    if axis == 0:
        return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    if axis == 1:
        return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
