"""Visual odometry of a camera that moves: each frame is found by the landmarks in it (resection).

Until the camera is seen to move it is turned only. Then the two pictures with the widest parallax
give the motion between them and the depths of landmarks; frames before are found anew. Some frames
become keyframes, adjusted together, and all are found once more when landmarks are known better.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.bundle import Indices
from keypose.tracker.camera_motion.findings import LOST_FRAMES, is_filled
from keypose.tracker.camera_motion.focal import FocalScale, focal_of_map
from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.path import poses_through
from keypose.tracker.camera_motion.point_map import FREE, Keyframe, PointMap
from keypose.tracker.camera_motion.points import Grey, Mask, PointFollower
from keypose.tracker.camera_motion.resection import SCALES, Resected, resected
from keypose.tracker.camera_motion.two_views import parallax, two_views
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation, transform

Cause: TypeAlias = Literal["", "no_texture", "body_fills", "no_picture"]
"""Why a frame has no pose of its own; nothing where it has."""

NOISE_PX = 0.25
"""Standard deviation of where a point is seen, pixels of the picture looked at."""
FEWEST = 15
"""Points that a pose is believed from."""
FEWEST_SHARE = 0.3
"""Of the keyframe's points, until depths are known: noise too lets some be tracked."""
LEAST_SHARE = 0.7
"""New points are picked where this share of the keyframe's is left."""
LONGEST = 25
"""Or after so many frames."""
BETWEEN = 13
"""Frames from a keyframe to the next, with new points or not."""
STEP = 0.1
"""Standard deviation of a frame's step, in usual depths."""
START_PX = 12.0
"""Parallax with which the camera is seen to move, pixels of the picture looked at."""
LEAST_START_PX = 2.0
"""Parallax that will do once it has been waited for."""
PATIENCE = 60
"""Frames after which the least parallax will do."""
RETRY = 15
"""Frames from one try with the least parallax to the next."""
EVERY = 3
"""Frames after which it is asked whether the camera moves."""
SEARCH_HALVINGS = 3
"""By which the picture is made smaller where points are looked for after the camera was lost."""
SHARED = 0.4
"""Share of the points that two keyframes must both see to tell how the camera moved."""
WAITING = 60
"""Keyframes before the camera moves whose pose is found once it does."""
ASKED = 80
"""Points that are followed from the picture before once depths are known: then these tell where
the others are to be expected."""

# scales of the noise, from step to step of a resection
ROUGHLY = (12.0, 4.0)
"""By points followed roughly from the frame before."""
FINELY = (3.0, 1.0, 1.0)
"""Then by where they are."""
SETTLING: tuple[float, ...] = (1.0, 1.0, 1.0)
"""Once more, when depths are better known."""
STARTING: tuple[float, ...] = (4.0, 2.0, 1.0, 1.0, 1.0)
"""For the first time, of a frame before depths were known."""
STAYING: tuple[float, ...] = ()
"""Not at all: a keyframe's pose is adjusted already."""


@dataclass(eq=False)
class _Frame:
    """A frame that waits for its last pose: points tracked (K,), (K, 2).

    turned: whether it has been turned only, no depth known.
    """

    frame: int
    ids: Indices
    xy: Array
    turned: bool


@dataclass(frozen=True, eq=False)
class _Sight:
    """Points tracked in a picture: ids (K,), uv and xy (K, 2), which count (K,), and its pose."""

    resected: Resected
    ids: Indices
    uv: Array
    xy: Array
    kept: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Pair:
    """A keyframe and a later picture, and the parallax between them, pixels looked at."""

    px: float
    first: Keyframe
    second: Keyframe


