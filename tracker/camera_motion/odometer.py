"""Measure a camera's turns through a film, one frame after another, from its anchors.

Every frame is measured from one anchor, an earlier frame in which points were picked, so nothing
adds up between them. A new anchor is set where too little of the old is in view; landmarks of
older anchors that are in view again then tie it to these. Memory grows by what is said of a frame.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.anchors import Edge
from keypose.tracker.camera_motion.landmarks import Landmarks
from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.points import Grey, Mask, PointFollower
from keypose.tracker.camera_motion.steadiness import Steadiness, Summary
from keypose.tracker.camera_motion.turn import Solved, Turn, solve_turn
from keypose.tracker.geometry.rotations import Array

Cause: TypeAlias = Literal["", "no_texture", "body_fills", "cut", "not_rigid", "no_picture"]
"""Why the camera is unknown at a frame; nothing where it is known."""

FEWEST_POINTS = 12
"""With fewer picked there is no texture."""
FEWEST_AGREE, SHARE_AGREE = 8, 0.25
"""Points that must agree, and their share of those that could be seen."""
MOST_DOUBT = np.radians(0.2)
"""Standard deviation of the turn above which it is not known."""
OPEN_SHARE = 0.3
"""Share of the picture that must be background."""
LOST_FRAMES = 4
"""After so many frames without the camera a new anchor is set, tied to nothing."""
CUT_LIKENESS, SAME_LIKENESS = 0.5, 0.7
"""Correlation of two pictures at a cut, and of two of one scene."""
SEEN_SHARE, AWAY_SHARE = 0.6, 0.22
"""A new anchor is due where this share of its points is left, or it moved by this share of the
picture's width."""
ROLL, ZOOM = np.radians(8.0), 0.14
"""Or rolled, or zoomed, so far that windows no longer look alike."""
SOONEST = 4
"""Frames from an anchor to the next, where points merely become few."""
SYSTEMATIC_PX = 0.03
"""What an anchor's points have in common that no spread shows."""
TRUST_NEW, TRUST_RATE, TRUSTED = 0.5, 0.1, 0.6
LIKE_HOME = 0.35
"""Logarithm of the zoom by which a landmark may differ from its home."""
MOST_TRIED = 300
FEWEST_RETURNED = 10
LITTLE = (32, 18)
"""Size of the pictures whose likeness tells a cut."""


@dataclass(frozen=True, eq=False)
class Measured:
    """One frame, from its anchor.

    turn: from the anchor's camera; zoom as a quotient.  covariance (4, 4).  error_px: median of
    the agreeing points' residuals, NaN where unknown.  uv (K, 2) and good (K,): the points found.
    """

    anchor: int
    turn: Turn
    known: bool
    cause: Cause
    covariance: Array
    error_px: float
    uv: NDArray[np.float32]
    good: NDArray[np.bool_]


