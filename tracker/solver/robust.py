"""Robust kernels: the cost of residuals, and the weights that give least squares the same gradient.

A kernel is applied to distances in standard deviations. The cost of one is half its `loss`; half
its square, times its `weight`, has the same gradient (iteratively reweighted least squares). With
the widths that are named here, estimates from normal residuals are 95 % as efficient as least
squares (P. W. Holland, R. E. Welsch, *Robust Regression Using Iteratively Reweighted
Least-Squares*, 1977).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from keypose.tracker.geometry.rotations import Array


class Kernel(Protocol):
    """How much distances (...) count, each 0 or more. width: beyond which they count less."""

    @property
    def width(self) -> float: ...

    def loss(self, away: Array) -> Array: ...

    def weight(self, away: Array) -> Array: ...


@dataclass(frozen=True)
class Squared:
    """Plain least squares."""

    width: float = np.inf

    def loss(self, away: Array) -> Array:
        return np.asarray(away**2)

    def weight(self, away: Array) -> Array:
        return np.ones_like(away)


SQUARED = Squared()


@dataclass(frozen=True)
class Huber:
    """Squared up to a width, linear beyond: far residuals pull no harder than near ones."""

    width: float = 1.345

    def loss(self, away: Array) -> Array:
        return np.where(away > self.width, self.width * (2 * away - self.width), away**2)

    def weight(self, away: Array) -> Array:
        return np.asarray(self.width / np.maximum(away, self.width))


@dataclass(frozen=True)
class Cauchy:
    """Far residuals pull less and less: for measurements that may be wrong."""

    width: float = 2.385

    def loss(self, away: Array) -> Array:
        return np.asarray(self.width**2 * np.log1p((away / self.width) ** 2))

    def weight(self, away: Array) -> Array:
        return np.asarray(1 / (1 + (away / self.width) ** 2))


@dataclass(frozen=True)
class GemanMcClure:
    """Far residuals end without weight: for a minority that is wrong altogether. The narrower it
    becomes from step to step, the fewer residuals count (graduated non-convexity)."""

    width: float

    def loss(self, away: Array) -> Array:
        return np.asarray(away**2 / (1 + (away / self.width) ** 2))

    def weight(self, away: Array) -> Array:
        return np.asarray(1 / (1 + (away / self.width) ** 2) ** 2)


@dataclass(frozen=True)
class Tukey:
    """Residuals beyond a width do not count: for a state that is nearly right."""

    width: float = 4.685

    def loss(self, away: Array) -> Array:
        inside = np.maximum(1 - (away / self.width) ** 2, 0.0)
        return np.asarray(self.width**2 / 3 * (1 - inside**3))

    def weight(self, away: Array) -> Array:
        return np.asarray(np.maximum(1 - (away / self.width) ** 2, 0.0) ** 2)
