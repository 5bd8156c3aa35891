"""How far the body's edges lie from those that a picture has, as a term.

Clothes are thicker than the body: how far all edges of a part lie outward is free, within limits,
so that thickness is not taken for nearness.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.fitting.pose.outline import Edges, Outline
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import Posed, image_jacobian, image_points
from keypose.tracker.solver.terms import Equations

EDGE_SIGMA_PX, MOST_SPREAD_PX, STRAY_PX = 1.0, 4.0, 3.0
"""Sigma of an edge at best, and at most for a body that fits: shapes are not exact. Beyond the
last, an edge counts less."""
THICKNESS_SIGMA_M = 0.016
INFORMATION = 0.3
"""Independent observations that one line stands for."""


@dataclass(frozen=True, eq=False)
class EdgeDistances:
    """Edges of the body at those of a picture, each part's thickness marginalised: a term.

    part (M,), p_part (M, 3): places on the body, in their parts' frames.
    normal (M, 2), target_px (M,): each seen at a pixel whose product with its normal is its target.
    weights (M,): 1/px².  thickness_px: σ of how far the edges of a part lie outward together.
    """

    camera: Camera
    part: NDArray[np.int64]
    p_part: Array
    normal: Array
    target_px: Array
    weights: Array
    thickness_px: float

    @classmethod
    def of(cls, outline: Outline, posed: Posed, edges: Edges) -> EdgeDistances:
        """Of edges that were found at a pose.

        Parts that are not tracked, such as hands and feet, get no weight: they stay as posed,
        so their edges would pull at their parents.
        """
        used = edges.located & np.isin(edges.part, outline.skeleton.dof_part)
        away = np.abs(edges.away_px[used])
        spread = max(EDGE_SIGMA_PX, 1.4826 * float(np.median(away))) if away.size else EDGE_SIGMA_PX
        weights = INFORMATION * used / (edges.variance + min(spread, MOST_SPREAD_PX) ** 2)
        weights *= np.minimum(1.0, STRAY_PX / np.maximum(np.abs(edges.away_px), 1e-9))
        T = posed.Ts_camera_part[edges.part]
        p_part = np.einsum("mba,mb->ma", T[:, :3, :3], edges.p_camera - T[:, :3, 3])
        uv = image_points(outline.camera, edges.p_camera)
        target = (edges.normal * uv).sum(axis=-1) + edges.away_px
        thickness = THICKNESS_SIGMA_M / outline.pixel_m
        return cls(outline.camera, edges.part, p_part, edges.normal, target, weights, thickness)

    def cost(self, posed: Posed) -> float:
        """At the best thicknesses."""
        r = self._offsets_px(posed.points(self.part, self.p_part))
        precision, pull = self._thickness(r, posed.skeleton.part_count)
        return self._cost(r, precision, pull)

    def equations(self, posed: Posed) -> Equations:
        dofs, parts = posed.skeleton.dof_count, posed.skeleton.part_count
        p = posed.points(self.part, self.p_part)
        J = image_jacobian(self.camera, p, posed.point_jacobian(self.part, p))
        outward = np.asarray((J * self.normal[:, None]).sum(axis=-1))
        thicker = (self.part[:, None] == np.arange(parts)).astype(float)
        r = self._offsets_px(p)
        rows = np.concatenate([outward, thicker, r[:, None]], axis=1)
        weighed = outward * self.weights[:, None]  # so small that threads of a product only cost
        A, cross, b = np.split(np.einsum("md,me->de", weighed, rows), [dofs, dofs + parts], axis=1)
        precision, pull = self._thickness(r, parts)
        share, cost = cross / precision, self._cost(r, precision, pull)
        return Equations(A - share @ cross.T, b[:, 0] - share @ pull, cost)

    def _thickness(self, r: Array, parts: int) -> tuple[Array, Array]:
        """(P,) precision of each part's thickness, and its gradient."""
        seen = np.bincount(self.part, weights=self.weights, minlength=parts)
        pull = np.bincount(self.part, weights=self.weights * r, minlength=parts)
        return np.asarray(seen + 1 / self.thickness_px**2, np.float64), np.asarray(pull, np.float64)

    def _cost(self, r: Array, precision: Array, pull: Array) -> float:
        return 0.5 * float(self.weights @ r**2 - (pull**2 / precision).sum())

    def _offsets_px(self, p: Array) -> Array:
        """(M,) pixels by which places p (M, 3) in the camera frame lie too far outward."""
        uv = image_points(self.camera, p)
        return np.asarray((self.normal * uv).sum(axis=-1) - self.target_px)
