"""Measure a camera's turns through a film, one frame after another, from its anchors.

Every frame is measured from one anchor, an earlier frame in which points were picked, so nothing
adds up between them. A new anchor is set where too little of the old is in view. Where the camera
is lost, the last anchor and those of scenes left before are tried again, with the picture shifted
as a whole; after some frames a new anchor is set that is tied to nothing. Memory grows by what is
said of a frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.focal import LEAST_AWAY, MOST_PAIRS, Pair
from keypose.tracker.camera_motion.lens import Lens, unit
from keypose.tracker.camera_motion.points import Anchor, Grey, Mask, PointFollower
from keypose.tracker.camera_motion.shutter import Shutter
from keypose.tracker.camera_motion.steadiness import Steadiness, Summary
from keypose.tracker.camera_motion.territory import SYSTEMATIC_PX, Territory, covariance
from keypose.tracker.camera_motion.turn import SCALES_PX, Shear, Solved, Turn, solve_turn
from keypose.tracker.geometry.rotations import Array

Cause: TypeAlias = Literal["", "no_texture", "body_fills", "cut", "not_rigid", "no_picture"]
"""Why the camera is unknown at a frame; nothing where it is known."""

FEWEST_POINTS = 12
"""With fewer picked there is no texture."""
ROUGH_POINTS = 100
"""That are followed from the frame before."""
FEWEST_AGREE = 8
SHARE_AGREE = 0.2
"""Points that must agree, and their share of those that could be seen."""
MOST_DOUBT = np.radians(0.2)
"""Standard deviation of the turn above which it is not known."""
OPEN_SHARE = 0.3
"""Share of the picture that must be background."""
LOST_FRAMES = 4
"""After so many frames without the camera a new anchor is set, tied to nothing."""
CUT_LIKENESS = 0.5
SAME_LIKENESS = 0.7
"""Correlation of two pictures at a cut, and of two of one scene."""
SEEN_SHARE = 0.6
AWAY_SHARE = 0.22
"""A new anchor is due where this share of the points once found is left, or the picture went by
this share of its width."""
ROLL = np.radians(8.0)
ZOOM = 0.14
"""Or rolled, or zoomed, so far that windows no longer look alike."""
SOONEST = 4
SCARCE = 20
"""Frames from an anchor to the next, where points merely become fewer; not where they are less
than so many."""
TRUST_NEW = 0.5
TRUST_RATE = 0.1
TRUSTED = 0.6
LEAST_CHANGE_PX = 1.5
"""Of the speed since the anchor, a frame: with less nothing is said of the shutter."""
FARTHER = 1.2
"""By which the picture must have gone on for another pair to be kept."""
SCENES = 3
"""Left ones that are tried again where the camera is lost."""
LITTLE = (32, 18)
"""Size of the pictures whose likeness tells a cut."""


@dataclass(frozen=True, eq=False)
class Measured:
    """One frame, from its anchor.

    turn: from the anchor's camera; zoom as a quotient.  covariance (4, 4).  error_px: median of
    the agreeing points' residuals, NaN where unknown.  uv (K, 2) and good (K,): the points found.
    share: of the points followed from the frame before, or of those in view, those that moved
    alike, whichever is more.  lever (4, 2): how the turn and the
    logarithm of the zoom follow the readout, of which `readout` (2,) was used.
    """

    anchor: int
    turn: Turn
    known: bool
    cause: Cause
    covariance: Array
    error_px: float
    uv: NDArray[np.float32]
    good: NDArray[np.bool_]
    share: float = 1.0
    lever: Array = field(default_factory=lambda: np.zeros((4, 2)))
    readout: Array = field(default_factory=lambda: np.zeros(2))


@dataclass(eq=False)
class _Scene:
    """An anchor to measure from: its number, points, their directions (K, 3) in its camera's
    frame and their trust (K,); how fast the camera turned then (3,), radians a frame, None where
    that is still to be seen, and what a readout shifted the points by (K, 2, 2); and how many
    points at most were found since.
    """

    number: int
    anchor: Anchor
    directions: Array
    trust: Array
    steady: Steadiness
    rate: Array | None
    shifts: Array
    most_found: int = 0


class Odometer:
    """Takes the frames of a film in order.

    territory: the anchors.  summaries: what the points of each said.  cuts: frames at which the
    picture changed wholly.  loose: anchors that are tied to nothing before them.  pairs: of
    pictures that tell the focal length.
    """

    def __init__(self, lens: Lens) -> None:
        self.lens = lens
        self._points = PointFollower(lens.camera.width, lens.camera.height)
        self.summaries: list[Summary] = []
        self.cuts: list[int] = []
        self.loose: list[int] = []
        self.pairs: list[Pair] = []
        self._ties: list[tuple[int, Array, Array]] = []
        self.shutter = Shutter((lens.camera.width, lens.camera.height))
        self.territory = Territory(lens, self._points, self.shutter)
        self._rate = np.zeros(3)
        self._scene: _Scene | None = None
        self._pair: Pair | None = None
        self._left: list[_Scene] = []
        self._turn, self._step = Turn.none(), Turn.none()
        self._uv = np.zeros((0, 2))
        self._alike = 1.0
        self._lost, self._cut = 0, -1
        self._little: Array | None = None

    def advance(self, frame: int, picture: Grey | None, usable: Mask | None) -> Measured:
        """Measure the next frame; the picture is None where it cannot be read."""
        if picture is None:
            self._lost += 1
            return self._unknown("no_picture")
        rough, followed = self._points.look(picture, ROUGH_POINTS)
        like = self._likeness()
        if self._scene is None:
            return self._begin(frame, usable)
        found, solved = self._measure(rough, followed, usable)
        if solved is None or not self._holds(solved, found):
            return self._find_again(frame, usable, like)
        return self._gain(frame, usable, found, solved)

    def finish(self) -> None:
        """Take up what the last anchor's points said, and what became known of the shutter."""
        edges = self.territory.edges
        for number, lever, readout in self._ties:
            turn = edges[number].turn.moved(lever @ (self.shutter.share - readout))
            edges[number] = replace(edges[number], turn=turn)
        if self._scene is not None:
            self._end_anchor()
        else:
            self.territory.add(0, Turn.none())

    @property
    def scale(self) -> float:
        """From pixels of the film to those looked at."""
        return self._points.scale

    # --- one frame ---

    @property
    def _current(self) -> _Scene:
        assert self._scene is not None
        return self._scene

    @property
    def _zoom(self) -> float:
        """Of the anchor measured from."""
        return self.territory.turns[self._current.number].zoom

    def _measure(
        self, rough: Array, followed: NDArray[np.bool_], usable: Mask | None
    ) -> tuple[NDArray[np.bool_], Solved | None]:
        starts = [self._turn.then(self._step), self._turn]
        first = self._solve(rough, followed, starts, SCALES_PX, None)
        sure = first is not None and first.agreeing >= max(FEWEST_AGREE, 0.5 * followed.sum())
        self._alike = first.agreeing / followed.sum() if first is not None else 1.0
        turn = starts[1] if first is None or first.agreeing < FEWEST_AGREE else first.turn
        self._uv, found = self._points.refine(self._expected(turn), usable, 0 if sure else 1)
        scales = SCALES_PX[-1:] if sure else SCALES_PX
        shear = self._shear(turn, found)
        return found, self._solve(self._uv, found, [turn, *starts], scales, shear)

    def _expected(self, turn: Turn) -> Array:
        """Where the anchor's points are seen (K, 2) when it is turned so; far off when behind."""
        shear = self._shear(turn, np.ones(len(self._current.directions), bool))
        flat = turn.flat(self._current.directions) + shear.shifts @ shear.share
        uv = self.lens.pixels(unit(flat / turn.zoom), self._zoom * turn.zoom)
        return np.where(np.isfinite(uv), uv, -1e4)

    def _solve(
        self,
        uv: Array,
        found: NDArray[np.bool_],
        starts: list[Turn],
        scales: Sequence[float],
        shear: Shear | None,
    ) -> Solved | None:
        scene, zoom = self._current, self._zoom
        seen = self.lens.flat(uv[found], zoom * starts[0].zoom) / zoom
        return solve_turn(
            scene.directions[found],
            seen,
            self.territory.focal_px * zoom,
            scene.trust[found],
            starts,
            scales_px=scales,
            shear=shear,
        )

    def _holds(self, solved: Solved, found: NDArray[np.bool_]) -> bool:
        """Whether enough points agree, and tell the turn."""
        visible = max(int(found.sum()), self._points.visible)
        if solved.agreeing < max(FEWEST_AGREE, SHARE_AGREE * visible):
            return False
        doubt = np.sqrt(np.trace(covariance(solved, 0.0)[:3, :3]) / 3)
        return bool(doubt < MOST_DOUBT)

    def _gain(
        self, frame: int, usable: Mask | None, found: NDArray[np.bool_], solved: Solved
    ) -> Measured:
        scene = self._current
        followed = not self._lost
        self._rate = self._rate_at(solved.turn)
        self._step = self._turn.inverse().then(solved.turn) if followed else Turn.none()
        self._turn, self._lost, self._cut = solved.turn, 0, -1
        agrees = np.zeros(len(found), bool)
        agrees[found] = solved.agrees
        scene.trust[found] += TRUST_RATE * (solved.agrees - scene.trust[found])
        scene.steady.add(found, solved)
        readout = self.shutter.share
        if followed:
            self._learn_shutter(scene, solved)
        error = np.median(np.linalg.norm(solved.residual_px[solved.agrees], axis=1))
        measured = Measured(
            anchor=scene.number,
            turn=solved.turn,
            known=True,
            cause="",
            covariance=covariance(solved, SYSTEMATIC_PX / self.territory.focal_px / self._zoom),
            error_px=float(error) / self.scale,
            uv=self._uv[found].astype(np.float32),
            good=solved.agrees,
            share=max(self._alike, solved.agreeing / max(self._points.visible, 1)),
            lever=solved.lever if solved.lever.size else np.zeros((4, 2)),
            readout=readout,
        )
        away = self._away(found)
        if away > FARTHER * (self._pair.away if self._pair else LEAST_AWAY):
            self._take_pair(found, solved, away)
        if self._is_due(frame, found, solved.turn, away):
            self._advance_anchor(frame, usable, agrees, measured)
        return measured

    def _unknown(self, cause: Cause) -> Measured:
        anchor = 0 if self._scene is None else self._scene.number
        none = np.zeros((0, 2), np.float32)
        return Measured(
            anchor, self._turn, False, cause, np.eye(4), np.nan, none, np.zeros(0, bool)
        )

    def _learn_shutter(self, scene: _Scene, solved: Solved) -> None:
        """Take what the frame says of the readout, or learn how fast the anchor was turned."""
        if scene.rate is not None:
            change_px = np.linalg.norm(self._rate - scene.rate) * self.territory.focal_px
            if change_px * self._zoom > LEAST_CHANGE_PX:
                self.shutter.learn(solved.pull, solved.pull_information)
            return
        scene.rate = self._step.rotation
        tangents = scene.directions[:, :2] / scene.directions[:, 2:]
        scene.shifts = self.shutter.shifts(scene.anchor.uv, tangents, scene.rate)

    def _rate_at(self, turn: Turn) -> Array:
        """How fast the camera turns at this frame (3,), radians a frame: by half a step more than
        since the frame before.
        """
        if self._lost:
            return np.zeros(3)
        since = self._turn.inverse().then(turn).rotation
        return np.asarray(since + 0.5 * (since - self._step.rotation))

    def _shear(self, turn: Turn, found: NDArray[np.bool_]) -> Shear:
        """How a readout shifts the points found, against where it shifts them in the anchor."""
        scene, shutter = self._current, self.shutter
        tangents = turn.flat(scene.directions[found]) / turn.zoom
        seen = self.lens.pixels(unit(tangents), self._zoom * turn.zoom)
        shifts = shutter.shifts(seen, tangents, self._rate_at(turn)) - scene.shifts[found]
        if scene.rate is None:  # as in this frame
            shifts = np.zeros_like(shifts)
        return Shear(np.nan_to_num(shifts * turn.zoom), shutter.share)

    # --- where the camera is lost ---

    def _begin(self, frame: int, usable: Mask | None) -> Measured:
        """Set the first anchor, where there is something to follow."""
        if not self._points.could_pick(usable, FEWEST_POINTS):
            return self._unknown(self._poor(usable))
        self._set_anchor(frame, usable, Turn.none(), None)
        return self._at_anchor(np.zeros((4, 4)))

    def _find_again(self, frame: int, usable: Mask | None, like: float) -> Measured:
        """Try the anchors of scenes that were left; where none is seen, count as lost."""
        self._lost += 1
        self._step = Turn.none()
        current, turn = self._current, self._turn
        for scene in [current, *reversed(self._left)]:
            found, solved = self._try(scene, usable, turn)
            if solved is not None and self._holds(solved, found):
                if scene is not current:
                    self.cuts = [*self.cuts, *([self._cut] if self._cut >= 0 else [])]
                    self._left = [*(s for s in self._left if s is not scene), current]
                return self._gain(frame, usable, found, solved)
        self._scene, self._turn = current, turn
        self._points.use(current.anchor, self._expected(turn))
        return self._lose(frame, usable, like)

    def _try(
        self, scene: _Scene, usable: Mask | None, turn: Turn
    ) -> tuple[NDArray[np.bool_], Solved | None]:
        """Measure from an anchor with its picture shifted as a whole."""
        self._scene = scene
        shift = self._points.shift_from(scene.anchor)
        self._points.use(scene.anchor, scene.anchor.uv + shift)
        starts = [Turn.none(), turn]
        self._uv, found = self._points.refine(scene.anchor.uv + shift, usable, 2)
        solved = self._solve(self._uv, found, starts, SCALES_PX, None)
        if solved is None or not self._holds(solved, found):
            return found, None
        self._uv, found = self._points.refine(self._expected(solved.turn), usable, 0)
        return found, self._solve(self._uv, found, [solved.turn], SCALES_PX[-1:], None)

    def _lose(self, frame: int, usable: Mask | None, like: float) -> Measured:
        filled = usable is not None and usable.mean() < OPEN_SHARE
        cause: Cause = "body_fills" if filled else "not_rigid"
        if like < CUT_LIKENESS and self._cut < 0 and not filled:
            self._cut, cause = frame, "cut"
        settled = 0 <= self._cut < frame and like > SAME_LIKENESS
        if not settled and self._lost < LOST_FRAMES:
            return self._unknown(cause)
        if not self._points.could_pick(usable, FEWEST_POINTS):
            return self._unknown(self._poor(usable))
        if settled:
            self.cuts.append(self._cut)
        self._left = [*self._left, self._current][-SCENES:]
        scene, turn = self._current, self._turn
        self.territory.leave(scene.number, turn)
        world = self.territory.turns[scene.number].then(turn)
        self.loose.append(len(self.territory.turns))
        self._set_anchor(frame, usable, world, None)
        return self._at_anchor(np.eye(4))

    def _poor(self, usable: Mask | None) -> Cause:
        filled = usable is not None and usable.mean() < OPEN_SHARE
        return "body_fills" if filled else "no_texture"

    def _at_anchor(self, doubt: Array) -> Measured:
        """What is said of a frame that became an anchor tied to nothing."""
        uv, good = self._uv.astype(np.float32), np.ones(len(self._uv), bool)
        number = self._current.number
        return Measured(number, Turn.none(), True, "", doubt, 0.0, uv, good)

    # --- anchors ---

    def _away(self, found: NDArray[np.bool_]) -> float:
        """How far the picture went since the anchor, as a share of its width."""
        ways = self._uv[found] - self._current.anchor.uv[found]
        return float(np.linalg.norm(np.median(ways, axis=0)) / self.lens.camera.width)

    def _take_pair(self, found: NDArray[np.bool_], solved: Solved, away: float) -> None:
        """Keep the anchor and this frame, so far the farthest from it, for the focal length."""
        zooms = self._zoom, self._zoom * solved.turn.zoom
        scene, straight = self._current, self.shutter.straightened
        rate = np.zeros(3) if scene.rate is None else scene.rate
        one = straight(self.lens, scene.anchor.uv[found], zooms[0], rate)
        other = straight(self.lens, self._uv[found], zooms[1], self._rate)
        self._pair = Pair(one, other, zooms, away)

    def _end_anchor(self) -> None:
        """Take up what the points of the anchor measured from said."""
        self.summaries.append(self._current.steady.summary())
        if self._pair is not None:
            self.pairs = sorted([*self.pairs, self._pair], key=lambda p: -p.away)[:MOST_PAIRS]
        self._pair = None

    def _is_due(self, frame: int, found: NDArray[np.bool_], turn: Turn, away: float) -> bool:
        roll = abs(np.arctan2(turn.R[1, 0], turn.R[0, 0]))
        if away > AWAY_SHARE or roll > ROLL or abs(np.log(turn.zoom)) > ZOOM:
            return True
        scene = self._current
        scene.most_found = max(scene.most_found, int(found.sum()))
        few = found.sum() < SEEN_SHARE * scene.most_found
        late = frame - self.territory.frames[-1] >= SOONEST or found.sum() < SCARCE
        return bool(few and late)

    def _advance_anchor(
        self, frame: int, usable: Mask | None, agrees: NDArray[np.bool_], measured: Measured
    ) -> None:
        """Set an anchor where the camera is known, tied to the last and to what came back."""
        scene, territory = self._current, self.territory
        rate = np.zeros(3) if scene.rate is None else scene.rate
        territory.keep(scene.anchor, scene.number, rate, scene.trust > TRUSTED)
        turn = territory.turns[scene.number].then(measured.turn)
        self._ties.append((len(territory.edges), measured.lever, measured.readout))
        territory.tie(scene.number, measured.turn, measured.covariance)
        ids, uv, trust = scene.anchor.ids[agrees], self._uv[agrees], scene.trust[agrees]
        turn, back, back_uv = territory.returned(turn, self._rate, usable)
        again = np.isin(back, ids)
        place = {number: k for k, number in enumerate(ids.tolist())}
        for number, there in zip(back[again].tolist(), back_uv[again], strict=True):
            uv[place[number]] = there
        fresh = ~again & self._points.in_empty_cells(back_uv, uv)
        ids, uv = np.concatenate([ids, back[fresh]]), np.concatenate([uv, back_uv[fresh]])
        trust = np.concatenate([trust, np.ones(fresh.sum())])
        self._set_anchor(frame, usable, turn, (ids, uv, trust))

    def _set_anchor(
        self,
        frame: int,
        usable: Mask | None,
        turn: Turn,
        known: tuple[NDArray[np.int64], Array, Array] | None,
    ) -> None:
        """Set an anchor at the latest picture; known: ids, places and trust of its points."""
        if self._scene is not None:
            self._end_anchor()
        ids, uv, trust = known or (np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros(0))
        anchor = self._points.pick(usable, ids, uv)
        self._uv = anchor.uv
        trust = np.concatenate([trust, np.full(len(anchor.ids) - len(trust), TRUST_NEW)])
        directions = self.lens.directions(anchor.uv, turn.zoom)
        number = len(self.territory.turns)
        rate = None if known is None else self._rate
        tangents = directions[:, :2] / directions[:, 2:]
        shifts = self.shutter.shifts(anchor.uv, tangents, np.zeros(3) if rate is None else rate)
        steady = Steadiness(len(trust))
        self._scene = _Scene(number, anchor, directions, trust, steady, rate, shifts)
        self.territory.add(frame, turn)
        self._turn, self._lost, self._cut = Turn.none(), 0, -1
        if known is None:
            self._step = Turn.none()

    def _likeness(self) -> float:
        """The correlation of the latest picture with the one before, both very small."""
        now = self._points.now
        assert now is not None
        little = cv2.resize(now, LITTLE, interpolation=cv2.INTER_AREA).astype(float).ravel()
        before, self._little = self._little, little - little.mean()
        if before is None:
            return 1.0
        power = np.sqrt((before @ before) * (self._little @ self._little))
        return float(before @ self._little / power) if power > 1e-9 else 1.0
