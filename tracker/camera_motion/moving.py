"""Find where a camera went that moves through a place, from points of the background.

The scale is not told by pictures: the unit of length is the usual depth of points where the camera
began to move. Until it moves it is turned only, and where it never does its place is not known.
The focal length stays what it is.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.trajectory import runs
from keypose.tracker.camera_motion.bundle import Indices
from keypose.tracker.camera_motion.homes import Homes
from keypose.tracker.camera_motion.path_drift import pulled
from keypose.tracker.camera_motion.points import Background, Grey, Mask, PointFollower
from keypose.tracker.camera_motion.resection import resected
from keypose.tracker.camera_motion.two_views import parallax, two_views
from keypose.tracker.camera_motion.view_map import FREE, View, ViewMap
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array

NOISE_PX = 0.25
"""Standard deviation of a place, at the size looked at."""
FEWEST = 15
"""Points that a place is believed from."""
LEAST_SHARE, LONGEST = 0.7, 25
"""New points are picked where fewer are left, or after so many frames."""
BETWEEN = 13
"""Frames from a view to the next, with new points or not."""
STEP = 0.1
"""Standard deviation of a frame's step, in usual depths."""
START_PX, LEAST_START_PX, PATIENCE = 12.0, 2.0, 60
"""Parallax with which the camera is seen to move; after so many frames the least will do."""
SHARED = 0.4
"""Share of the points that two views must both see to tell how the camera moved."""
WAITING = 60
"""Views before the camera moves whose place is found once it does."""
ASKED = 80
"""Points that are followed from the picture before once depths are known: then these tell where
the others are to be expected."""
ROUGHLY, FINELY = (12.0, 4.0), (3.0, 1.0, 1.0)
SETTLING: tuple[float, ...] = (4.0, 2.0, 1.0, 1.0, 1.0)
STAYING: tuple[float, ...] = ()
"""Scales of the steps by which a frame is placed: by points followed roughly, then by where they
are, once more when depths are better known, and not at all."""
EVERY = 3
"""Frames after which it is asked whether the camera moves."""


@dataclass(frozen=True)
class FewPoints:
    """Frames first to last show too few points to say where the camera was."""

    first: int
    last: int


@dataclass(frozen=True)
class NoParallax:
    """The film does not show that the camera was anywhere else than at its first frame."""


@dataclass(frozen=True, eq=False)
class MovedPath:
    """A path in the unit of length that the film gives, and what is to be said of it.

    agree: (N,) how many points each frame's place is found from.
    """

    path: CameraPath
    agree: NDArray[np.int64]
    findings: tuple[FewPoints | NoParallax, ...]

    def scaled(self, metres: float) -> CameraPath:
        """The path in metres, where the unit is so many."""
        Ts = self.path.Ts_camera_world.copy()
        Ts[:, :3, 3] *= metres
        return CameraPath(Ts, self.path.zoom)


def moved_path(
    pictures: Iterable[Grey], camera: Camera, background: Background = lambda frame: None
) -> MovedPath:
    """Follow the camera through all pictures (H, W), one after the other; none is kept."""
    moving = MovingCamera(camera)
    for frame, picture in enumerate(pictures):
        moving.take(picture, background(frame))
    return moving.finished()


@dataclass(eq=False)
class _Frame:
    """A frame that waits for its last place: points found (K,), (K, 2)."""

    frame: int
    ids: Indices
    xy: Array


@dataclass(frozen=True, eq=False)
class _Pair:
    """A view and a later picture, and how far apart they show the same points, turns aside."""

    px: float
    view: View
    other: View


