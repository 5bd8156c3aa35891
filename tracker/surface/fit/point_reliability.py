"""Which points of the body's surface the steps confirm; others count less from then on.

The surface that moves with the body is that of one step. What of it was not the body's, such as
volume that no camera could see past, has no counterpart at other steps, and draws ever new places.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.tracker.geometry.rotations import Array, frozen
from keypose.tracker.surface.fit.measuring import point_weights
from keypose.tracker.surface.fit.model import SurfaceModel
from keypose.tracker.surface.fit.solving import Fit

OFF_SHARE = 0.0025
"""Of the surface's size: a point that is off by as much, on the average, counts half."""
OFF_MOST_SHARE = 0.015
"""Of the surface's size: farther off than that no point is taken to be; the pose may be wrong."""
FORETRUST = 3.0
"""Prior: so many steps at which every point lay on the surface."""


@dataclass(frozen=True, eq=False)
class PointReliability:
    """What the steps so far showed of V points; read-only.

    off:   (V,) how far each was from the observed surface, metres, summed over the steps.
    steps: (V,) at how many it counted.
    """

    off: Array
    steps: Array

    @classmethod
    def of(cls, model: SurfaceModel) -> PointReliability:
        """Before the first step."""
        nothing = frozen(np.zeros(len(model.own)))
        return cls(nothing, nothing)

    def after(self, model: SurfaceModel, fit: Fit) -> PointReliability:
        """With one more step, fitted with that model."""
        pairs = fit.pairs
        there = slice(pairs.forward)
        gap = pairs.target[there] - fit.posed.p
        off = np.abs(np.einsum("vi,vi->v", gap, pairs.normals[there]))
        counted = point_weights(model, pairs)
        capped = np.minimum(off, OFF_MOST_SHARE * model.size_m)
        return PointReliability(frozen(self.off + counted * capped), frozen(self.steps + counted))

    def apply_to(self, model: SurfaceModel) -> SurfaceModel:
        """The model with its points weighted by how far off they were."""
        mean = self.off / (self.steps + FORETRUST)
        return model.with_trust(1.0 / (1.0 + (mean / (OFF_SHARE * model.size_m)) ** 2))
