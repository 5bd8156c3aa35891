"""How far parts are turned about their own length, whatever way they point: swing and twist.

R = swing · R_rest · twist. R_rest is the least turn of the part's length, its y axis, from the rest
pose to a direction that swings are counted from, the swing the least turn from there. With
M = R_restᵀ R the twist is the turn about y of the quaternion of M (Dobrowolski, "Swing-twist
decomposition in Clifford algebra", 2015). It is not determined where the length points opposite to
that direction.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from keypose.tracker.body.body import Part
from keypose.tracker.geometry.rotations import Array, quaternion_wxyz, transpose

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
        """Of K parts that have a limit of twist."""
        twists = [part.twist for part in parts if part.twist is not None]
        ranges = np.radians([twist.range_deg for twist in twists]).reshape(-1, 2)
        rest = np.array([_least_turn_from_y(np.array(twist.toward)) for twist in twists])
        return cls(ranges[:, 0], ranges[:, 1], rest.reshape(-1, 3, 3))

    def one(self, k: int) -> TwistLimits:
        """That of the part in place k alone."""
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
        """With room for twists that lie outside by so much (..., signed)."""
        low, high = self.low + np.minimum(excess, 0.0), self.high + np.maximum(excess, 0.0)
        return TwistLimits(low, high, self.R_rest)


def _least_turn_from_y(direction: Array) -> Array:
    """(3, 3) the smallest rotation that takes (0, 1, 0) to a direction."""
    x, y, z = direction / np.linalg.norm(direction)
    k = 1.0 / (1.0 + y)
    return np.array([[1 - x * x * k, x, -x * z * k], [-x, y, -z], [-x * z * k, z, 1 - z * z * k]])
