"""Which turns of a part its surface shows: not that of a round limb about its own length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.fit.model import SurfaceModel

WANDER = 0.15
"""Radians by which normals of an observed surface are off, about."""
UNSEEN = 0.5
"""Certainty below which a turn is not observed."""


@dataclass(frozen=True, eq=False)
class Turns:
    """The turns of every part about three axes of its own, those shown least first.

    certainty: (P, 3) 0 to 1.
    axes:      (P, 3, 3) column k times a turn of the part, squared, is the mean square by which the
               k-th of them moves the body's surface, metres².
    """

    certainty: Array
    axes: Array

    def stiffness(self) -> Array:
        """(P, 3, 3) a pull on every part that holds the turns which are not seen."""
        unseen = (self.certainty < UNSEEN).astype(np.float64)
        return np.asarray(np.einsum("pik,pk,pjk->pij", self.axes, unseen, self.axes))


def turns_seen(model: SurfaceModel, weights: Array) -> Turns:
    """What the surface shows of every turn where its points count by weights (V,), 0 to 1.

    What moves along the surface is not seen to move. So a turn is as certain as the motion across
    the surface is large beside all motion, and beside what normals wander.
    """
    count, total = model.skeleton.part_count, len(weights)
    certainty, axes = np.zeros((count, 3)), np.zeros((count, 3, 3))
    least = 1e-9 * model.size_m**2 * np.eye(3)
    for part in range(count):
        own = model.own == part
        p, n = model.p_part[own, 0], model.n_part[own, 0]
        second = p.T @ p
        levers = np.trace(second) * np.eye(3) - second
        turned = np.cross(p, n)
        across = turned.T @ (weights[own, None] * turned)
        whole = np.linalg.cholesky(levers / total + least)
        share = np.linalg.solve(whole, np.linalg.solve(whole, across / total).T)
        ratio, directions = np.linalg.eigh((share + share.T) / 2)
        ratio = np.maximum(ratio, 0.0)
        certainty[part] = ratio / (ratio + WANDER**2)
        axes[part] = whole @ directions
    return Turns(certainty, axes)
