"""Know the scene that a turning camera has seen: its anchors, their landmarks, and their ties.

An anchor is tied to the one before it by the points followed between them, and to older ones by
their landmarks that are in view again. The turns known on the way already use these, so that a
camera that comes back finds what it left; `agreed` puts all ties together in the end.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.anchors import Edge, agreed
from keypose.tracker.camera_motion.landmarks import Landmarks
from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.points import Anchor, Mask, PointFollower
from keypose.tracker.camera_motion.shutter import Shutter
from keypose.tracker.camera_motion.turn import Solved, Turn, solve_turn
from keypose.tracker.geometry.rotations import Array

SYSTEMATIC_PX = 0.03
"""What an anchor's points have in common that no spread shows."""
LIKE_HOME = 0.35
"""Logarithm of the zoom by which a landmark may differ from its home."""
LEAST_AREA = 0.3
MOST_AREA = 2.2
"""Of a patch as it is seen, against its home."""
MOST_TRIED = 300
FEWEST_RETURNED = 10
RETURNED_SHARE = 0.5
MOST_TIES = 6
"""Older anchors that one is tied to."""
BORDER_PX = 12.0
ASIDE_PX = 6.0
"""Offset by which a patch's warp is measured."""
NO_TIE = 1e-6
"""Information of a tie between anchors that do not hang together."""


