"""A rod with round ends."""

from __future__ import annotations

from typing import Literal, Self

import numpy as np

from keypose.tracker.body.shapes.geometry import SIDES, Mesh, Point, Size, Wireframe, ring
from keypose.tracker.body.shapes.round import OneRadius
from keypose.tracker.body.shapes.solid import Solid
from keypose.tracker.geometry.rotations import Array, frozen

_RISE = np.deg2rad([89, 75, 60, 45, 30, 15, 0])
"""Angles above an end's widest ring at which the end has rings, from the tip on."""


class Capsule(OneRadius):
    """A round cylinder with a hemisphere at each end, from tip to tip along y.

    Where it is wider than long, its ends are flattened to half the length: every length and every
    radius make a capsule, so that either can be changed by itself.
    """

    kind: Literal["capsule"] = "capsule"
    radius_m: Size

    @property
    def cap_m(self) -> float:
        """How high its ends are, along y."""
        return min(self.radius_m, self.length_m / 2)

    @classmethod
    def like(cls, solid: Solid) -> Self:
        start, end = solid.span_y
        return cls(start_m=start, end_m=end, radius_m=solid.width_m / 2)

    def mesh(self) -> Mesh:
        rings = self.wireframe().rings
        if 2 * self.radius_m >= self.length_m:  # both ends share their widest ring
            rings = np.delete(rings, len(_RISE), axis=0)
        count, tips = len(rings), [[0.0, self.start_m, 0.0], [0.0, self.end_m, 0.0]]
        at = np.arange(count * SIDES).reshape(count, SIDES)
        on = np.roll(at, -1, axis=1)
        strips = [(at[:-1], on[:-1], at[1:]), (on[:-1], on[1:], at[1:])]
        first, last = (np.full(SIDES, count * SIDES + k) for k in (0, 1))
        caps = [(first, on[0], at[0]), (last, at[-1], on[-1])]
        faces = np.concatenate([np.stack(f, axis=-1).reshape(-1, 3) for f in (*strips, *caps)])
        vertices = np.vstack([rings.reshape(-1, 3), tips])
        return Mesh.convex(vertices, faces, np.zeros(len(faces), np.int64))

    def wireframe(self, lift_m: float = 0.0) -> Wireframe:
        inward = np.sign(self.end_m - self.start_m)
        wide = (self.radius_m + lift_m) * np.cos(_RISE)
        down = inward * (self.cap_m - (self.cap_m + lift_m) * np.sin(_RISE))
        first = [ring(self.start_m + y, x, x) for y, x in zip(down, wide, strict=True)]
        last = [ring(self.end_m - y, x, x) for y, x in zip(down, wide, strict=True)]
        return Wireframe(frozen(np.zeros((0, 2, 3))), frozen(np.stack([*first, *last[::-1]])))

    def distance(self, p_part: Array) -> Array:
        """(N,) metres from points (N, 3) to the surface, negative inside; to flattened
        ends to first order."""
        straight = self.length_m / 2 - self.cap_m
        off = np.linalg.norm(p_part[:, [0, 2]], axis=1)
        along = np.maximum(np.abs(p_part[:, 1] - self.centre[1]) - straight, 0.0)
        level = np.hypot(off / self.radius_m, along / self.cap_m)  # 1 on the surface
        slope = np.hypot(off / self.radius_m**2, along / self.cap_m**2)
        reach = np.divide(level, slope, out=np.full_like(level, self.cap_m), where=level > 1e-9)
        return np.asarray(np.maximum((level - 1.0) * reach, -self.cap_m))

    def marks(self) -> Array:
        """Both tips; of one as wide as it is long also its widest ring, see `RoundSolid.marks`."""
        marks = [(0.0, self.start_m, 0.0), (0.0, self.end_m, 0.0)]
        if 2 * self.radius_m >= self.length_m:
            y, r = self.centre[1], self.radius_m
            marks += [(r, y, 0.0), (-r, y, 0.0), (0.0, y, r), (0.0, y, -r)]
        return frozen(marks)

    def face_points(self) -> dict[str, Point]:
        return self._face(self.radius_m, self.radius_m)
