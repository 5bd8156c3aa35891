"""Measure twist (swing and twist) and joint angles beyond their limits, with derivatives.

R = swing · R_rest · twist. R_rest is the least turn of the part's length, its y axis, from the rest
pose to a direction that swings are counted from, the swing the least turn from there. With
M = R_restᵀ R the twist is the turn about y of the quaternion of M (Dobrowolski, "Swing-twist
decomposition in Clifford algebra", 2015). It is not determined where the length points opposite to
that direction.

Limits are ranges of the Euler angles x, y, z of R = Qz·Qy·Qx. Each rotation has two such triples;
the one less far outside counts. Where a box as wide as a shoulder's has both, and so an arm turned
by half a circle about its own length, twist has a range of its own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body, Part
from keypose.tracker.geometry.rotations import (
    Array,
    euler_from_rotation,
    quaternion_wxyz,
    transpose,
)

LEAST_DETERMINED = 0.1
"""Of 1 + cos of the angle between a length and where swings are counted from: nearer to opposite,
twist changes no faster than there."""


@dataclass(frozen=True, eq=False)
class TwistLimits:
    """Lowest and highest twist of parts (...), radians, and R_rest (..., 3, 3) of each.

    Rotations have these axes last before their own: (..., 3, 3) for one part, (..., K, 3, 3) for K.
    """

    low: Array
    high: Array
    R_rest: Array

    @classmethod
    def of(cls, parts: Sequence[Part]) -> Self:
        """Collect the limits of twist of K parts that have one."""
        twists = [part.twist for part in parts if part.twist is not None]
        ranges = np.radians([twist.range_deg for twist in twists]).reshape(-1, 2)
        rest = np.array([_least_turn_from_y(np.array(twist.toward)) for twist in twists])
        return cls(ranges[:, 0], ranges[:, 1], rest.reshape(-1, 3, 3))

    def one(self, k: int) -> TwistLimits:
        """The limit of the part in place k alone."""
        return TwistLimits(self.low[k], self.high[k], self.R_rest[k])

    def twist(self, Rs_parent_part: Array) -> Array:
        """(...) radians, as near the range's middle as full turns allow."""
        M = transpose(self.R_rest) @ Rs_parent_part
        sine, cosine = M[..., 0, 2] - M[..., 2, 0], M[..., 0, 0] + M[..., 2, 2]
        middle = (self.low + self.high) / 2
        away = np.arctan2(sine, cosine) - middle
        return np.asarray(middle + away - 2 * np.pi * np.round(away / (2 * np.pi)))

    def excess(self, Rs_parent_part: Array) -> Array:
        """(...) radians beyond the range, signed."""
        twist = self.twist(Rs_parent_part)
        return np.asarray(np.maximum(twist - self.high, 0.0) + np.minimum(twist - self.low, 0.0))

    def slopes(self, Rs_parent_part: Array) -> Array:
        """(..., 3) change of the twist with a small turn about each of the part's own axes.

        Of M · exp(w) it is w · (y + Mᵀy) / (1 + y · My): with the swing shared evenly, the length
        and where it came from carry the turn alike.
        """
        M = transpose(self.R_rest) @ Rs_parent_part
        along = M[..., 1, :] + np.array([0.0, 1.0, 0.0])
        return np.asarray(along / np.maximum(along[..., 1:2], LEAST_DETERMINED))

    def turn_to(self, R_parent_part: Array, axis: Array, twist: float) -> float:
        """Radians, within ±pi, by which one part's rotation (3, 3) is to be turned about a unit
        axis (3,) of its parent's frame for its twist to be this one.

        There is one such turn: turned by a, the quaternion of M is cos(a/2) p + sin(a/2) q, so that
        over a whole turn the twist goes round once, one way. 0 where the turn does not change it.
        """
        w, x, y, z = quaternion_wxyz(self.R_rest.T @ R_parent_part).tolist()
        ax, ay, az = (axis @ self.R_rest).tolist()
        q_w, q_y = -(ax * x + ay * y + az * z), ay * w + az * x - ax * z
        c, s = math.cos(twist / 2), math.sin(twist / 2)
        p_off, q_off = y * c - w * s, q_y * c - q_w * s
        return math.remainder(2 * math.atan2(-p_off, q_off), math.tau)

    def widened(self, excess: Array) -> TwistLimits:
        """Limits with room for twists that lie outside by so much (..., signed)."""
        low, high = self.low + np.minimum(excess, 0.0), self.high + np.maximum(excess, 0.0)
        return TwistLimits(low, high, self.R_rest)


def _least_turn_from_y(direction: Array) -> Array:
    """(3, 3) the smallest rotation that takes (0, 1, 0) to a direction."""
    x, y, z = direction / np.linalg.norm(direction)
    k = 1.0 / (1.0 + y)
    return np.array([[1 - x * x * k, x, -x * z * k], [-x, y, -z], [-x * z * k, z, 1 - z * z * k]])


LEAST_COS = 0.1
"""Near a right angle of y, where x and z turn about one axis, angles change no faster than this."""