@dataclass(eq=False)
class Territory:
    """Anchors in the order in which they were set.

    turns: of each, from the world, as known on the way.  frames: in which they were set.
    points: the follower, whose latest picture is the one looked at.
    """

    lens: Lens
    points: PointFollower
    shutter: Shutter
    turns: list[Turn] = field(default_factory=list)
    frames: list[int] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)
    landmarks: Landmarks = field(default_factory=Landmarks)

    @property
    def focal_px(self) -> float:
        """At zoom 1, pixels of the size looked at."""
        return self.lens.focal_px * self.points.scale

    def agreed(self) -> list[Turn]:
        """The anchors' turns from the world with all ties together."""
        return agreed(self.turns, self.edges)

    def add(self, frame: int, turn: Turn) -> None:
        self.turns.append(turn)
        self.frames.append(frame)

    def tie(self, one: int, turn: Turn, covariance: Array, returns: bool = False) -> None:
        """Tie the anchor that is about to be set to an earlier one."""
        information = np.asarray(np.linalg.inv(covariance))
        self.edges.append(Edge(one, len(self.turns), turn, information, returns))

    def leave(self, one: int, turn: Turn) -> None:
        """The same where all that is known is that the one comes after the other."""
        self.edges.append(Edge(one, len(self.turns), turn, NO_TIE * np.eye(4)))

    def keep(self, anchor: Anchor, number: int, rate: Array, proved: NDArray[np.bool_]) -> None:
        """Keep the proved ones (K,) of an anchor's points that were picked in it. rate (3,): how
        fast the camera turned then, radians a frame.
        """
        kept = proved & ~np.isin(anchor.ids, self.landmarks.ids)
        uv = anchor.uv[kept]
        at = self.points.to_look(uv)
        uv = self.shutter.straightened(self.lens, uv, self.turns[number].zoom, rate)
        self.landmarks.keep(anchor.grey, number, anchor.ids[kept], uv, at)

    def returned(
        self, turn: Turn, rate: Array, usable: Mask | None
    ) -> tuple[Turn, NDArray[np.int64], Array]:
        """Look for landmarks in the latest picture, taken with `turn` or nearly so and at a rate
        (3,), and tie the anchor that is about to be set in it to their homes.

        Return its turn, the ids of landmarks that are there, and their places (K, 2).
        """
        none = np.zeros(0, np.int64), np.zeros((0, 2))
        marks, now = self.landmarks, self.points.now
        assert now is not None
        chosen, at, warps = self._candidates(turn, rate, usable)
        there, found = marks.register(chosen, now, at, warps)
        chosen, uv = chosen[found], self.points.to_film(there[found])
        world = self._world(chosen, marks.uv[chosen])
        straight = self.shutter.straightened(self.lens, uv, turn.zoom, rate)
        seen = self.lens.flat(straight, turn.zoom)
        solved = solve_turn(world, seen, self.focal_px, np.ones(len(uv)), [turn])
        if solved is None or solved.agreeing < max(FEWEST_RETURNED, RETURNED_SHARE * len(chosen)):
            return turn, *none
        chosen, uv, straight = chosen[solved.agrees], uv[solved.agrees], straight[solved.agrees]
        homes, counts = np.unique(marks.home[chosen], return_counts=True)
        for home in homes[np.argsort(-counts, kind="stable")][:MOST_TIES]:
            self._tie_home(int(home), chosen, straight, solved.turn)
        return solved.turn, marks.ids[chosen], uv

    def _candidates(
        self, turn: Turn, rate: Array, usable: Mask | None
    ) -> tuple[NDArray[np.int64], Array, Array]:
        """Landmarks that should be in view: which, where (K, 2), and their warps (K, 2, 2)."""
        marks, points = self.landmarks, self.points
        older = np.flatnonzero(marks.home < len(self.turns) - 1)
        zooms = np.array([known.zoom for known in self.turns])[marks.home[older]]
        older = older[np.abs(np.log(zooms / turn.zoom)) < LIKE_HOME]
        at = points.to_look(self._seen(older, marks.uv[older], turn, rate))
        inside = points.inside(at, BORDER_PX) & points.usable_at(usable, at)
        older, at = older[inside][:MOST_TRIED], at[inside][:MOST_TRIED]
        warps = np.empty((len(older), 2, 2))
        for axis in range(2):
            aside = marks.uv[older] + ASIDE_PX / points.scale * np.eye(2)[axis]
            beside = points.to_look(self._seen(older, aside, turn, rate))
            warps[:, :, axis] = (beside - at) / ASIDE_PX
        area = np.linalg.det(np.nan_to_num(warps))
        sound = (area > LEAST_AREA) & (area < MOST_AREA)
        return older[sound], at[sound], warps[sound]

    def _world(self, chosen: NDArray[np.int64], uv: Array) -> Array:
        """Directions (K, 3) in the world of pixels (K, 2) of the homes of landmarks."""
        home = self.landmarks.home[chosen]
        directions = np.empty((len(chosen), 3))
        for number in np.unique(home):
            turn, of = self.turns[number], home == number
            directions[of] = self.lens.directions(uv[of], turn.zoom) @ turn.R
        return directions

    def _seen(self, chosen: NDArray[np.int64], uv: Array, turn: Turn, rate: Array) -> Array:
        there = self.lens.pixels(turn.rotated(self._world(chosen, uv)), turn.zoom)
        return self.shutter.sheared(self.lens, there, turn.zoom, rate)

    def _tie_home(self, home: int, chosen: NDArray[np.int64], uv: Array, turn: Turn) -> None:
        """Tie to one older anchor, where enough of its landmarks were found."""
        of = self.landmarks.home[chosen] == home
        if of.sum() < FEWEST_RETURNED:
            return
        begin = self.turns[home]
        directions = self.lens.directions(self.landmarks.uv[chosen[of]], begin.zoom)
        seen = self.lens.flat(uv[of], turn.zoom) / begin.zoom
        focal_px, start = self.focal_px * begin.zoom, begin.inverse().then(turn)
        solved = solve_turn(directions, seen, focal_px, np.ones(len(seen)), [start])
        if solved is None or solved.agreeing < FEWEST_RETURNED:
            return
        doubt = covariance(solved, SYSTEMATIC_PX / focal_px)
        self.tie(home, solved.turn, doubt, returns=True)


def covariance(solved: Solved, systematic: float) -> Array:
    """The covariance (4, 4) of a turn, with what its points have in common, radians."""
    information = solved.information
    scale = max(np.trace(information), 1e-12)
    floor = (systematic**2 + 1e-16) * np.eye(4)
    return np.asarray(np.linalg.inv(information + 1e-12 * scale * np.eye(4)) + floor)
