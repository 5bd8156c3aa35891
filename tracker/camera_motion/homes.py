"""See points again that were out of view, by the patches they were picked with.

A patch is warped to how it should look from where the camera is.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from keypose.tracker.camera_motion.bundle import Indices, projection_slopes
from keypose.tracker.camera_motion.landmarks import Landmarks
from keypose.tracker.camera_motion.points import Mask, PointFollower
from keypose.tracker.camera_motion.view_map import ViewMap
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array

MOST_WARP = 1.7
LEAST_WARP = 0.6
"""Sizes, of the patch at home the unit, at which a point still looks alike."""
MOST_TURNED = np.cos(np.radians(25.0))
"""Cosine of the angle between the lines of sight from which it still does."""
KNOWN_SHARE = 0.2
"""Standard deviation of an inverse depth, as a share of it, below which a point is looked for."""
MOST_TRIED = 80


@dataclass(eq=False)
class Homes:
    """Patches of the points of a map, as the pictures were from which they were picked."""

    map: ViewMap
    follower: PointFollower
    camera: Camera
    patches: Landmarks = field(default_factory=Landmarks)

    def keep(self, ids: Indices, uv: Array) -> None:
        """Keep points (K,) that were picked in the latest picture at uv (K, 2)."""
        now = self.follower.now
        assert now is not None
        self.patches.keep(now, len(self.map.views) - 1, ids, uv, self.follower.to_look(uv))

    def returned(self, T: Array, seen: Indices, usable: Mask | None) -> tuple[Indices, Array]:
        """Points that are in view again from T (4, 4), beside those `seen`, and where."""
        ids = self._candidates(T, seen)
        uv = self.camera.project(self._ahead(T, ids))
        inside = self.follower.inside(self.follower.to_look(uv), 12.0)
        inside[inside] &= self.follower.usable_at(usable, self.follower.to_look(uv[inside]))
        ids, uv = ids[inside], uv[inside]
        if len(ids) > MOST_TRIED:
            some = np.linspace(0, len(ids) - 1, MOST_TRIED).astype(int)
            ids, uv = ids[some], uv[some]
        there, found = self._registered(T, self._rows(ids), ids, uv)
        return ids[found], there[found]

    def _candidates(self, T: Array, seen: Indices) -> Indices:
        """Points whose depths are known, that are not seen, before the camera, from about where
        they were picked.
        """
        ids = self.patches.ids[~np.isin(self.patches.ids, seen)]
        known = self.map.spread[ids] < KNOWN_SHARE * np.abs(self.map.depths[ids])
        ids = ids[known & self.map.sound[ids]]
        world, depths = self.map.in_world(ids)
        eye = -T[:3, :3].T @ T[:3, 3]
        here = world - depths[:, None] * eye
        home = world - depths[:, None] * self.map.eyes(ids)
        lengths = np.linalg.norm(here, axis=1) * np.linalg.norm(home, axis=1)
        alike = (here * home).sum(axis=1) > MOST_TURNED * lengths
        return np.asarray(ids[alike & (self._ahead(T, ids)[:, 2] > 0)], np.int64)

    def _ahead(self, T: Array, ids: Indices) -> Array:
        """Points (K, 3) in the camera's frame, their depth at home the unit."""
        world, depths = self.map.in_world(ids)
        return np.asarray(world @ T[:3, :3].T + depths[:, None] * T[:3, 3])

    def _rows(self, ids: Indices) -> Indices:
        """Of the patches, −1 where a point has none."""
        if not len(self.patches):
            return np.full(len(ids), -1, np.int64)
        rows = np.minimum(np.searchsorted(self.patches.ids, ids), len(self.patches) - 1)
        return np.asarray(np.where(self.patches.ids[rows] == ids, rows, -1), np.int64)

    def _registered(
        self, T: Array, rows: Indices, ids: Indices, uv: Array
    ) -> tuple[Array, np.ndarray[tuple[int], np.dtype[np.bool_]]]:
        """Where points are by their patches (K, 2), looked for about uv (K, 2), and which are."""
        now = self.follower.now
        assert now is not None
        R = T[:3, :3] @ np.swapaxes(self.map.homes(ids)[:, :3, :3], 1, 2)
        warps = projection_slopes(self._ahead(T, ids)) @ R[:, :, :2]
        size = np.sqrt(np.abs(np.linalg.det(warps)))
        fair = np.flatnonzero((size > LEAST_WARP) & (size < MOST_WARP))
        there, found = uv.copy(), np.zeros(len(ids), np.bool_)
        at = self.follower.to_look(uv[fair])
        new, found[fair] = self.patches.register(rows[fair], now, at, warps[fair])
        there[fair] = self.follower.to_film(new)
        return there, found