@dataclass(frozen=True, eq=False)
class Limits:
    """The limits of a body: lowest and highest angles (P, 3) in radians, infinite where free.

    twisted: (K,) the parts whose twist has limits.  twists: those; None where there are none.
    """

    low: Array
    high: Array
    twisted: NDArray[np.intp] = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    twists: TwistLimits | None = None

    @classmethod
    def of(cls, body: Body) -> Limits:
        """The limits of a body's parts."""
        free = (-np.inf, np.inf)
        boxes = [
            [part.limits_deg.get(axis, free) for axis in ("x", "y", "z")] for part in body.parts
        ]
        box = np.radians(np.array(boxes, dtype=np.float64))
        twisted = [i for i, part in enumerate(body.parts) if part.twist is not None]
        twists = TwistLimits.of(body.parts) if twisted else None
        return cls(box[..., 0], box[..., 1], np.array(twisted, dtype=np.intp), twists)

    def excess(self, Rs_parent_part: Array) -> tuple[Array, Array]:
        """Radians (..., P, 4) by which x, y, z and twist lie outside, signed, and slopes
        (..., P, 4, 3).

        A slope is the change of an angle with a small turn about each of the part's own axes.
        """
        angles = self._least_excess(Rs_parent_part)
        outside, slopes = np.zeros((*angles.shape[:-1], 4)), np.zeros((*angles.shape[:-1], 4, 3))
        outside[..., :3] = np.maximum(angles - self.high, 0.0) + np.minimum(angles - self.low, 0.0)
        slopes[..., :3, :] = _slopes(angles)
        if self.twists is not None:
            Rs = Rs_parent_part[..., self.twisted, :, :]
            outside[..., self.twisted, 3] = self.twists.excess(Rs)
            slopes[..., self.twisted, 3, :] = self.twists.slopes(Rs)
        return outside, slopes

    def widened(self, posed: Sequence[Array]) -> Limits:
        """Widened to contain rotations (P, 3, 3) that a person posed."""
        outside = np.stack([self.excess(Rs)[0] for Rs in posed])
        least, most = np.minimum(outside, 0.0).min(0), np.maximum(outside, 0.0).max(0)
        twists = self.twists
        if twists is not None:
            twists = twists.widened(least[self.twisted, 3]).widened(most[self.twisted, 3])
        return Limits(self.low + least[:, :3], self.high + most[:, :3], self.twisted, twists)

    def _least_excess(self, Rs: Array) -> Array:
        """(..., P, 3) the triple [x, y, z] that lies less far outside."""
        first = euler_from_rotation(Rs)[..., ::-1]
        second = first + np.pi
        second[..., 1] = np.pi - first[..., 1]
        both = np.stack([first, second])
        bounded = np.isfinite(self.low) & np.isfinite(self.high)
        middle = np.where(bounded, (np.nan_to_num(self.low) + np.nan_to_num(self.high)) / 2, 0.0)
        both -= 2 * np.pi * np.round((both - middle) / (2 * np.pi))
        out = np.maximum(np.maximum(both - self.high, self.low - both), 0.0).sum(axis=-1)
        return np.asarray(np.where((out[1] < out[0] - 1e-9)[..., None], both[1], both[0]))


@dataclass(frozen=True, eq=False)
class SoftLimits:
    """Limits that a pose may exceed, at a cost.

    sigma_rad: standard deviation of what lies beyond.  allowed (P, 4): radians, signed, by which a
    joint may lie outside, as in a posed keyframe.  onset_rad: so far beyond a limit its slope grows
    from 0 to 1, and the residual lags behind by half of it.
    """

    limits: Limits
    sigma_rad: float
    allowed: Array | None = None
    onset_rad: float = 0.0

    def excess(self, Rs_parent_part: Array) -> tuple[Array, Array]:
        """Radians (..., P, 4) that count, and their slopes (..., P, 4, 3), as `Limits.excess`; no
        slope where nothing counts."""
        outside, slopes = self.limits.excess(Rs_parent_part)
        if self.allowed is not None:
            low, high = np.minimum(self.allowed, 0.0), np.maximum(self.allowed, 0.0)
            outside = outside - np.clip(outside, low, high)
        slopes = slopes * (outside != 0)[..., None]
        if self.onset_rad == 0.0:
            return outside, slopes
        share = np.minimum(np.abs(outside) / self.onset_rad, 1.0)
        lag = self.onset_rad * (share - share**2 / 2)
        return np.copysign(np.abs(outside) - lag, outside), slopes * share[..., None]


def _slopes(angles: Array) -> Array:
    """∂(x, y, z)/∂w for R · exp(w): the inverse of how Euler rates make an angular velocity."""
    x, y = angles[..., 0], angles[..., 1]
    cos_y = np.cos(y)
    cos_y = np.where(np.abs(cos_y) < LEAST_COS, np.copysign(LEAST_COS, cos_y), cos_y)
    slopes = np.zeros((*angles.shape, 3))
    slopes[..., 2, 1], slopes[..., 2, 2] = np.sin(x) / cos_y, np.cos(x) / cos_y
    slopes[..., 1, 1], slopes[..., 1, 2] = np.cos(x), -np.sin(x)
    slopes[..., 0, :] = slopes[..., 2, :] * np.sin(y)[..., None]
    slopes[..., 0, 0] = 1.0
    return slopes
