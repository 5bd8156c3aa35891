"""Robust kernels: what residuals cost, and weights with which least squares come to the same.

A kernel is applied to distances in standard deviations. The cost of one is half its `loss`; half
its square, times its `weight`, has the same gradient (iteratively reweighted least squares).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tracker.geometry.rotations import Array


class Kernel(Protocol):
    """How much distances (...) count, each 0 or more."""

    def loss(self, away: Array) -> Array: ...

    def weight(self, away: Array) -> Array: ...


@dataclass(frozen=True)
class Squared:
    """Plain least squares."""

    def loss(self, away: Array) -> Array:
        return np.asarray(away**2)

    def weight(self, away: Array) -> Array:
        return np.ones_like(away)


SQUARED = Squared()


@dataclass(frozen=True)
class Huber:
    """Squared up to a width, linear beyond: what is far pulls no harder than what is there."""

    width: float = 1.345

    def loss(self, away: Array) -> Array:
        return np.where(away > self.width, self.width * (2 * away - self.width), away**2)

    def weight(self, away: Array) -> Array:
        return np.asarray(self.width / np.maximum(away, self.width))


@dataclass(frozen=True)
class Cauchy:
    """Far residuals pull less and less: for what may be plainly wrong."""

    width: float = 2.385

    def loss(self, away: Array) -> Array:
        return np.asarray(self.width**2 * np.log1p((away / self.width) ** 2))

    def weight(self, away: Array) -> Array:
        return np.asarray(1 / (1 + (away / self.width) ** 2))
