"""How far the parts of a pose turn beyond their joint limits, and how that changes as they turn.

Limits are ranges of the Euler angles x, y, z of R = Qz·Qy·Qx. Each rotation has two such triples;
the one less far outside counts. Where a box as wide as a shoulder's has both, and so an arm turned
by half a circle about its own length, twist has a range of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.body.twist import TwistLimits
from keypose.tracker.geometry.rotations import Array, euler_from_rotation

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
        one = euler_from_rotation(Rs)[..., ::-1]
        other = one + np.pi
        other[..., 1] = np.pi - one[..., 1]
        both = np.stack([one, other])
        bounded = np.isfinite(self.low) & np.isfinite(self.high)
        middle = np.where(bounded, (np.nan_to_num(self.low) + np.nan_to_num(self.high)) / 2, 0.0)
        both -= 2 * np.pi * np.round((both - middle) / (2 * np.pi))
        out = np.maximum(np.maximum(both - self.high, self.low - both), 0.0).sum(axis=-1)
        return np.asarray(np.where((out[1] < out[0] - 1e-9)[..., None], both[1], both[0]))


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
