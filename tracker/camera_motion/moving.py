"""Follow a camera that moves through a place, one picture after the other.

Until it is seen to move it is turned only. Then the two pictures with the widest parallax tell how
it moved and how far points are; frames before are found anew. Every frame is placed by the points
known so far, at times together with others (a view), and once more when these are known better.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.bundle import Indices
from keypose.tracker.camera_motion.focal import FocalScale
from keypose.tracker.camera_motion.homes import Homes
from keypose.tracker.camera_motion.moved_focal import focal_of
from keypose.tracker.camera_motion.path_drift import pulled
from keypose.tracker.camera_motion.points import Grey, Mask, PointFollower
from keypose.tracker.camera_motion.resection import SCALES, Resected, resected
from keypose.tracker.camera_motion.two_views import parallax, two_views
from keypose.tracker.camera_motion.view_map import FREE, View, ViewMap
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation, transform

NOISE_PX = 0.25
"""Standard deviation of a place, at the size looked at."""
FEWEST = 15
"""Points that a place is believed from."""
FEWEST_SHARE = 0.3
"""Of the anchor's points, until depths are known: noise too lets some be found again."""
LOST_FRAMES = 4
"""After so many frames without a place points are picked anew, tied to those of old that are seen
again, or to nothing."""
OPEN_SHARE = 0.3
"""Of the picture; with less background what is before it is why the camera is lost."""
LEAST_SHARE = 0.7
LONGEST = 25
"""New points are picked where fewer are left, or after so many frames."""
BETWEEN = 13
"""Frames from a view to the next, with new points or not."""
STEP = 0.1
"""Standard deviation of a frame's step, in usual depths."""
START_PX = 12.0
LEAST_START_PX = 2.0
PATIENCE = 60
RETRY = 15
"""Parallax with which the camera is seen to move; after so many frames the least will do,
asked for every so many."""
SEARCH_HALVINGS = 3
"""By which the picture is made smaller where points are looked for after the camera was lost."""
SHARED = 0.4
"""Share of the points that two views must both see to tell how the camera moved."""
WAITING = 60
"""Views before the camera moves whose place is found once it does."""
ASKED = 80
"""Points that are followed from the picture before once depths are known: then these tell where
the others are to be expected."""
ROUGHLY = (12.0, 4.0)
FINELY = (3.0, 1.0, 1.0)
SETTLING: tuple[float, ...] = (1.0, 1.0, 1.0)
STARTING: tuple[float, ...] = (4.0, 2.0, 1.0, 1.0, 1.0)
STAYING: tuple[float, ...] = ()
"""Scales of the steps by which a frame is placed: by points followed roughly, then by where they
are; once more when depths are better known, or for the first time; and not at all."""
Cause: TypeAlias = Literal["", "no_texture", "body_fills", "no_picture"]

EVERY = 3
"""Frames after which it is asked whether the camera moves."""


@dataclass(eq=False)
class _Frame:
    """A frame that waits for its last place: points found (K,), (K, 2).

    turned: whether it has been turned only, no depth known.
    """

    frame: int
    ids: Indices
    xy: Array
    turned: bool


@dataclass(frozen=True, eq=False)
class _Sight:
    """Points found in a picture: ids (K,), uv and xy (K, 2), which count (K,), and its place."""

    placed: Resected
    ids: Indices
    uv: Array
    xy: Array
    kept: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Pair:
    """A view and a later picture, and how far apart they show the same points, turns aside."""

    px: float
    view: View
    other: View


