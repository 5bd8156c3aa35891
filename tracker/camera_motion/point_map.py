"""The map of a camera that moves: its keyframes, and the landmarks that were picked in them.

A *keyframe* is a picture whose pose is adjusted together with others. A *landmark* is a point of
the background at an inverse depth along the ray of its *anchor*, the keyframe in which it was
picked; infinitely far is 0. The odometry adds both, and asks where landmarks should be seen, and
which are in view again. Keyframes and landmarks are adjusted together (`bundle`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.bundle import (
    Bundle,
    Indices,
    adjusted,
    projection_jacobian,
    residual_lengths,
)
from keypose.tracker.camera_motion.patches import BORDER_PX, Patches
from keypose.tracker.camera_motion.points import Mask, PointFollower
from keypose.tracker.camera_motion.resection import SeenPoints
from keypose.tracker.camera_motion.two_views import TwoViews
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array

FREE = 12
"""Keyframes adjusted together as they come, the latest."""
HELD = 6
"""Keyframes before these that are held: they fix the gauge."""
SPREAD = 1.0
"""Standard deviation of an inverse depth of which nothing is known, over the usual one."""
WITH_POSES = 2.0
"""By how much a depth is less certain than it would be, were all poses known."""
OUTLIER = 4.0
"""Standard deviations: a landmark whose median residual is larger is none."""
NEGATIVE = -3.0
"""Standard deviations below infinitely far, at which a landmark is none."""
STEPS = 3
"""Of an adjustment as keyframes come: the next one goes on from there."""
STEPS_AT_END = 10
"""Of the adjustment of all keyframes."""
LEAST_WARP = 0.6
MOST_WARP = 1.7
"""Size of a patch as it is seen, its own the unit: smaller or larger it does not look alike."""
MOST_TURNED = np.cos(np.radians(25.0))
"""Cosine of the angle between the lines of sight from which a landmark still looks alike."""
LOCATED_SHARE = 0.2
"""Standard deviation of an inverse depth, as a share of it, below which a landmark is looked
for."""
MOST_TRIED = 80
"""Landmarks that are looked for in one keyframe, evenly drawn: a bound on the time."""


@dataclass(eq=False)
class Keyframe:
    """A picture whose pose is adjusted together with others.

    T: (4, 4) camera from world.  ids (K,), xy (K, 2): which landmarks it sees, and where, as x/z
    and y/z.
    """

    frame: int
    T: Array
    ids: Indices
    xy: Array


@dataclass(eq=False)
class PointMap:
    """What a camera that moves has seen: all keyframes in order, all landmarks; a landmark's id is
    its row.

    noise: standard deviation of where a landmark is seen, as x/z.  points: the follower.
    anchor (L,): number of the keyframe in which a landmark was picked.  rays (L, 2): x/z and y/z
    there.  depths (L,): inverse; 0 until `has_depths`.  mean (L,): as they were guessed.
    spread (L,): their standard deviations.  sound (L,): not an outlier.
    """

    camera: Camera
    points: PointFollower
    noise: float
    keyframes: list[Keyframe] = field(default_factory=list)
    has_depths: bool = False
    anchor: Indices = field(default_factory=lambda: np.zeros(0, np.int64))
    rays: Array = field(default_factory=lambda: np.zeros((0, 2)))
    depths: Array = field(default_factory=lambda: np.zeros(0))
    mean: Array = field(default_factory=lambda: np.zeros(0))
    spread: Array = field(default_factory=lambda: np.zeros(0))
    sound: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))
    patches: Patches = field(default_factory=Patches)

    def add(self, keyframe: Keyframe) -> None:
        """Add a keyframe, the anchor of its landmarks that are new; their ids follow the others."""
        new = keyframe.ids >= len(self.anchor)
        count = int(new.sum())
        usual = self._usual_depth(keyframe) if self.has_depths else 0.0
        self.anchor = np.concatenate([self.anchor, np.full(count, len(self.keyframes))])
        self.rays = np.concatenate([self.rays, keyframe.xy[new]])
        self.depths = np.concatenate([self.depths, np.full(count, usual)])
        self.mean = np.concatenate([self.mean, np.full(count, usual)])
        self.spread = np.concatenate([self.spread, np.full(count, SPREAD * usual)])
        self.sound = np.concatenate([self.sound, np.ones(count, bool)])
        self.keyframes.append(keyframe)

    def insert(self, keyframe: Keyframe) -> None:
        """Put a keyframe without new landmarks where its frame belongs."""
        at = sum(before.frame < keyframe.frame for before in self.keyframes)
        self.anchor[self.anchor >= at] += 1
        self.keyframes.insert(at, keyframe)

    def keep(self, ids: Indices, uv: Array) -> None:
        """Keep patches of landmarks (K,) that were picked in the latest picture at uv (K, 2)."""
        now = self.points.now
        assert now is not None
        self.patches.keep(now, len(self.keyframes) - 1, ids, uv, self.points.to_look(uv))

    def _usual_depth(self, keyframe: Keyframe) -> float:
        """The median inverse depth of what a keyframe sees."""
        ids = keyframe.ids[keyframe.ids < len(self.anchor)]
        ids = ids[self.sound[ids] & (self.spread[ids] < 0.5 * np.abs(self.depths[ids]))]
        if not len(ids):
            return 1.0
        world, depths = self._scaled_places(ids)
        Y = world @ keyframe.T[:3, :3].T + depths[:, None] * keyframe.T[:3, 3]
        ahead = depths[Y[:, 2] > 0] / Y[Y[:, 2] > 0, 2]
        return float(np.median(ahead)) if len(ahead) else 1.0

    # --- where landmarks are

    def _scaled_places(self, ids: Indices) -> tuple[Array, Array]:
        """Points (K, 3) times their inverse depths, and these (K,)."""
        Ts, depths = self._anchors(ids), self.depths[ids]
        b = np.concatenate([self.rays[ids], np.ones((len(ids), 1))], axis=1)
        return np.einsum("kba,kb->ka", Ts[:, :3, :3], b - depths[:, None] * Ts[:, :3, 3]), depths

    def observed(self, ids: Indices, xy: Array) -> SeenPoints:
        """What is known of landmarks (K,) that are seen at xy (K, 2)."""
        world, depths = self._scaled_places(ids)
        return SeenPoints(world, depths, self.spread[ids], self._eyes(ids), xy)

    def expected(self, T: Array, ids: Indices) -> Array:
        """Where landmarks are seen from T (4, 4), as x/z and y/z (K, 2); NaN behind."""
        Y = self._ahead(T, ids)
        return np.asarray(Y[:, :2] / np.where(Y[:, 2:] > 1e-3, Y[:, 2:], np.nan))

    def _eyes(self, ids: Indices) -> Array:
        """Where in the world (K, 3) the cameras of landmarks' anchors were."""
        Ts = self._anchors(ids)
        return np.asarray(-np.einsum("kba,kb->ka", Ts[:, :3, :3], Ts[:, :3, 3]))

    def _ahead(self, T: Array, ids: Indices) -> Array:
        """Landmarks (K, 3) in the frame of a camera at T (4, 4), their depth at their anchor the
        unit."""
        world, depths = self._scaled_places(ids)
        return np.asarray(world @ T[:3, :3].T + depths[:, None] * T[:3, 3])

    def _anchors(self, ids: Indices) -> Array:
        """Camera from world (K, 4, 4) of the anchors of landmarks."""
        anchor = self.anchor[ids]
        if not len(anchor):
            return np.zeros((0, 4, 4))
        first, last = int(anchor.min()), int(anchor.max())
        return np.stack([keyframe.T for keyframe in self.keyframes[first : last + 1]])[
            anchor - first
        ]

    # --- which are in view again

    def returned(self, T: Array, present: Indices, usable: Mask | None) -> tuple[Indices, Array]:
        """Landmarks that are in view again from T (4, 4), beside those that are `present`, and
        where (K, 2)."""
        ids = self._candidates(T, present)
        uv = self.camera.project(self._ahead(T, ids))
        inside = self.points.inside(self.points.to_look(uv), BORDER_PX)
        inside[inside] &= self.points.usable_at(usable, self.points.to_look(uv[inside]))
        ids, uv = ids[inside], uv[inside]
        if len(ids) > MOST_TRIED:
            drawn = np.linspace(0, len(ids) - 1, MOST_TRIED).astype(int)
            ids, uv = ids[drawn], uv[drawn]
        there, is_registered = self._registered(T, ids, uv)
        return ids[is_registered], there[is_registered]

    def _candidates(self, T: Array, present: Indices) -> Indices:
        """Landmarks with patches whose depths are known, before the camera, that are seen from
        about where they were picked."""
        ids = self.patches.ids[~np.isin(self.patches.ids, present)]
        located = self.spread[ids] < LOCATED_SHARE * np.abs(self.depths[ids])
        ids = ids[located & self.sound[ids]]
        world, depths = self._scaled_places(ids)
        eye = -T[:3, :3].T @ T[:3, 3]
        from_here = world - depths[:, None] * eye
        from_anchor = world - depths[:, None] * self._eyes(ids)
        lengths = np.linalg.norm(from_here, axis=1) * np.linalg.norm(from_anchor, axis=1)
        alike = (from_here * from_anchor).sum(axis=1) > MOST_TURNED * lengths
        return np.asarray(ids[alike & (self._ahead(T, ids)[:, 2] > 0)], np.int64)

    def _registered(self, T: Array, ids: Indices, uv: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Where landmarks are by their patches (K, 2), looked for about uv (K, 2), and which
        are."""
        now = self.points.now
        assert now is not None
        R = T[:3, :3] @ np.swapaxes(self._anchors(ids)[:, :3, :3], 1, 2)
        warps = projection_jacobian(self._ahead(T, ids)) @ R[:, :, :2]
        size = np.sqrt(np.abs(np.linalg.det(warps)))
        fair = np.flatnonzero((size > LEAST_WARP) & (size < MOST_WARP))
        there, is_registered = uv.copy(), np.zeros(len(ids), np.bool_)
        rows = np.searchsorted(self.patches.ids, ids[fair])
        at = self.points.to_look(uv[fair])
        new, is_registered[fair] = self.patches.register(rows, now, at, warps[fair])
        there[fair] = self.points.to_film(new)
        return there, is_registered

    # --- adjustment

    def begin(self, first: Keyframe, second: Keyframe, ids: Indices, two_views: TwoViews) -> None:
        """Begin with two-view geometry: the pose of the second keyframe, the depths of landmarks.
        All keyframes before were where the first was.

        Args:
            first: whose rays the depths are along.
            second: whose pose becomes that of the two views.
            ids: (K,) the landmarks that both see.
            two_views: of these landmarks.
        """
        self.has_depths = True
        second.T = two_views.T @ first.T
        self.depths[:] = self.mean[:] = 1.0
        self.spread[:] = SPREAD
        eye = -first.T[:3, :3].T @ first.T[:3, 3]
        b = np.concatenate(
            [first.xy[np.searchsorted(first.ids, ids)], np.ones((len(ids), 1))], axis=1
        )
        world = b / np.maximum(two_views.depths, 1e-3)[:, None] @ first.T[:3, :3] + eye
        Ts = self._anchors(ids)
        z = np.einsum("ka,ka->k", Ts[:, 2, :3], world) + Ts[:, 2, 3]
        good = two_views.agree & (z > 0)
        self.depths[ids[good]] = 1 / z[good]
        self.spread[ids[good]] = two_views.spread[good]
        self.sound[ids[~two_views.agree]] = False

    def adjust_last(self) -> None:
        """Adjust the last keyframes and the landmarks in them."""
        first = max(len(self.keyframes) - FREE, 1)
        self._adjust(range(max(first - HELD, 0), len(self.keyframes)), first, STEPS)

    def adjust_all(self) -> None:
        """Adjust all keyframes but the first, and all landmarks."""
        self._adjust(range(len(self.keyframes)), 1, STEPS_AT_END)

    def _adjust(self, among: Sequence[int], first_free: int, steps: int) -> None:
        bundle_of = self.bundle(among, first_free)
        if bundle_of is None:
            return
        bundle, ids, numbers = bundle_of
        bundle, spread = adjusted(bundle, steps)
        for row in np.flatnonzero(bundle.free):
            self.keyframes[numbers[row]].T = bundle.Ts[row]
        self.depths[ids], self.spread[ids] = bundle.depths, WITH_POSES * spread
        self.sound[ids] &= _median_residuals(bundle) < OUTLIER
        self.sound[ids] &= bundle.depths > NEGATIVE * self.spread[ids]

    def bundle(
        self, among: Sequence[int], first_free: int
    ) -> tuple[Bundle, Indices, Indices] | None:
        """The bundle of keyframes by number, of which those from `first_free` on may move; its
        landmarks and its keyframes, anchors among them. None where nothing can be adjusted."""
        number = np.concatenate([np.full(len(self.keyframes[k].ids), k) for k in among])
        ids = np.concatenate([self.keyframes[k].ids for k in among])
        xy = np.concatenate([self.keyframes[k].xy for k in among])
        kept = (self.anchor[ids] != number) & self.sound[ids]
        number, ids, xy = number[kept], ids[kept], xy[kept]
        if len(among) <= first_free - among[0] or not len(ids):
            return None
        landmarks, point = np.unique(ids, return_inverse=True)
        numbers = np.unique(np.concatenate([np.array(among), self.anchor[landmarks]]))
        row = np.zeros(len(self.keyframes), np.int64)
        row[numbers] = np.arange(len(numbers))
        bundle = Bundle(
            Ts=np.stack([self.keyframes[k].T for k in numbers]),
            free=numbers >= first_free,
            anchor=row[self.anchor[landmarks]],
            rays=self.rays[landmarks],
            depths=self.depths[landmarks],
            mean=self.mean[landmarks],
            spread=SPREAD * self.mean[landmarks],
            view=row[number],
            point=point,
            xy=xy,
            noise=self.noise,
        )
        return bundle, landmarks, numbers


def _median_residuals(bundle: Bundle) -> Array:
    """The median residual (P,) of every point, standard deviations."""
    distance = residual_lengths(bundle)
    order = np.lexsort((distance, bundle.point))
    counts = np.bincount(bundle.point, minlength=len(bundle.anchor))
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    return np.asarray(distance[order][starts + (counts - 1) // 2])