@dataclass(eq=False)
class MovingCamera:
    """A camera's places up to the latest picture."""

    camera: Camera
    _follower: PointFollower = field(init=False)
    _map: ViewMap = field(init=False)
    _homes: Homes = field(init=False)
    _Ts: list[Array] = field(default_factory=list, init=False)
    _agree: list[int] = field(default_factory=list, init=False)
    _waiting: list[_Frame] = field(default_factory=list, init=False)
    _widest: _Pair | None = field(default=None, init=False)
    _picked: int = field(default=0, init=False)
    _last: tuple[Array, NDArray[np.bool_]] = field(init=False)

    def __post_init__(self) -> None:
        plain = {"projection": "perspective", "telephoto_distance_m": None}
        self.camera = self.camera.model_copy(update=plain)
        self._follower = PointFollower(self.camera.width, self.camera.height)
        self._map = ViewMap(NOISE_PX / self._follower.scale / self.camera.fx)
        self._last = np.zeros((0, 2)), np.zeros(0, bool)
        self._homes = Homes(self._map, self._follower, self.camera)

    def take(self, picture: Grey, usable: Mask | None) -> None:
        """Find where the camera was as it took the next picture."""
        frame, follower = len(self._Ts), self._follower
        rough, followed = follower.look(picture, ASKED if self._map.known else None)
        if follower.anchor is None:
            self._Ts.append(np.eye(4))
            self._agree.append(0)
            self._add_view(usable, np.zeros(0, np.int64), np.zeros((0, 2)))
            return
        ids, T = follower.anchor.ids, self._Ts[-1]
        if followed.sum() >= FEWEST:
            T = self._placed(T, ids[followed], self._flat(rough[followed]), ROUGHLY)[0]
        expected = self._expected(T, ids, rough, followed)
        uv, found = follower.refine(expected, usable, halvings=0 if self._map.known else 1)
        self._last = (uv, found)
        ids, uv = ids[found], uv[found]
        xy, agree = self._flat(uv), np.zeros(len(ids), bool)
        if len(ids) >= FEWEST:
            T, agree = self._placed(T, ids, xy, FINELY)
        self._Ts.append(T)
        self._agree.append(int(agree.sum()))
        self._waiting.append(_Frame(frame, ids, xy))
        # until depths are known, what no turn explains is as likely near as an outlier
        kept = agree if self._map.known else np.ones(len(ids), bool)
        few = kept.sum() < LEAST_SHARE * len(found)
        if few or frame - self._picked >= LONGEST:
            self._add_view(usable, ids[kept], uv[kept])
        elif frame - self._map.views[-1].frame >= BETWEEN:
            self._map.add(View(frame, T, ids[kept], xy[kept]))
        if not self._map.known and frame % EVERY == 0 and len(ids) >= FEWEST:
            self._watch(View(frame, T, ids, xy))

    def _expected(self, T: Array, ids: Indices, rough: Array, followed: NDArray[np.bool_]) -> Array:
        """Where points are (K, 2), the camera at about T (4, 4): once depths are known, from where
        they were in the frame before, as far on as the camera went.
        """
        shown = self._pixels(self._map.expected(T, ids))
        if self._map.known and len(self._last[0]) == len(ids):
            before = self._pixels(self._map.expected(self._Ts[-1], ids))
            on = self._last[0] + shown - before
            shown = np.where(self._last[1][:, None], on, shown)
        elif not self._map.known:
            shown = np.where(followed[:, None], rough, shown)
        return np.where(np.isfinite(shown), shown, rough)

    def finished(self) -> MovedPath:
        """The path of all frames."""
        if not self._map.known:
            self._start(LEAST_START_PX)
        Ts = np.stack(self._Ts)
        if self._map.known:
            Ts = self._in_whole()
        agree = np.array(self._agree)
        agree[0] = agree[1:].max(initial=0)
        findings: list[FewPoints | NoParallax] = [FewPoints(*run) for run in runs(agree < FEWEST)]
        if not self._map.known:
            findings.append(NoParallax())
        return MovedPath(CameraPath(Ts, np.ones(len(Ts))), agree, tuple(findings))

    def _in_whole(self) -> Array:
        """All frames' (N, 4, 4), after all views are adjusted together."""
        frames = [view.frame for view in self._map.views]
        for frame, view in zip(frames, self._map.views, strict=True):
            self._Ts[frame] = view.T
        before = np.stack(self._Ts)
        self._map.adjust_all()
        self._Ts = list(pulled(before, frames, np.stack([view.T for view in self._map.views])))
        self._settle_frames(self._waiting)
        return np.stack(self._Ts)

    def _flat(self, uv: Array) -> Array:
        return self.camera.back_project(uv, 1.0)[..., :2]

    def _pixels(self, xy: Array) -> Array:
        return self.camera.project(np.concatenate([xy, np.ones((len(xy), 1))], axis=1))

    def _placed(
        self, start: Array, ids: Indices, xy: Array, scales: tuple[float, ...] | None = None
    ) -> tuple[Array, NDArray[np.bool_]]:
        sound = self._map.sound[ids]
        seen = self._map.seen(ids[sound], xy[sound])
        given = {} if scales is None else {"scales": scales}
        found = resected(start, seen, self._map.noise, STEP, **given)
        agree = np.zeros(len(ids), bool)
        agree[sound] = found.agree
        return found.T, agree

    def _add_view(self, usable: Mask | None, ids: Indices, uv: Array) -> None:
        """Make the latest picture a view, and adjust the last ones."""
        known, self._picked = len(self._map.home), len(self._Ts) - 1
        anchor = self._follower.pick(usable, ids, uv)
        ids, uv = anchor.ids, anchor.uv
        self._last = (uv, np.ones(len(ids), bool))
        back, uv_back = self._returned(ids, usable)
        seen = np.concatenate([ids, back])
        at = np.concatenate([uv, uv_back])
        order = np.argsort(seen)
        self._map.add(View(len(self._Ts) - 1, self._Ts[-1], seen[order], self._flat(at[order])))
        self._homes.keep(ids[ids >= known], uv[ids >= known])
        if self._map.known:
            self._map.adjust_last()
            self._Ts[-1] = self._map.views[-1].T
            self._settle(len(self._map.views) - FREE)
        else:
            self._settle(len(self._map.views) - WAITING)

    def _returned(self, ids: Indices, usable: Mask | None) -> tuple[Indices, Array]:
        """Points of old that are in view again, beside those of the latest picture."""
        none = np.zeros(0, np.int64), np.zeros((0, 2))
        if not self._map.known:
            return none
        back, uv = self._homes.returned(self._Ts[-1], ids, usable)
        if len(back) < FEWEST:
            return none
        _, agree = self._placed(self._Ts[-1], back, self._flat(uv))
        return (back[agree], uv[agree]) if agree.sum() >= FEWEST else none

    def _watch(self, now: View) -> None:
        """See whether the camera moved since an earlier view, and start as soon as it is plain."""
        for view in self._recent()[:2]:
            _, one, other = np.intersect1d(view.ids, now.ids, return_indices=True)
            if view.frame < now.frame and len(one) >= SHARED * len(now.ids):
                px = parallax(view.xy[one], now.xy[other], self._map.noise) * NOISE_PX
                if self._widest is None or px > self._widest.px:
                    self._widest = _Pair(px, view, now)
        patient = now.frame % PATIENCE < EVERY
        self._start(LEAST_START_PX if patient else START_PX)

    def _recent(self) -> list[View]:
        """Views of which the latest still sees enough, the earliest first."""
        last, views = self._map.views[-1], self._map.views[-WAITING:]
        least = SHARED * len(last.ids)
        return [view for view in views if np.isin(view.ids, last.ids).sum() >= least]

    def _start(self, least_px: float) -> None:
        """See whether the two pictures with the widest parallax tell how the camera moved, and how
        far all points are.
        """
        pair = self._widest
        if pair is None or pair.px < least_px:
            return
        self._widest = None
        one, other = pair.view, pair.other
        ids, i, j = np.intersect1d(one.ids, other.ids, return_indices=True)
        found = two_views(one.xy[i], other.xy[j], self._map.noise)
        if found is None:
            return
        if all(view.frame != other.frame for view in self._map.views):
            self._map.insert(other)
        other = next(view for view in self._map.views if view.frame == other.frame)
        self._map.begin(one, other, ids, found)
        for view in self._map.views[-WAITING:]:
            if view is not one and view is not other and len(view.ids) >= FEWEST:
                view.T = self._placed(view.T, view.ids, view.xy)[0]
        self._map.adjust_all()
        last = self._waiting[-1]
        self._Ts[-1] = self._placed(self._map.views[-1].T, last.ids, last.xy)[0]

    def _settle(self, count: int) -> None:
        """Find once more where the frames before the view of this number were."""
        if count <= 0:
            return
        until = self._map.views[min(count, len(self._map.views) - 1)].frame
        done = [one for one in self._waiting if one.frame < until]
        self._waiting = [one for one in self._waiting if one.frame >= until]
        self._settle_frames(done)

    def _settle_frames(self, frames: list[_Frame]) -> None:
        views = {view.frame: view.T for view in self._map.views}
        for one in frames:
            start, scales = self._Ts[one.frame], SETTLING
            if one.frame in views:
                start, scales = views[one.frame], STAYING
            if self._map.known and len(one.ids) >= FEWEST:
                start, agree = self._placed(start, one.ids, one.xy, scales)
                self._agree[one.frame] = int(agree.sum())
            self._Ts[one.frame] = start