@dataclass(eq=False)
class MovingCamera:
    """A camera's places up to the latest picture.

    known: whether depths are; until then the camera is turned only.  causes: why a frame has no
    place of its own, nothing where it has.  errors_px: median residual of the points that agree,
    pixels of the film, NaN without.  ended: whether the latest picture shows a place that nothing
    ties to those before: take it with another.
    """

    camera: Camera
    causes: list[Cause] = field(default_factory=list, init=False)
    errors_px: list[float] = field(default_factory=list, init=False)
    ended: bool = field(default=False, init=False)
    _follower: PointFollower = field(init=False)
    _map: ViewMap = field(init=False)
    _homes: Homes = field(init=False)
    _Ts: list[Array] = field(default_factory=list, init=False)
    _waiting: list[_Frame] = field(default_factory=list, init=False)
    _widest: _Pair | None = field(default=None, init=False)
    _picked: int = field(default=0, init=False)
    _last: tuple[Array, NDArray[np.bool_]] = field(init=False)
    _lost: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        plain = {"projection": "perspective", "telephoto_distance_m": None}
        self.camera = self.camera.model_copy(update=plain)
        self._follower = PointFollower(self.camera.width, self.camera.height)
        self._map = ViewMap(NOISE_PX / self._follower.scale / self.camera.fx)
        self._last = np.zeros((0, 2)), np.zeros(0, bool)
        self._homes = Homes(self._map, self._follower, self.camera)

    @property
    def known(self) -> bool:
        return self._map.known

    def take(self, picture: Grey | None, usable: Mask | None) -> None:
        """Find where the camera was as it took the next picture; None is one that cannot be read.

        usable: of its pixels (H, W), those that may be background.
        """
        T = self._Ts[-1] if self._Ts else np.eye(4)
        if picture is None:
            self._note(T, "no_picture", np.nan)
            return
        rough, followed = self._follower.look(picture, ASKED if self.known else None)
        if self._follower.anchor is None:
            self._note(T, "", 0.0)
            self._add_view(usable, np.zeros(0, np.int64), np.zeros((0, 2)))
            if not len(self._map.home):
                self.causes[-1] = _cause(usable)
            return
        self._place(rough, followed, usable)

    def focal(self) -> FocalScale | None:
        """The focal length that the places tell, after the path is finished."""
        return focal_of(self._map)

    def drop_last(self) -> None:
        """Forget the latest picture."""
        for kept in (self._Ts, self.causes, self.errors_px):
            kept.pop()

    def _place(self, rough: Array, followed: NDArray[np.bool_], usable: Mask | None) -> None:
        """Place the latest picture by the points of the anchor."""
        assert self._follower.anchor is not None
        ids, T = self._follower.anchor.ids, self._Ts[-1]
        if followed.sum() >= FEWEST:
            T = self._placed(T, ids[followed], self._flat(rough[followed]), ROUGHLY).T
        expected = self._expected(T, ids, rough, followed)
        sight = self._sight(T, expected, usable, halvings=0 if self.known else 1)
        if sight is None and self._lost:
            T, expected = self._by_whole_shift()
            sight = self._sight(T, expected, usable, halvings=SEARCH_HALVINGS)
        if sight is None:
            self._lose(usable)
        else:
            self._go_on(sight, usable)

    def _sight(
        self, T: Array, expected: Array, usable: Mask | None, halvings: int
    ) -> _Sight | None:
        """What the latest picture shows of the anchor's points, expected at (K, 2), the camera at
        about T (4, 4); None where that is too little.
        """
        assert self._follower.anchor is not None
        uv, found = self._follower.refine(expected, usable, halvings)
        self._last = (uv, found)
        ids, uv = self._follower.anchor.ids[found], uv[found]
        if len(ids) < FEWEST:
            return None
        xy = self._flat(uv)
        placed = self._placed(T, ids, xy, FINELY if halvings < SEARCH_HALVINGS else SCALES)
        # until depths are known, what no turn explains is as likely near as an outlier
        kept = placed.agree if self.known else np.ones(len(ids), bool)
        fewest = FEWEST if self.known else max(FEWEST, FEWEST_SHARE * len(found))
        return _Sight(placed, ids, uv, xy, kept) if kept.sum() >= fewest else None

    def _by_whole_shift(self) -> tuple[Array, Array]:
        """T (4, 4) and where the anchor's points are (K, 2), had the camera only turned since."""
        anchor = self._follower.anchor
        assert anchor is not None
        shift = self._follower.shift_from(anchor)
        view = next(view for view in reversed(self._map.views) if view.frame <= self._picked)
        turn = exp_rotation([-shift[1] / self.camera.fy, shift[0] / self.camera.fx, 0.0])
        return transform(turn @ view.T[:3, :3], turn @ view.T[:3, 3]), anchor.uv + shift

    def _go_on(self, sight: _Sight, usable: Mask | None) -> None:
        """Take the latest picture's place, and make it a view where one is due."""
        assert self._follower.anchor is not None
        frame, kept, placed = len(self._Ts), sight.kept, sight.placed
        self._lost = 0
        self._note(placed.T, "", self._px(placed.error))
        self._waiting.append(_Frame(frame, sight.ids, sight.xy, not self.known))
        few = kept.sum() < LEAST_SHARE * len(self._follower.anchor.ids)
        if few or frame - self._picked >= LONGEST:
            self._add_view(usable, sight.ids[kept], sight.uv[kept])
        elif frame - self._map.views[-1].frame >= BETWEEN:
            self._map.add(View(frame, placed.T, sight.ids[kept], sight.xy[kept]))
        if not self.known and frame % EVERY == 0:
            self._watch(View(frame, placed.T, sight.ids, sight.xy))

    def _note(self, T: Array, cause: Cause, error_px: float) -> None:
        self._Ts.append(T)
        self.causes.append(cause)
        self.errors_px.append(error_px)

    def _px(self, deviations: float) -> float:
        """Pixels of the film of so many standard deviations."""
        return deviations * self._map.noise * self.camera.fx

    def _lose(self, usable: Mask | None) -> None:
        """Let the latest picture have no place; pick anew where that lasts, if points of old that
        are in view again tie the new ones to them.
        """
        self._note(self._Ts[-1], _cause(usable), np.nan)
        self._lost += 1
        if self._lost > LOST_FRAMES and self._follower.could_pick(usable, FEWEST):
            back, uv = self._returned(np.zeros(0, np.int64), usable)
            self.ended = not len(back)
            if len(back):
                self._Ts[-1] = self._placed(self._Ts[-1], back, self._flat(uv)).T
                self._add_view(usable, back, uv)
                self._lost = 0

    def _expected(self, T: Array, ids: Indices, rough: Array, followed: NDArray[np.bool_]) -> Array:
        """Where points are (K, 2), the camera at about T (4, 4): once depths are known, from where
        they were in the frame before, as far on as the camera went.
        """
        shown = self._pixels(self._map.expected(T, ids))
        if self.known and len(self._last[0]) == len(ids):
            before = self._pixels(self._map.expected(self._Ts[-1], ids))
            on = self._last[0] + shown - before
            shown = np.where(self._last[1][:, None], on, shown)
        elif not self.known:
            shown = np.where(followed[:, None], rough, shown)
        return np.where(np.isfinite(shown), shown, rough)

    def finished(self) -> Array:
        """Ts_camera_world (N, 4, 4) of all frames, in units of the usual depth where the camera
        began to move; no frame's place is other than the first's unless `known`.
        """
        if not self.known:
            self._start(LEAST_START_PX)
        return self._in_whole() if self.known else np.stack(self._Ts)

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
        self, start: Array, ids: Indices, xy: Array, scales: tuple[float, ...] = SCALES
    ) -> Resected:
        """Of points (K,) seen at xy (K, 2) the camera's place, and which agree with it (K,)."""
        sound = self._map.sound[ids]
        seen_points = self._map.seen(ids[sound], xy[sound])
        found = resected(start, seen_points, self._map.noise, STEP, scales)
        agree = np.zeros(len(ids), bool)
        agree[sound] = found.agree
        return Resected(found.T, agree, found.error)

    def _add_view(self, usable: Mask | None, ids: Indices, uv: Array) -> None:
        """Make the latest picture a view with new points, and adjust the last ones."""
        known, self._picked = len(self._map.home), len(self._Ts) - 1
        first = self._follower.in_empty_cells(uv, np.zeros((0, 2)))
        ids, uv = ids[first], uv[first]
        anchor = self._follower.pick(usable, ids, uv)
        ids, uv = anchor.ids, anchor.uv
        self._last = (uv, np.ones(len(ids), bool))
        back, uv_back = self._returned(ids, usable)
        seen = np.concatenate([ids, back])
        at = np.concatenate([uv, uv_back])
        order = np.argsort(seen)
        self._map.add(View(len(self._Ts) - 1, self._Ts[-1], seen[order], self._flat(at[order])))
        self._homes.keep(ids[ids >= known], uv[ids >= known])
        if self.known:
            self._map.adjust_last()
            self._Ts[-1] = self._map.views[-1].T
            self._settle(len(self._map.views) - FREE)
        else:
            self._settle(len(self._map.views) - WAITING)

    def _returned(self, ids: Indices, usable: Mask | None) -> tuple[Indices, Array]:
        """Points of old that are in view again, beside those of the latest picture."""
        none = np.zeros(0, np.int64), np.zeros((0, 2))
        if not self.known:
            return none
        back, uv = self._homes.returned(self._Ts[-1], ids, usable)
        if len(back) < FEWEST:
            return none
        agree = self._placed(self._Ts[-1], back, self._flat(uv)).agree
        return (back[agree], uv[agree]) if agree.sum() >= FEWEST else none

    def _watch(self, now: View) -> None:
        """See whether the camera moved since an earlier view, and start as soon as it is plain."""
        for view in self._recent()[:2]:
            _, one, other = np.intersect1d(view.ids, now.ids, return_indices=True)
            if view.frame < now.frame and len(one) >= SHARED * len(now.ids):
                px = parallax(view.xy[one], now.xy[other], self._map.noise) * NOISE_PX
                if self._widest is None or px > self._widest.px:
                    self._widest = _Pair(px, view, now)
        patient = now.frame >= PATIENCE and now.frame % RETRY < EVERY
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
                view.T = self._placed(view.T, view.ids, view.xy).T
        self._map.adjust_all()
        last = self._waiting[-1]
        self._Ts[-1] = self._placed(self._map.views[-1].T, last.ids, last.xy).T

    def _settle(self, count: int) -> None:
        """Find once more where the frames before the view of this number were."""
        if count <= 0:
            return
        until = self._map.views[min(count, len(self._map.views) - 1)].frame
        done = [waiting for waiting in self._waiting if waiting.frame < until]
        self._waiting = [waiting for waiting in self._waiting if waiting.frame >= until]
        self._settle_frames(done)

    def _settle_frames(self, frames: list[_Frame]) -> None:
        views = {view.frame: view.T for view in self._map.views}
        for frame in frames:
            start, scales = self._Ts[frame.frame], STARTING if frame.turned else SETTLING
            if frame.frame in views:
                start, scales = views[frame.frame], STAYING
            if self.known:
                placed = self._placed(start, frame.ids, frame.xy, scales)
                start, self.errors_px[frame.frame] = placed.T, self._px(placed.error)
            self._Ts[frame.frame] = start


def _cause(usable: Mask | None) -> Cause:
    return "body_fills" if usable is not None and usable.mean() < OPEN_SHARE else "no_texture"
