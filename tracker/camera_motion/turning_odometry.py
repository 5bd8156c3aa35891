"""Visual odometry of a camera that turns: each frame is measured from its keyframe.

A keyframe is an earlier frame in which points were picked; nothing adds up between the frames that
are measured from one. A new one is set where too little of the old is in view. Where the camera is
lost, the last keyframe and the last ones of scenes left before are tried again, with the picture
shifted as a whole; after some frames a new keyframe is set that is tied to nothing. Memory grows by
what is said of a frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.direction_map import SYSTEMATIC_PX, DirectionMap
from keypose.tracker.camera_motion.findings import LOST_FRAMES, Likeness, is_filled
from keypose.tracker.camera_motion.focal import LEAST_DISPLACEMENT, MOST_PAIRS, Pair
from keypose.tracker.camera_motion.lens import Lens, unit
from keypose.tracker.camera_motion.measurements import Cause, Measured
from keypose.tracker.camera_motion.points import Grey, KeyframePicture, Mask, PointFollower
from keypose.tracker.camera_motion.shutter import Shutter
from keypose.tracker.camera_motion.steadiness import Steadiness, Summary
from keypose.tracker.camera_motion.turn import (
    SCALES_PX,
    SeenDirections,
    Shear,
    Solved,
    Turn,
    solve_turn,
)
from keypose.tracker.geometry.rotations import Array

FEWEST_POINTS = 12
"""Points without which a keyframe is not set: there is no texture."""
ROUGH_POINTS = 100
"""Points that are followed from the frame before, for a start."""
FEWEST_AGREE = 8
"""Points that must agree on a turn: twice its unknowns."""
SHARE_AGREE = 0.2
"""Share that must agree of the points that could be seen."""
MOST_DOUBT = np.radians(0.2)
"""Standard deviation of the turn above which it is not known."""
CUT_LIKENESS = 0.5
"""Correlation of a picture with the one before, below which the film was cut there."""
SAME_LIKENESS = 0.7
"""Correlation above which they show one scene."""
TRACKED_SHARE = 0.6
"""A new keyframe is due where this share is left of the most points tracked so far."""
DISPLACED_SHARE = 0.22
"""Or where the picture was displaced by this share of its width."""
ROLL = np.radians(8.0)
"""Or where it rolled so far that windows no longer look alike."""
ZOOM = 0.14
"""Logarithm of the zoom at which they do not either."""
SOONEST = 4
"""Frames from a keyframe to the next, where points merely become fewer."""
SCARCE = 20
"""Points: with fewer a keyframe may follow at once."""
TRUST_NEW = 0.5
"""Trust in a point that was just picked; 1 is in one that always moved as most do."""
TRUST_RATE = 0.1
"""Share of the way by which trust follows whether a point agrees in a frame."""
TRUSTED = 0.6
"""Trust above which a point is kept as a landmark."""
LEAST_CHANGE_PX = 1.5
"""Pixels a frame by which the speed must differ from the keyframe's for the shutter to show."""
FARTHER = 1.2
"""Times the way of the pair kept so far, by which another one must have gone to replace it."""
SCENES = 3
"""Left scenes whose last keyframes are tried again where the camera is lost."""


@dataclass(eq=False)
class _Keyframe:
    """A keyframe to measure from: its number, points, their directions (K, 3) in its camera's
    frame and their trust (K,); how fast the camera turned then (3,), radians a frame, None where
    that is still to be seen, and what a readout shifted the points by (K, 2, 2); and how many
    points at most were tracked since.
    """

    number: int
    picture: KeyframePicture
    directions: Array
    trust: Array
    steady: Steadiness
    rate: Array | None
    shifts: Array
    most_tracked: int = 0


