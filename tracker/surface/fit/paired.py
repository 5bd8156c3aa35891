"""How far paired points of two surfaces lie apart, as a term.  SURFACE (4)"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.kernels.surface import pull
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.terms import Equations
from keypose.tracker.surface.fit.model import PosedSurface, SurfaceModel
from keypose.tracker.surface.fit.normal_offset import OFFSET_TERMS, normal_equations
from keypose.tracker.surface.fit.pairing import Pairs


@dataclass(frozen=True, eq=False)
class PairDistances:
    """Points of a model's surface on the points that they were paired with, metres.

    paired_at, surface: the pose at which they were paired, and the model's surface there; along its
        normals the surface may stand out.
    plane: 1 along the observed normals, 0 in all directions.  offset: whether it may stand out.
    """

    model: SurfaceModel
    pairs: Pairs
    paired_at: Posed
    surface: PosedSurface
    plane: float
    offset: bool

    def cost(self, posed: Posed) -> float:
        """Half of the energy, at the best offset."""
        return self.equations(posed).cost

    def equations(self, posed: Posed) -> Equations:
        """With the offset marginalised."""
        model, pairs, size = self.model, self.pairs, OFFSET_TERMS + 12
        A, b = np.empty((len(model.pairs), size, size)), np.empty((len(model.pairs), size))
        at = self.surface if posed is self.paired_at else model.posed(posed.Ts_camera_part)
        energy = pull(
            at.p_each, model.shares, model.groups, pairs.model, pairs.target, pairs.normals,
            pairs.weights, self.surface.normals, self.plane, A, b,
        )  # fmt: skip
        found = normal_equations(A, b, self._twists(posed), energy, self.offset)
        return Equations(found.information, found.slope, 0.5 * found.energy)

    def _twists(self, posed: Posed) -> Array:
        """(G, 12, D): those of both parts of every group, for a change of each dof."""
        skeleton, groups = posed.skeleton, self.model.pairs
        carried = skeleton.below[groups][:, :, skeleton.dof_part]  # (G, 2, D)
        of_parts = carried[:, :, None, :] * posed.twists.T[None, None]
        return np.asarray(of_parts.reshape(len(groups), 12, skeleton.dof_count))