@dataclass(eq=False)
class MovingOdometry:
    """A camera's poses up to the latest picture.

    has_depths: whether these are known; until then the camera is turned only.  causes: why a frame
    has no pose of its own, nothing where it has.  errors_px: median residual of the points that
    agree, pixels of the film, NaN without.  ended: whether the latest picture shows a scene that
    nothing ties to those before: take it with another odometry.
    """

    camera: Camera
    causes: list[Cause] = field(default_factory=list, init=False)
    errors_px: list[float] = field(default_factory=list, init=False)
    ended: bool = field(default=False, init=False)
    _follower: PointFollower = field(init=False)
    _map: PointMap = field(init=False)
    _Ts: list[Array] = field(default_factory=list, init=False)
    _waiting: list[_Frame] = field(default_factory=list, init=False)
    _widest: _Pair | None = field(default=None, init=False)
    _picked: int = field(default=0, init=False)
    _last: tuple[Array, NDArray[np.bool_]] = field(init=False)
    _lost: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self.camera = Lens.of(self.camera).camera
        self._follower = PointFollower(self.camera.width, self.camera.height)
        noise = NOISE_PX / self._follower.scale / self.camera.fx
        self._map = PointMap(self.camera, self._follower, noise)
        self._last = np.zeros((0, 2)), np.zeros(0, bool)

    @property
    def has_depths(self) -> bool:
        return self._map.has_depths

    def take(self, picture: Grey | None, usable: Mask | None) -> None:
        """Find the camera's pose in the next picture; None is one that cannot be read.

        usable: of its pixels (H, W), those that may be background.
        """
        T = self._Ts[-1] if self._Ts else np.eye(4)
        if picture is None:
            self._note(T, "no_picture", np.nan)
            return
        rough, followed = self._follower.look(picture, ASKED if self.has_depths else None)
        if self._follower.keyframe is None:
            self._note(T, "", 0.0)
            self._add_keyframe(usable, np.zeros(0, np.int64), np.zeros((0, 2)))
            if not len(self._map.anchor):
                self.causes[-1] = _cause(usable)
            return
        self._find(rough, followed, usable)

    def focal(self) -> FocalScale | None:
        """The focal length by the map, after the path is finished."""
        return focal_of_map(self._map)

    def drop_last(self) -> None:
        """Forget the latest picture."""
        for kept in (self._Ts, self.causes, self.errors_px):
            kept.pop()

    # --- one frame

    def _find(self, rough: Array, followed: NDArray[np.bool_], usable: Mask | None) -> None:
        """Find the latest picture's pose by the points of the keyframe."""
        assert self._follower.keyframe is not None
        ids, T = self._follower.keyframe.ids, self._Ts[-1]
        if followed.sum() >= FEWEST:
            T = self._resected(T, ids[followed], self._flat(rough[followed]), ROUGHLY).T
        expected = self._expected(T, ids, rough, followed)
        sight = self._sight(T, expected, usable, halvings=0 if self.has_depths else 1)
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
        """What the latest picture shows of the keyframe's points; None where that is too little.

        Args:
            T: (4, 4) about where the camera is.
            expected: (K, 2) where the points are expected, pixels of the film.
            usable: (H, W) pixels that may be background; None for all.
            halvings: of the picture, one more for twice as far from where they are expected.
        """
        assert self._follower.keyframe is not None
        uv, tracked = self._follower.refine(expected, usable, halvings)
        self._last = (uv, tracked)
        ids, uv = self._follower.keyframe.ids[tracked], uv[tracked]
        if len(ids) < FEWEST:
            return None
        xy = self._flat(uv)
        by_points = self._resected(T, ids, xy, FINELY if halvings < SEARCH_HALVINGS else SCALES)
        # until depths are known, what no turn explains is as likely near as an outlier
        kept = by_points.agree if self.has_depths else np.ones(len(ids), bool)
        fewest = FEWEST if self.has_depths else max(FEWEST, FEWEST_SHARE * len(tracked))
        return _Sight(by_points, ids, uv, xy, kept) if kept.sum() >= fewest else None

    def _by_whole_shift(self) -> tuple[Array, Array]:
        """T (4, 4) and where the keyframe's points are (K, 2), had the camera only turned since."""
        picture = self._follower.keyframe
        assert picture is not None
        shift = self._follower.shift_from(picture)
        before = next(k for k in reversed(self._map.keyframes) if k.frame <= self._picked)
        turn = exp_rotation([-shift[1] / self.camera.fy, shift[0] / self.camera.fx, 0.0])
        return transform(turn @ before.T[:3, :3], turn @ before.T[:3, 3]), picture.uv + shift

    def _go_on(self, sight: _Sight, usable: Mask | None) -> None:
        """Take the latest picture's pose, and make it a keyframe where one is due."""
        assert self._follower.keyframe is not None
        frame, kept, T = len(self._Ts), sight.kept, sight.resected.T
        self._lost = 0
        self._note(T, "", self._px(sight.resected.error))
        self._waiting.append(_Frame(frame, sight.ids, sight.xy, not self.has_depths))
        few = kept.sum() < LEAST_SHARE * len(self._follower.keyframe.ids)
        if few or frame - self._picked >= LONGEST:
            self._add_keyframe(usable, sight.ids[kept], sight.uv[kept])
        elif frame - self._map.keyframes[-1].frame >= BETWEEN:
            self._map.add(Keyframe(frame, T, sight.ids[kept], sight.xy[kept]))
        if not self.has_depths and frame % EVERY == 0:
            self._watch(Keyframe(frame, T, sight.ids, sight.xy))

    def _note(self, T: Array, cause: Cause, error_px: float) -> None:
        self._Ts.append(T)
        self.causes.append(cause)
        self.errors_px.append(error_px)

    def _px(self, deviations: float) -> float:
        """Pixels of the film of so many standard deviations."""
        return deviations * self._map.noise * self.camera.fx

    def _lose(self, usable: Mask | None) -> None:
        """Let the latest picture have no pose; pick anew where that lasts, if points of old that
        are in view again tie the new ones to them.
        """
        self._note(self._Ts[-1], _cause(usable), np.nan)
        self._lost += 1
        if self._lost > LOST_FRAMES and self._follower.could_pick(usable, FEWEST):
            back, uv = self._returned(np.zeros(0, np.int64), usable)
            self.ended = not len(back)
            if len(back):
                self._Ts[-1] = self._resected(self._Ts[-1], back, self._flat(uv)).T
                self._add_keyframe(usable, back, uv)
                self._lost = 0

    def _expected(self, T: Array, ids: Indices, rough: Array, followed: NDArray[np.bool_]) -> Array:
        """Where points are in the latest picture (K, 2), pixels of the film: once depths are known,
        from where they were in the frame before, as far on as the camera went.

        Args:
            T: (4, 4) about where the camera is.
            ids: (K,) of the points.
            rough: (K, 2) where they were followed to from the picture before.
            followed: (K,) which were.
        """
        shown = self._pixels(self._map.expected(T, ids))
        if self.has_depths and len(self._last[0]) == len(ids):
            before = self._pixels(self._map.expected(self._Ts[-1], ids))
            on = self._last[0] + shown - before
            shown = np.where(self._last[1][:, None], on, shown)
        elif not self.has_depths:
            shown = np.where(followed[:, None], rough, shown)
        return np.where(np.isfinite(shown), shown, rough)

    def _flat(self, uv: Array) -> Array:
        """x/z and y/z (K, 2) of pixels of the film."""
        return self.camera.back_project(uv, 1.0)[..., :2]

    def _pixels(self, xy: Array) -> Array:
        """Pixels of the film (K, 2) of x/z and y/z."""
        return self.camera.project(np.concatenate([xy, np.ones((len(xy), 1))], axis=1))

    def _resected(
        self, start: Array, ids: Indices, xy: Array, scales: tuple[float, ...] = SCALES
    ) -> Resected:
        """The camera's pose by points, and which of them agree with it (K,).

        Args:
            start: (4, 4) about where the camera is.
            ids: (K,) of the points.
            xy: (K, 2) where they are seen, as x/z and y/z.
            scales: of the noise, from step to step.
        """
        sound = self._map.sound[ids]
        observed = self._map.observed(ids[sound], xy[sound])
        by_sound = resected(start, observed, self._map.noise, STEP, scales)
        agree = np.zeros(len(ids), bool)
        agree[sound] = by_sound.agree
        return Resected(by_sound.T, agree, by_sound.error)

    # --- keyframes

    def _add_keyframe(self, usable: Mask | None, ids: Indices, uv: Array) -> None:
        """Make the latest picture a keyframe with new points, and adjust the last ones."""
        count, self._picked = len(self._map.anchor), len(self._Ts) - 1
        first = self._follower.in_empty_cells(uv, np.zeros((0, 2)))
        ids, uv = ids[first], uv[first]
        picture = self._follower.pick(usable, ids, uv)
        ids, uv = picture.ids, picture.uv
        self._last = (uv, np.ones(len(ids), bool))
        back, uv_back = self._returned(ids, usable)
        present = np.concatenate([ids, back])
        at = np.concatenate([uv, uv_back])
        order = np.argsort(present)
        frame, T = len(self._Ts) - 1, self._Ts[-1]
        self._map.add(Keyframe(frame, T, present[order], self._flat(at[order])))
        self._map.keep(ids[ids >= count], uv[ids >= count])
        if self.has_depths:
            self._map.adjust_last()
            self._Ts[-1] = self._map.keyframes[-1].T
            self._settle(len(self._map.keyframes) - FREE)
        else:
            self._settle(len(self._map.keyframes) - WAITING)

    def _returned(self, ids: Indices, usable: Mask | None) -> tuple[Indices, Array]:
        """Points of old that are in view again, beside those of the latest picture."""
        none = np.zeros(0, np.int64), np.zeros((0, 2))
        if not self.has_depths:
            return none
        back, uv = self._map.returned(self._Ts[-1], ids, usable)
        if len(back) < FEWEST:
            return none
        agree = self._resected(self._Ts[-1], back, self._flat(uv)).agree
        return (back[agree], uv[agree]) if agree.sum() >= FEWEST else none

    # --- the start: two pictures with parallax

    def _watch(self, now: Keyframe) -> None:
        """See whether the camera moved since an earlier keyframe, and start as soon as it is
        plain."""
        for before in self._recent()[:2]:
            _, i, j = np.intersect1d(before.ids, now.ids, return_indices=True)
            if before.frame < now.frame and len(i) >= SHARED * len(now.ids):
                px = parallax(before.xy[i], now.xy[j], self._map.noise) * NOISE_PX
                if self._widest is None or px > self._widest.px:
                    self._widest = _Pair(px, before, now)
        patient = now.frame >= PATIENCE and now.frame % RETRY < EVERY
        self._start(LEAST_START_PX if patient else START_PX)

    def _recent(self) -> list[Keyframe]:
        """Keyframes of which the latest still sees enough, the earliest first."""
        last, waiting = self._map.keyframes[-1], self._map.keyframes[-WAITING:]
        least = SHARED * len(last.ids)
        return [k for k in waiting if np.isin(k.ids, last.ids).sum() >= least]

    def _start(self, least_px: float) -> None:
        """See whether the two pictures with the widest parallax tell how the camera moved, and how
        far all points are.
        """
        pair = self._widest
        if pair is None or pair.px < least_px:
            return
        self._widest = None
        first, second = pair.first, pair.second
        ids, i, j = np.intersect1d(first.ids, second.ids, return_indices=True)
        motion = two_views(first.xy[i], second.xy[j], self._map.noise)
        if motion is None:
            return
        if all(keyframe.frame != second.frame for keyframe in self._map.keyframes):
            self._map.insert(second)
        second = next(k for k in self._map.keyframes if k.frame == second.frame)
        self._map.begin(first, second, ids, motion)
        for keyframe in self._map.keyframes[-WAITING:]:
            is_new = keyframe is not first and keyframe is not second
            if is_new and len(keyframe.ids) >= FEWEST:
                keyframe.T = self._resected(keyframe.T, keyframe.ids, keyframe.xy).T
        self._map.adjust_all()
        last = self._waiting[-1]
        self._Ts[-1] = self._resected(self._map.keyframes[-1].T, last.ids, last.xy).T

    # --- the end: all frames once more

    def finished(self) -> Array:
        """Ts_camera_world (N, 4, 4) of all frames, in units of the usual depth where the camera
        began to move; no frame is elsewhere than the first unless `has_depths`.
        """
        if not self.has_depths:
            self._start(LEAST_START_PX)
        return self._in_whole() if self.has_depths else np.stack(self._Ts)

    def _in_whole(self) -> Array:
        """All frames' (N, 4, 4), after all keyframes are adjusted together."""
        frames = [keyframe.frame for keyframe in self._map.keyframes]
        for keyframe in self._map.keyframes:
            self._Ts[keyframe.frame] = keyframe.T
        before = np.stack(self._Ts)
        self._map.adjust_all()
        adjusted = np.stack([keyframe.T for keyframe in self._map.keyframes])
        self._Ts = list(poses_through(before, frames, adjusted))
        self._settle_frames(self._waiting)
        return np.stack(self._Ts)

    def _settle(self, count: int) -> None:
        """Find once more the poses of the frames before the keyframe of this number."""
        if count <= 0:
            return
        until = self._map.keyframes[min(count, len(self._map.keyframes) - 1)].frame
        done = [waiting for waiting in self._waiting if waiting.frame < until]
        self._waiting = [waiting for waiting in self._waiting if waiting.frame >= until]
        self._settle_frames(done)

    def _settle_frames(self, frames: list[_Frame]) -> None:
        adjusted = {keyframe.frame: keyframe.T for keyframe in self._map.keyframes}
        for frame in frames:
            start, scales = self._Ts[frame.frame], STARTING if frame.turned else SETTLING
            if frame.frame in adjusted:
                start, scales = adjusted[frame.frame], STAYING
            if self.has_depths:
                settled = self._resected(start, frame.ids, frame.xy, scales)
                start, self.errors_px[frame.frame] = settled.T, self._px(settled.error)
            self._Ts[frame.frame] = start


def _cause(usable: Mask | None) -> Cause:
    return "body_fills" if is_filled(usable) else "no_texture"