class TurningOdometry:
    """Takes the frames of a film in order.

    map: the keyframes and landmarks.  summaries: what the points of each keyframe said.  cuts:
    frames at which the picture changed wholly.  untied: keyframes that are tied to nothing before
    them.  pairs: of pictures that show the focal length.
    """

    def __init__(self, lens: Lens) -> None:
        self.lens = lens
        self._points = PointFollower(lens.camera.width, lens.camera.height)
        self.summaries: list[Summary] = []
        self.cuts: list[int] = []
        self.untied: list[int] = []
        self.pairs: list[Pair] = []
        self._ties: list[tuple[int, Array, Array]] = []
        self.shutter = Shutter((lens.camera.width, lens.camera.height))
        self.map = DirectionMap(lens, self._points, self.shutter)
        self._rate = np.zeros(3)
        self._keyframe: _Keyframe | None = None
        self._pair: Pair | None = None
        self._left: list[_Keyframe] = []
        self._turn, self._step = Turn.none(), Turn.none()
        self._uv = np.zeros((0, 2))
        self._alike = 1.0
        self._lost, self._cut = 0, -1
        self._frame = 0
        self._usable: Mask | None = None
        self._likeness = Likeness()

    def advance(self, frame: int, picture: Grey | None, usable: Mask | None) -> Measured:
        """Measure the next frame.

        Args:
            frame: its number.
            picture: (H, W) of it; None where it cannot be read.
            usable: (H, W) pixels that may be background; None for all.
        """
        self._frame, self._usable = frame, usable
        if picture is None:
            self._lost += 1
            return self._unknown("no_picture")
        rough, followed = self._points.look(picture, ROUGH_POINTS)
        like = self._likeness.of(self._points.now)
        if self._keyframe is None:
            return self._begin()
        tracked, solved = self._measure(rough, followed)
        if solved is None or not self._holds(solved, tracked):
            return self._find_again(like)
        return self._accept(tracked, solved)

    def finish(self) -> None:
        """Take up what the last keyframe's points said, and what became known of the shutter."""
        edges = self.map.edges
        for number, lever, readout in self._ties:
            turn = edges[number].turn.moved(lever @ (self.shutter.share - readout))
            edges[number] = replace(edges[number], turn=turn)
        if self._keyframe is not None:
            self._end_keyframe()
        else:
            self.map.add(0, Turn.none())

    @property
    def scale(self) -> float:
        """From pixels of the film to those looked at."""
        return self._points.scale

    # --- one frame ---

    @property
    def _current(self) -> _Keyframe:
        assert self._keyframe is not None
        return self._keyframe

    @property
    def _zoom(self) -> float:
        """Of the keyframe measured from."""
        return self.map.turns[self._current.number].zoom

    def _measure(
        self, rough: Array, followed: NDArray[np.bool_]
    ) -> tuple[NDArray[np.bool_], Solved | None]:
        """Which points (K,) were tracked, and the turn by them.

        rough (K, 2), followed (K,): where they were followed to from the picture before, and which.
        """
        starts = [self._turn.then(self._step), self._turn]
        first = self._solve(rough, followed, starts, SCALES_PX, None)
        sure = first is not None and first.agreeing >= max(FEWEST_AGREE, 0.5 * followed.sum())
        self._alike = first.agreeing / followed.sum() if first is not None else 1.0
        turn = starts[1] if first is None or first.agreeing < FEWEST_AGREE else first.turn
        self._uv, tracked = self._points.refine(
            self._expected(turn), self._usable, 0 if sure else 1
        )
        scales = SCALES_PX[-1:] if sure else SCALES_PX
        shear = self._shear(turn, tracked)
        return tracked, self._solve(self._uv, tracked, [turn, *starts], scales, shear)

    def _expected(self, turn: Turn) -> Array:
        """Where the keyframe's points are seen (K, 2) when it is turned so; far off when behind."""
        shear = self._shear(turn, np.ones(len(self._current.directions), bool))
        flat = turn.flat(self._current.directions) + shear.shifts @ shear.share
        uv = self.lens.pixels(unit(flat / turn.zoom), self._zoom * turn.zoom)
        return np.where(np.isfinite(uv), uv, -1e4)

    def _solve(
        self,
        uv: Array,
        tracked: NDArray[np.bool_],
        starts: list[Turn],
        scales: Sequence[float],
        shear: Shear | None,
    ) -> Solved | None:
        """The turn from the keyframe by its points.

        Args:
            uv: (K, 2) where the points are, pixels of the film.
            tracked: (K,) which of them count.
            starts: turns to begin with.
            scales: of the weights on the way, pixels looked at.
            shear: of the points that count.
        """
        keyframe, zoom = self._current, self._zoom
        points = SeenDirections(
            keyframe.directions[tracked],
            self.lens.flat(uv[tracked], zoom * starts[0].zoom) / zoom,
            self.map.focal_px * zoom,
            keyframe.trust[tracked],
        )
        return solve_turn(points, starts, scales, shear)

    def _holds(self, solved: Solved, tracked: NDArray[np.bool_]) -> bool:
        """Whether enough points agree, and the turn is sure."""
        visible = max(int(tracked.sum()), self._points.visible)
        if solved.agreeing < max(FEWEST_AGREE, SHARE_AGREE * visible):
            return False
        doubt = np.sqrt(np.trace(solved.covariance(0.0)[:3, :3]) / 3)
        return bool(doubt < MOST_DOUBT)

    def _accept(self, tracked: NDArray[np.bool_], solved: Solved) -> Measured:
        """Go on from the turn by the points that were tracked (K,), and set a keyframe where one is
        due."""
        keyframe = self._current
        followed = not self._lost
        self._rate = self._rate_at(solved.turn)
        self._step = self._turn.inverse().then(solved.turn) if followed else Turn.none()
        self._turn, self._lost, self._cut = solved.turn, 0, -1
        agrees = np.zeros(len(tracked), bool)
        agrees[tracked] = solved.agrees
        keyframe.trust[tracked] += TRUST_RATE * (solved.agrees - keyframe.trust[tracked])
        keyframe.steady.add(tracked, solved)
        readout = self.shutter.share
        if followed:
            self._learn_shutter(keyframe, solved)
        error = np.median(np.linalg.norm(solved.residual_px[solved.agrees], axis=1))
        measured = Measured(
            keyframe=keyframe.number,
            turn=solved.turn,
            known=True,
            cause="",
            covariance=solved.covariance(SYSTEMATIC_PX / self.map.focal_px / self._zoom),
            error_px=float(error) / self.scale,
            uv=self._uv[tracked].astype(np.float32),
            good=solved.agrees,
            share=max(self._alike, solved.agreeing / max(self._points.visible, 1)),
            lever=solved.lever if solved.lever.size else np.zeros((4, 2)),
            readout=readout,
        )
        displacement = self._displacement(tracked)
        if displacement > FARTHER * (self._pair.displacement if self._pair else LEAST_DISPLACEMENT):
            self._take_pair(tracked, solved, displacement)
        if self._is_due(tracked, solved.turn, displacement):
            self._advance_keyframe(agrees, measured)
        return measured

    def _unknown(self, cause: Cause) -> Measured:
        """What is said of a frame at which the camera is not known."""
        return Measured(
            keyframe=0 if self._keyframe is None else self._keyframe.number,
            turn=self._turn,
            known=False,
            cause=cause,
            covariance=np.eye(4),
            error_px=np.nan,
            uv=np.zeros((0, 2), np.float32),
            good=np.zeros(0, bool),
        )

    def _learn_shutter(self, keyframe: _Keyframe, solved: Solved) -> None:
        """Take what the frame says of the readout, or learn how fast the keyframe was turned."""
        if keyframe.rate is not None:
            change_px = np.linalg.norm(self._rate - keyframe.rate) * self.map.focal_px
            if change_px * self._zoom > LEAST_CHANGE_PX:
                self.shutter.learn(solved.pull, solved.pull_information)
            return
        keyframe.rate = self._step.rotation
        tangents = keyframe.directions[:, :2] / keyframe.directions[:, 2:]
        keyframe.shifts = self.shutter.shifts(keyframe.picture.uv, tangents, keyframe.rate)

    def _rate_at(self, turn: Turn) -> Array:
        """How fast the camera turns at this frame (3,), radians a frame: by half a step more than
        since the frame before.
        """
        if self._lost:
            return np.zeros(3)
        since = self._turn.inverse().then(turn).rotation
        return np.asarray(since + 0.5 * (since - self._step.rotation))

    def _shear(self, turn: Turn, tracked: NDArray[np.bool_]) -> Shear:
        """How a readout shifts the points tracked, against where it shifts them in the keyframe."""
        keyframe, shutter = self._current, self.shutter
        tangents = turn.flat(keyframe.directions[tracked]) / turn.zoom
        uv = self.lens.pixels(unit(tangents), self._zoom * turn.zoom)
        shifts = shutter.shifts(uv, tangents, self._rate_at(turn)) - keyframe.shifts[tracked]
        if keyframe.rate is None:  # as in this frame
            shifts = np.zeros_like(shifts)
        return Shear(np.nan_to_num(shifts * turn.zoom), shutter.share)

    # --- where the camera is lost ---

    def _begin(self) -> Measured:
        """Set the first keyframe, where there is something to follow."""
        if not self._points.could_pick(self._usable, FEWEST_POINTS):
            return self._unknown(self._poor())
        self._set_keyframe(Turn.none(), None)
        return self._at_keyframe(np.zeros((4, 4)))

    def _find_again(self, like: float) -> Measured:
        """Try the keyframes of scenes that were left; where none is seen, count as lost."""
        self._lost += 1
        self._step = Turn.none()
        current, turn = self._current, self._turn
        for keyframe in [current, *reversed(self._left)]:
            tracked, solved = self._try(keyframe, turn)
            if solved is not None and self._holds(solved, tracked):
                if keyframe is not current:
                    self.cuts = [*self.cuts, *([self._cut] if self._cut >= 0 else [])]
                    self._left = [*(s for s in self._left if s is not keyframe), current]
                return self._accept(tracked, solved)
        self._keyframe, self._turn = current, turn
        self._points.use(current.picture, self._expected(turn))
        return self._lose(like)

    def _try(self, keyframe: _Keyframe, turn: Turn) -> tuple[NDArray[np.bool_], Solved | None]:
        """Measure from a keyframe with its picture shifted as a whole."""
        self._keyframe = keyframe
        shift = self._points.shift_from(keyframe.picture)
        self._points.use(keyframe.picture, keyframe.picture.uv + shift)
        starts = [Turn.none(), turn]
        self._uv, tracked = self._points.refine(keyframe.picture.uv + shift, self._usable, 2)
        solved = self._solve(self._uv, tracked, starts, SCALES_PX, None)
        if solved is None or not self._holds(solved, tracked):
            return tracked, None
        self._uv, tracked = self._points.refine(self._expected(solved.turn), self._usable, 0)
        return tracked, self._solve(self._uv, tracked, [solved.turn], SCALES_PX[-1:], None)

    def _lose(self, like: float) -> Measured:
        """Say why the camera is lost, and set a keyframe tied to nothing where that lasts, or where
        the film has settled after a cut. like: the picture to the one before, a correlation."""
        cause: Cause = "body_fills" if self._is_filled else "not_rigid"
        if like < CUT_LIKENESS and self._cut < 0 and not self._is_filled:
            self._cut, cause = self._frame, "cut"
        settled = 0 <= self._cut < self._frame and like > SAME_LIKENESS
        if not settled and self._lost < LOST_FRAMES:
            return self._unknown(cause)
        if not self._points.could_pick(self._usable, FEWEST_POINTS):
            return self._unknown(self._poor())
        if settled:
            self.cuts.append(self._cut)
        self._left = [*self._left, self._current][-SCENES:]
        keyframe, turn = self._current, self._turn
        self.map.follow_untied(keyframe.number, turn)
        world = self.map.turns[keyframe.number].then(turn)
        self.untied.append(len(self.map.turns))
        self._set_keyframe(world, None)
        return self._at_keyframe(np.eye(4))

    def _poor(self) -> Cause:
        """Why nothing can be picked."""
        return "body_fills" if self._is_filled else "no_texture"

    @property
    def _is_filled(self) -> bool:
        """Whether what is not background leaves too little of the latest picture."""
        return is_filled(self._usable)

    def _at_keyframe(self, doubt: Array) -> Measured:
        """What is said of a frame that became a keyframe tied to nothing."""
        return Measured(
            keyframe=self._current.number,
            turn=Turn.none(),
            known=True,
            cause="",
            covariance=doubt,
            error_px=0.0,
            uv=self._uv.astype(np.float32),
            good=np.ones(len(self._uv), bool),
        )

    # --- keyframes ---

    def _displacement(self, tracked: NDArray[np.bool_]) -> float:
        """How far the picture went since the keyframe, as a share of its width."""
        ways = self._uv[tracked] - self._current.picture.uv[tracked]
        return float(np.linalg.norm(np.median(ways, axis=0)) / self.lens.camera.width)

    def _take_pair(self, tracked: NDArray[np.bool_], solved: Solved, displacement: float) -> None:
        """Keep the keyframe and this frame, so far the farthest from it, for the focal length."""
        zooms = self._zoom, self._zoom * solved.turn.zoom
        keyframe, straight = self._current, self.shutter.straightened
        rate = np.zeros(3) if keyframe.rate is None else keyframe.rate
        uv = straight(self.lens, keyframe.picture.uv[tracked], zooms[0], rate)
        uv_later = straight(self.lens, self._uv[tracked], zooms[1], self._rate)
        self._pair = Pair(uv, uv_later, zooms, displacement)

    def _end_keyframe(self) -> None:
        """Take up what the points of the keyframe measured from said."""
        self.summaries.append(self._current.steady.summary())
        if self._pair is not None:
            pairs = sorted([*self.pairs, self._pair], key=lambda pair: -pair.displacement)
            self.pairs = pairs[:MOST_PAIRS]
        self._pair = None

    def _is_due(self, tracked: NDArray[np.bool_], turn: Turn, displacement: float) -> bool:
        """Whether a new keyframe is, of the points tracked (K,), the turn from the last one, and
        how far the picture went, as a share of its width."""
        roll = abs(np.arctan2(turn.R[1, 0], turn.R[0, 0]))
        if displacement > DISPLACED_SHARE or roll > ROLL or abs(np.log(turn.zoom)) > ZOOM:
            return True
        keyframe = self._current
        keyframe.most_tracked = max(keyframe.most_tracked, int(tracked.sum()))
        few = tracked.sum() < TRACKED_SHARE * keyframe.most_tracked
        late = self._frame - self.map.frames[-1] >= SOONEST or tracked.sum() < SCARCE
        return bool(few and late)

    def _advance_keyframe(self, agrees: NDArray[np.bool_], measured: Measured) -> None:
        """Set a keyframe where the camera is known, with the points that agree (K,), tied to the
        last and to what came back."""
        keyframe, directions = self._current, self.map
        rate = np.zeros(3) if keyframe.rate is None else keyframe.rate
        directions.keep(keyframe.picture, keyframe.number, rate, keyframe.trust > TRUSTED)
        turn = directions.turns[keyframe.number].then(measured.turn)
        self._ties.append((len(directions.edges), measured.lever, measured.readout))
        directions.tie(keyframe.number, measured.turn, measured.covariance)
        ids, uv, trust = keyframe.picture.ids[agrees], self._uv[agrees], keyframe.trust[agrees]
        turn, back, back_uv = directions.close_loops(turn, self._rate, self._usable)
        again = np.isin(back, ids)
        place = {number: k for k, number in enumerate(ids.tolist())}
        for number, there in zip(back[again].tolist(), back_uv[again], strict=True):
            uv[place[number]] = there
        fresh = ~again & self._points.in_empty_cells(back_uv, uv)
        ids, uv = np.concatenate([ids, back[fresh]]), np.concatenate([uv, back_uv[fresh]])
        trust = np.concatenate([trust, np.ones(fresh.sum())])
        self._set_keyframe(turn, (ids, uv, trust))

    def _set_keyframe(
        self, turn: Turn, points: tuple[NDArray[np.int64], Array, Array] | None
    ) -> None:
        """Set a keyframe at the latest picture, the camera turned so from the world.

        points: ids (K,), places (K, 2) and trust (K,) of those that are known in it; None where it
        is tied to nothing.
        """
        if self._keyframe is not None:
            self._end_keyframe()
        ids, uv, trust = points or (np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros(0))
        picture = self._points.pick(self._usable, ids, uv)
        self._uv = picture.uv
        trust = np.concatenate([trust, np.full(len(picture.ids) - len(trust), TRUST_NEW)])
        directions = self.lens.directions(picture.uv, turn.zoom)
        number = len(self.map.turns)
        rate = None if points is None else self._rate
        tangents = directions[:, :2] / directions[:, 2:]
        shifts = self.shutter.shifts(picture.uv, tangents, np.zeros(3) if rate is None else rate)
        steady = Steadiness(len(trust))
        self._keyframe = _Keyframe(number, picture, directions, trust, steady, rate, shifts)
        self.map.add(self._frame, turn)
        self._turn, self._lost, self._cut = Turn.none(), 0, -1
        if points is None:
            self._step = Turn.none()
