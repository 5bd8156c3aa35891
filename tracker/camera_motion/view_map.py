"""Keep what is known of a place: pictures from which points were seen, and how far the points are.

A *view* is a picture whose place is adjusted together with others. A point's number is its row.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.bundle import Bundle, Indices, adjusted, away
from keypose.tracker.camera_motion.resection import SeenPoints
from keypose.tracker.camera_motion.two_views import TwoViews
from keypose.tracker.geometry.rotations import Array

FREE = 12
HELD = 6
"""Views adjusted together as they come, and views before them that are held."""
SPREAD = 1.0
"""Standard deviation of an inverse depth of which nothing is known, over the usual one."""
WITH_PLACES = 2.0
"""By how much a depth is less certain than it would be, were all views known."""
OUTLIER = 4.0
"""A point whose median distance from where it should be is more standard deviations is none."""
STEPS = 3
STEPS_AT_END = 10


@dataclass(eq=False)
class View:
    """T (4, 4): camera from world.  ids (K,), xy (K, 2): which points it sees, and where."""

    frame: int
    T: Array
    ids: Indices
    xy: Array


@dataclass(eq=False)
class ViewMap:
    """All views in order, and all points.

    noise: standard deviation of a place, as x/z.  home (P,): the view in which a point was picked.
    rays (P, 2).  depths (P,): inverse; 0 until `known`.  mean: as it was guessed.  spread: its
    standard deviation.  sound (P,): not an outlier.
    """

    noise: float
    views: list[View] = field(default_factory=list)
    known: bool = False
    home: Indices = field(default_factory=lambda: np.zeros(0, np.int64))
    rays: Array = field(default_factory=lambda: np.zeros((0, 2)))
    depths: Array = field(default_factory=lambda: np.zeros(0))
    mean: Array = field(default_factory=lambda: np.zeros(0))
    spread: Array = field(default_factory=lambda: np.zeros(0))
    sound: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))

    def add(self, view: View) -> None:
        """Add a view, the home of its points that are new; their numbers follow the known ones."""
        new = view.ids >= len(self.home)
        count = int(new.sum())
        usual = self.usual_depth(view) if self.known else 0.0
        self.home = np.concatenate([self.home, np.full(count, len(self.views))])
        self.rays = np.concatenate([self.rays, view.xy[new]])
        self.depths = np.concatenate([self.depths, np.full(count, usual)])
        self.mean = np.concatenate([self.mean, np.full(count, usual)])
        self.spread = np.concatenate([self.spread, np.full(count, SPREAD * usual)])
        self.sound = np.concatenate([self.sound, np.ones(count, bool)])
        self.views.append(view)

    def insert(self, view: View) -> None:
        """Put a view of points that are known where its frame belongs."""
        at = sum(one.frame < view.frame for one in self.views)
        self.home[self.home >= at] += 1
        self.views.insert(at, view)

    def usual_depth(self, view: View) -> float:
        """The median inverse depth of what a view sees."""
        ids = view.ids[view.ids < len(self.home)]
        ids = ids[self.sound[ids] & (self.spread[ids] < 0.5 * np.abs(self.depths[ids]))]
        if not len(ids):
            return 1.0
        world, depths = self.in_world(ids)
        Y = world @ view.T[:3, :3].T + depths[:, None] * view.T[:3, 3]
        found = depths[Y[:, 2] > 0] / Y[Y[:, 2] > 0, 2]
        return float(np.median(found)) if len(found) else 1.0

    def in_world(self, ids: Indices) -> tuple[Array, Array]:
        """Points (K, 3) times their inverse depths, and these (K,)."""
        Ts, depths = self.homes(ids), self.depths[ids]
        b = np.concatenate([self.rays[ids], np.ones((len(ids), 1))], axis=1)
        return np.einsum("kba,kb->ka", Ts[:, :3, :3], b - depths[:, None] * Ts[:, :3, 3]), depths

    def seen(self, ids: Indices, xy: Array) -> SeenPoints:
        """What is known of points that are seen at xy (K, 2)."""
        world, depths = self.in_world(ids)
        return SeenPoints(world, depths, self.spread[ids], self.eyes(ids), xy)

    def eyes(self, ids: Indices) -> Array:
        """Where in the world (K, 3) the cameras were that points were picked in."""
        Ts = self.homes(ids)
        return np.asarray(-np.einsum("kba,kb->ka", Ts[:, :3, :3], Ts[:, :3, 3]))

    def expected(self, T: Array, ids: Indices) -> Array:
        """Where points are seen from T, as x/z and y/z (K, 2); NaN behind."""
        world, depths = self.in_world(ids)
        Y = world @ T[:3, :3].T + depths[:, None] * T[:3, 3]
        return np.asarray(Y[:, :2] / np.where(Y[:, 2:] > 1e-3, Y[:, 2:], np.nan))

    def homes(self, ids: Indices) -> Array:
        """Camera from world (K, 4, 4) of the views in which points were picked."""
        home = self.home[ids]
        if not len(home):
            return np.zeros((0, 4, 4))
        first, last = int(home.min()), int(home.max())
        return np.stack([view.T for view in self.views[first : last + 1]])[home - first]

    def begin(self, view: View, other: View, ids: Indices, two_views: TwoViews) -> None:
        """Take what two views tell: where the other was, and how far points (K,) are. All views
        before were where the first was.
        """
        self.known = True
        other.T = two_views.T @ view.T
        self.depths[:] = self.mean[:] = 1.0
        self.spread[:] = SPREAD
        eye = -view.T[:3, :3].T @ view.T[:3, 3]
        b = np.concatenate(
            [view.xy[np.searchsorted(view.ids, ids)], np.ones((len(ids), 1))], axis=1
        )
        world = b / np.maximum(two_views.depths, 1e-3)[:, None] @ view.T[:3, :3] + eye
        Ts = self.homes(ids)
        z = np.einsum("ka,ka->k", Ts[:, 2, :3], world) + Ts[:, 2, 3]
        good = two_views.agree & (z > 0)
        self.depths[ids[good]] = 1 / z[good]
        self.spread[ids[good]] = two_views.spread[good]
        self.sound[ids[~two_views.agree]] = False

    def adjust_last(self) -> None:
        """Adjust the last views and the points in them."""
        first = max(len(self.views) - FREE, 1)
        self._adjust(range(max(first - HELD, 0), len(self.views)), first, STEPS)

    def adjust_all(self) -> None:
        """Adjust all views but the first, and all points."""
        self._adjust(range(len(self.views)), 1, STEPS_AT_END)

    def _adjust(self, among: Sequence[int], first_free: int, steps: int) -> None:
        found = self.bundle(among, first_free)
        if found is None:
            return
        bundle, points, views = found
        bundle, spread = adjusted(bundle, steps)
        for row in np.flatnonzero(bundle.free):
            self.views[views[row]].T = bundle.Ts[row]
        self.depths[points], self.spread[points] = bundle.depths, WITH_PLACES * spread
        self.sound[points] &= _middle(bundle) < OUTLIER
        self.sound[points] &= bundle.depths > -3 * self.spread[points]

    def bundle(
        self, among: Sequence[int], first_free: int
    ) -> tuple[Bundle, Indices, Indices] | None:
        """The bundle of these views; its points and its views, homes among them."""
        view = np.concatenate([np.full(len(self.views[v].ids), v) for v in among])
        ids = np.concatenate([self.views[v].ids for v in among])
        xy = np.concatenate([self.views[v].xy for v in among])
        kept = (self.home[ids] != view) & self.sound[ids]
        view, ids, xy = view[kept], ids[kept], xy[kept]
        if len(among) <= first_free - among[0] or not len(ids):
            return None
        points, point = np.unique(ids, return_inverse=True)
        views = np.unique(np.concatenate([np.array(among), self.home[points]]))
        row = np.zeros(len(self.views), np.int64)
        row[views] = np.arange(len(views))
        bundle = Bundle(
            Ts=np.stack([self.views[v].T for v in views]),
            free=views >= first_free,
            home=row[self.home[points]],
            rays=self.rays[points],
            depths=self.depths[points],
            mean=self.mean[points],
            spread=SPREAD * self.mean[points],
            view=row[view],
            point=point,
            xy=xy,
            noise=self.noise,
        )
        return bundle, points, views


def _middle(bundle: Bundle) -> Array:
    """The median distance (P,) of every point from where it should be, standard deviations."""
    distance = away(bundle)
    order = np.lexsort((distance, bundle.point))
    counts = np.bincount(bundle.point, minlength=len(bundle.home))
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    return np.asarray(distance[order][starts + (counts - 1) // 2])
