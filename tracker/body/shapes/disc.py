"""A disc that stands on its edge, as a wheel does."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from keypose.tracker.body.shapes.box import CorneredSolid
from keypose.tracker.body.shapes.geometry import SIDES, Mesh, Point, Wireframe, ring
from keypose.tracker.body.shapes.solid import distance_from_excess
from keypose.tracker.geometry.rotations import Array, frozen

_AXES = {"x": 0, "z": 2}


class Disc(CorneredSolid):
    """A round or elliptic disc between two opposite corners, its flat sides square to one axis."""

    kind: Literal["disc"] = "disc"
    axis: Literal["x", "z"] = Field(
        default="x", description="What its flat sides are square to: the axle of a wheel."
    )

    def mesh(self) -> Mesh:
        first, last = self._rims(0.0)
        middles = [first.mean(axis=0), last.mean(axis=0)]
        at = np.arange(SIDES)
        on = np.roll(at, -1)
        near, far = (np.full(SIDES, 2 * SIDES + k) for k in (0, 1))
        quads = [(at, on, SIDES + at), (on, SIDES + on, SIDES + at)]
        flats = [(near, on, at), (far, SIDES + at, SIDES + on)]
        faces = np.concatenate([np.stack(corners, axis=1) for corners in (*quads, *flats)])
        sides = np.repeat([0, 0, 1, 2], SIDES)
        return Mesh.convex(np.vstack([first, last, middles]), faces, sides)

    def wireframe(self, lift_m: float = 0.0) -> Wireframe:
        return Wireframe.rimmed(self._rims(lift_m))

    def distance(self, p_part: Array) -> Array:
        """(N,) metres from points (N, 3) to the surface, negative inside; of an ellipse to first
        order."""
        k, (y, across) = self._axis, self._across
        off, half = p_part - np.array(self.centre), self._half
        radii = half[[y, across]]
        reach = np.linalg.norm(off[:, [y, across]] / radii, axis=1)
        side, beyond = (reach - 1.0) * radii.mean(), np.abs(off[:, k]) - half[k]
        return distance_from_excess(np.stack([side, beyond], axis=1))

    @property
    def far_end(self) -> Point:
        """Where it ends along y, on the side that is farther from the joint."""
        x, _, z = self.centre
        return (x, max(self.high_m[1], self.low_m[1], key=abs), z)

    def marks(self) -> Array:
        """Four points of each rim."""
        return frozen(np.vstack([rim[:: SIDES // 4] for rim in self._rims(0.0)]))

    @property
    def _axis(self) -> int:
        return _AXES[self.axis]

    @property
    def _across(self) -> tuple[int, int]:
        """The axes of its flat sides."""
        return 1, 2 - self._axis

    @property
    def _half(self) -> Array:
        return np.asarray(np.array(self.high_m) - self.low_m) / 2

    def _rims(self, lift_m: float) -> Array:
        """(2, SIDES, 3) points around both flat sides."""
        k, (y, across) = self._axis, self._across
        half = self._half + lift_m
        around = ring(0.0, half[y], half[across])
        rims = np.zeros((2, SIDES, 3))
        rims[:, :, y], rims[:, :, across] = around[:, 0], around[:, 2]
        rims[0, :, k], rims[1, :, k] = -half[k], half[k]
        return np.asarray(rims + np.array(self.centre))