@dataclass(eq=False)
class Odometer:
    """Takes the frames of a film in order. `turns`: of the anchors from the world, as known on
    the way; `edges` between them; `frames` in which they were set.
    """

    lens: Lens
    turns: list[Turn] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)
    frames: list[int] = field(default_factory=list)
    summaries: list[Summary] = field(default_factory=list)
    cuts: list[int] = field(default_factory=list)
    landmarks: Landmarks = field(default_factory=Landmarks)

    def __post_init__(self) -> None:
        camera = self.lens.camera
        self._points = PointFollower(camera.width, camera.height)
        self._focal_px = self.lens.focal_px * self._points.scale
        self._directions = np.zeros((0, 3))
        self._trust = np.zeros(0)
        self._turn, self._step = Turn.none(), Turn.none()
        self._lost, self._cut = 0, -1
        self._little: Array | None = None
        self._steady = Steadiness(0)

    def advance(self, frame: int, picture: Grey | None, usable: Mask | None) -> Measured:
        """Measure the next frame; the picture is None where it cannot be read."""
        if picture is None:
            self._lost += 1
            return self._unknown("no_picture")
        rough, followed = self._points.look(picture)
        like = self._likeness()
        if not self.turns:
            self._anchor_here(frame, usable, Turn.none(), None)
            return self._at_anchor(usable)
        found, solved = self._measure(rough, followed, usable)
        if solved is None or not self._holds(solved, found):
            return self._lose(frame, usable, like)
        return self._gain(frame, usable, found, solved)

    def finish(self) -> None:
        """Take up what the last anchor's points said."""
        if self.turns:
            self.summaries.append(self._steady.summary())
        else:
            self.turns.append(Turn.none())
            self.frames.append(0)

    @property
    def scale(self) -> float:
        """From pixels of the film to those looked at."""
        return self._points.scale

    # --- one frame ---

    def _measure(
        self, rough: Array, followed: NDArray[np.bool_], usable: Mask | None
    ) -> tuple[NDArray[np.bool_], Solved | None]:
        starts = [self._turn.then(self._step), self._turn]
        first = self._solve(rough, followed, starts)
        turn = starts[1] if first is None or first.agreeing < FEWEST_AGREE else first.turn
        zoom = self.turns[-1].zoom
        expected = self.lens.pixels(turn.rotated(self._directions), zoom * turn.zoom)
        expected = np.where(np.isfinite(expected), expected, -1e4)
        self._uv, found = self._points.refine(expected, usable)
        return found, self._solve(self._uv, found, [turn, *starts])

    def _solve(self, uv: Array, found: NDArray[np.bool_], starts: list[Turn]) -> Solved | None:
        zoom = self.turns[-1].zoom
        seen = self.lens.flat(uv[found], zoom * starts[0].zoom) / zoom
        return solve_turn(
            self._directions[found], seen, self._focal_px * zoom, self._trust[found], starts
        )

    def _holds(self, solved: Solved, found: NDArray[np.bool_]) -> bool:
        """Return whether enough points agree, and tell the turn."""
        visible = max(int(found.sum()), self._points.visible)
        enough = solved.agreeing >= max(FEWEST_AGREE, SHARE_AGREE * visible)
        if not enough:
            return False
        doubt = np.sqrt(np.trace(_covariance(solved.information, 0.0)[:3, :3]) / 3)
        return bool(doubt < MOST_DOUBT)

    def _gain(
        self, frame: int, usable: Mask | None, found: NDArray[np.bool_], solved: Solved
    ) -> Measured:
        self._step = self._turn.inverse().then(solved.turn) if not self._lost else Turn.none()
        self._turn, self._lost, self._cut = solved.turn, 0, -1
        agrees = np.zeros(len(found), bool)
        agrees[found] = solved.agrees
        self._trust[found] += TRUST_RATE * (solved.agrees - self._trust[found])
        self._steady.add(found, solved)
        measured = Measured(
            len(self.turns) - 1,
            solved.turn,
            True,
            "",
            _covariance(solved.information, self._systematic),
            float(np.median(np.linalg.norm(solved.residual_px[solved.agrees], axis=1)))
            / self._points.scale,
            self._uv[found].astype(np.float32),
            solved.agrees,
        )
        if self._is_due(frame, found, solved.turn):
            self._tie(frame, usable, agrees, measured)
        return measured

    def _lose(self, frame: int, usable: Mask | None, like: float) -> Measured:
        self._lost += 1
        self._step = Turn.none()
        few = len(self._directions) < FEWEST_POINTS
        cause: Cause = "not_rigid"
        if usable is not None and usable.mean() < OPEN_SHARE:
            cause = "body_fills"
        elif few:
            cause = "no_texture"
        elif like < CUT_LIKENESS and self._cut < 0:
            self._cut, cause = frame, "cut"
        settled = 0 <= self._cut < frame and like > SAME_LIKENESS
        if settled:
            self.cuts.append(self._cut)
        if settled or self._lost >= LOST_FRAMES or few:
            self._anchor_here(frame, usable, self.turns[-1].then(self._turn), None)
            if len(self._directions) >= FEWEST_POINTS:
                return self._at_anchor(usable)
        return self._unknown(cause)

    def _at_anchor(self, usable: Mask | None) -> Measured:
        """What is said of a frame that became an anchor tied to nothing."""
        known = len(self._directions) >= FEWEST_POINTS
        cause: Cause = ""
        if not known:
            filled = usable is not None and usable.mean() < OPEN_SHARE
            cause = "body_fills" if filled else "no_texture"
        uv = self._uv.astype(np.float32)
        error = 0.0 if known else np.nan
        none = Turn.none()
        return Measured(
            len(self.turns) - 1, none, known, cause, _NOTHING, error, uv, np.full(len(uv), known)
        )

    def _unknown(self, cause: Cause) -> Measured:
        anchor = max(len(self.turns) - 1, 0)
        none = np.zeros((0, 2), np.float32)
        return Measured(anchor, self._turn, False, cause, _NOTHING, np.nan, none, np.zeros(0, bool))

    # --- anchors ---

    @property
    def _systematic(self) -> float:
        return SYSTEMATIC_PX / self._focal_px / self.turns[-1].zoom

    def _is_due(self, frame: int, found: NDArray[np.bool_], turn: Turn) -> bool:
        flat = self._uv[found] - self._points.anchor_uv[found]
        away = np.linalg.norm(np.median(flat, axis=0)) / self.lens.camera.width
        roll = abs(np.arctan2(turn.R[1, 0], turn.R[0, 0]))
        if away > AWAY_SHARE or roll > ROLL or abs(np.log(turn.zoom)) > ZOOM:
            return True
        few = found.sum() < SEEN_SHARE * len(found)
        return bool(few and frame - self.frames[-1] >= SOONEST)

    def _tie(
        self, frame: int, usable: Mask | None, agrees: NDArray[np.bool_], measured: Measured
    ) -> None:
        """Set an anchor where the camera is known, tied to the last and to what came back."""
        self._keep_landmarks()
        one, other = len(self.turns) - 1, len(self.turns)
        turn = self.turns[-1].then(measured.turn)
        information = np.linalg.inv(measured.covariance)
        self.edges.append(Edge(one, other, measured.turn, information))
        ids, uv, trust = self._points.ids[agrees], self._uv[agrees], self._trust[agrees]
        turn, back, back_uv = self._returned(turn, usable)
        again = np.isin(back, ids)
        place = {number: k for k, number in enumerate(ids.tolist())}
        for number, there in zip(back[again].tolist(), back_uv[again], strict=True):
            uv[place[number]] = there
        ids, uv = np.concatenate([ids, back[~again]]), np.concatenate([uv, back_uv[~again]])
        trust = np.concatenate([trust, np.ones((~again).sum())])
        self._anchor_here(frame, usable, turn, (ids, uv, trust))

    def _anchor_here(
        self,
        frame: int,
        usable: Mask | None,
        turn: Turn,
        known: tuple[NDArray[np.int64], Array, Array] | None,
    ) -> None:
        """Set an anchor at the latest picture; known: ids, places and trust of its points."""
        if self.turns:
            self.summaries.append(self._steady.summary())
        if known is None and self.turns:
            self.edges.append(
                Edge(len(self.turns) - 1, len(self.turns), self._turn, 1e-6 * np.eye(4))
            )
            self._step = Turn.none()
        ids, uv, trust = known or (np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros(0))
        ids, self._uv = self._points.pick(usable, ids, uv)
        self._trust = np.concatenate([trust, np.full(len(ids) - len(trust), TRUST_NEW)])
        self._directions = self.lens.directions(self._uv, turn.zoom)
        self.turns.append(turn)
        self.frames.append(frame)
        self._turn, self._lost, self._cut = Turn.none(), 0, -1
        self._steady = Steadiness(len(ids))

    def _keep_landmarks(self) -> None:
        """Keep the last anchor's own points that proved themselves."""
        anchor = self._points.anchor
        assert anchor is not None
        kept = (self._trust > TRUSTED) & ~np.isin(anchor.ids, self.landmarks.ids)
        uv = anchor.uv[kept]
        at = self._points.to_look(uv)
        self.landmarks.keep(anchor.grey, len(self.turns) - 1, anchor.ids[kept], uv, at)

    def _returned(self, turn: Turn, usable: Mask | None) -> tuple[Turn, NDArray[np.int64], Array]:
        """Look for landmarks of older anchors; tie the anchor that is about to be to these.

        Return its turn, the ids of landmarks that are there, and their places (K, 2).
        """
        none = np.zeros(0, np.int64), np.zeros((0, 2))
        marks, now = self.landmarks, self._points.now
        assert now is not None
        chosen, at, warps = self._candidates(turn, usable)
        there, found = marks.register(chosen, now, at, warps)
        chosen, uv = chosen[found], self._points.to_film(there[found])
        solved = self._solve_world(chosen, uv, turn)
        if solved is None or solved.agreeing < max(FEWEST_RETURNED, 0.5 * len(chosen)):
            return turn, *none
        chosen, uv = chosen[solved.agrees], uv[solved.agrees]
        for home in np.unique(marks.home[chosen]):
            self._tie_home(int(home), chosen, uv, solved.turn)
        return solved.turn, marks.ids[chosen], uv

    def _candidates(
        self, turn: Turn, usable: Mask | None
    ) -> tuple[NDArray[np.int64], Array, Array]:
        """Landmarks that should be in view: which, where (K, 2), and their warps (K, 2, 2)."""
        marks = self.landmarks
        older = np.flatnonzero(marks.home < len(self.turns) - 1)
        zooms = np.array([known.zoom for known in self.turns])[marks.home[older]]
        older = older[np.abs(np.log(zooms / turn.zoom)) < LIKE_HOME]
        at = self._points.to_look(self._seen(older, marks.uv[older], turn))
        inside = self._points.inside(at, 12.0) & self._points.usable_at(usable, at)
        older, at = older[inside][:MOST_TRIED], at[inside][:MOST_TRIED]
        warps = np.empty((len(older), 2, 2))
        reach = 6.0
        for axis in range(2):
            aside = marks.uv[older] + reach / self._points.scale * np.eye(2)[axis]
            warps[:, :, axis] = (self._points.to_look(self._seen(older, aside, turn)) - at) / reach
        sound = np.isfinite(warps).all(axis=(1, 2))
        sound &= np.abs(np.abs(np.linalg.det(np.where(sound[:, None, None], warps, 1.0))) - 1) < 0.9
        sound[sound] &= np.abs(np.linalg.det(warps[sound])) > 0.3
        return older[sound], at[sound], warps[sound]

    def _world(self, chosen: NDArray[np.int64], uv: Array) -> Array:
        """Directions (K, 3) in the world of pixels (K, 2) of the homes of landmarks."""
        home = self.landmarks.home[chosen]
        directions = np.empty((len(chosen), 3))
        for number in np.unique(home):
            turn, of = self.turns[number], home == number
            directions[of] = self.lens.directions(uv[of], turn.zoom) @ turn.R
        return directions

    def _seen(self, chosen: NDArray[np.int64], uv: Array, turn: Turn) -> Array:
        return self.lens.pixels(turn.rotated(self._world(chosen, uv)), turn.zoom)

    def _solve_world(self, chosen: NDArray[np.int64], uv: Array, turn: Turn) -> Solved | None:
        world = self._world(chosen, self.landmarks.uv[chosen])
        seen = self.lens.flat(uv, turn.zoom)
        return solve_turn(world, seen, self._focal_px, np.ones(len(uv)), [turn])

    def _tie_home(self, home: int, chosen: NDArray[np.int64], uv: Array, turn: Turn) -> None:
        """Add the edge from one older anchor, where enough of its landmarks were found."""
        of = self.landmarks.home[chosen] == home
        if of.sum() < FEWEST_RETURNED:
            return
        begin = self.turns[home]
        directions = self.lens.directions(self.landmarks.uv[chosen[of]], begin.zoom)
        seen = self.lens.flat(uv[of], turn.zoom) / begin.zoom
        focal_px, start = self._focal_px * begin.zoom, begin.inverse().then(turn)
        solved = solve_turn(directions, seen, focal_px, np.ones(len(seen)), [start])
        if solved is None or solved.agreeing < FEWEST_RETURNED:
            return
        covariance = _covariance(solved.information, SYSTEMATIC_PX / focal_px)
        information = np.linalg.inv(covariance)
        self.edges.append(Edge(home, len(self.turns), solved.turn, information, returns=True))

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


_NOTHING = np.eye(4)


def _covariance(information: Array, systematic: float) -> Array:
    """Inverse of an information matrix, with what its points have in common, radians."""
    floor = np.diag(np.full(4, systematic**2 + 1e-16))
    scale = max(np.trace(information), 1e-12)
    return np.asarray(np.linalg.inv(information + 1e-12 * scale * np.eye(4)) + floor)
