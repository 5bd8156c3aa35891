"""The map of a camera that turns: its keyframes, and the landmarks that were picked in them.

A *keyframe* is a picture that is kept to measure later ones from. A *landmark* is a point of the
background, here a direction; its *anchor* is the keyframe in which it was picked, with the patch of
the picture there. The odometry adds both, and asks which landmarks are in view again: these close
the loop. Keyframes are tied by what was measured between them, an edge of the pose graph for each.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.patches import BORDER_PX, Patches
from keypose.tracker.camera_motion.points import KeyframePicture, Mask, PointFollower
from keypose.tracker.camera_motion.pose_graph import Edge, optimised
from keypose.tracker.camera_motion.shutter import Shutter
from keypose.tracker.camera_motion.turn import SeenDirections, Turn, solve_turn
from keypose.tracker.geometry.rotations import Array

SYSTEMATIC_PX = 0.03
"""Standard deviation of what a keyframe's points have in common, which no spread shows; pixels of
the picture looked at."""
ALIKE_ZOOM = 0.35
"""Logarithm of the zoom by which a landmark's anchor may differ and still look alike."""
LEAST_AREA = 0.3
MOST_AREA = 2.2
"""Of a patch as it is seen, its own the unit: smaller or larger it does not look alike."""
MOST_LOOKED_FOR = 300
"""Landmarks that are looked for in one keyframe, the oldest first: a bound on the time."""
FEWEST_RETURNED = 10
RETURNED_SHARE = 0.5
"""Landmarks that must agree to close a loop, and their share of those that were found."""
MOST_CLOSURES = 6
"""Older keyframes that one is tied to, those with the most landmarks."""
ASIDE_PX = 6.0
"""Offset by which a patch's warp is measured, pixels of the picture looked at."""
NO_TIE = 1e-6
"""Information of an edge between keyframes that nothing ties, rad⁻²: it keeps the pose graph
connected and decides nothing."""


@dataclass(eq=False)
class DirectionMap:
    """What a camera that turns has seen. Keyframes by number, in the order in which they were set.

    turns: of each keyframe, from the world, as known on the way: they use the loops closed so far,
    so that a camera that comes back finds what it left.  frames: in which they were set.
    points: the follower, whose latest picture is the one looked at.
    """

    lens: Lens
    points: PointFollower
    shutter: Shutter
    turns: list[Turn] = field(default_factory=list)
    frames: list[int] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)
    landmarks: Patches = field(default_factory=Patches)

    @property
    def focal_px(self) -> float:
        """At zoom 1, pixels of the size looked at."""
        return self.lens.focal_px * self.points.scale

    def optimised(self) -> list[Turn]:
        """The keyframes' turns from the world by all edges together."""
        return optimised(self.turns, self.edges)

    def add(self, frame: int, turn: Turn) -> None:
        """Add a keyframe."""
        self.turns.append(turn)
        self.frames.append(frame)

    def tie(self, source: int, turn: Turn, covariance: Array, closes_loop: bool = False) -> None:
        """Tie the keyframe that is about to be added to an earlier one.

        Args:
            source: number of the earlier one.
            turn: from the earlier one's camera.
            covariance: (4, 4) of the turn, radians, and of the logarithm of the zoom.
            closes_loop: whether landmarks of old say so, not points followed from there.
        """
        information = np.asarray(np.linalg.inv(covariance))
        self.edges.append(Edge(source, len(self.turns), turn, information, closes_loop))

    def follow_untied(self, source: int, turn: Turn) -> None:
        """The same where all that is known is that the one comes after the other."""
        self.edges.append(Edge(source, len(self.turns), turn, NO_TIE * np.eye(4)))

    def keep(
        self, picture: KeyframePicture, number: int, rate: Array, proved: NDArray[np.bool_]
    ) -> None:
        """Keep the landmarks that were picked in a keyframe.

        Args:
            picture: of the keyframe, with all its points (K,).
            number: of the keyframe.
            rate: (3,) how fast the camera turned then, radians a frame.
            proved: (K,) which points have moved as the background does.
        """
        kept = proved & ~np.isin(picture.ids, self.landmarks.ids)
        uv = picture.uv[kept]
        at = self.points.to_look(uv)
        uv = self.shutter.straightened(self.lens, uv, self.turns[number].zoom, rate)
        self.landmarks.keep(picture.grey, number, picture.ids[kept], uv, at)

    def close_loops(
        self, turn: Turn, rate: Array, usable: Mask | None
    ) -> tuple[Turn, NDArray[np.int64], Array]:
        """Look for landmarks in the latest picture, taken with `turn` or nearly so and at a rate
        (3,), and tie the keyframe that is about to be added in it to their anchors.

        Return its turn, the ids of landmarks that are there, and their places (K, 2).
        """
        none = np.zeros(0, np.int64), np.zeros((0, 2))
        marks, now = self.landmarks, self.points.now
        assert now is not None
        chosen, at, warps = self._candidates(turn, rate, usable)
        there, is_registered = marks.register(chosen, now, at, warps)
        chosen, uv = chosen[is_registered], self.points.to_film(there[is_registered])
        world = self._world(chosen, marks.uv[chosen])
        straight = self.shutter.straightened(self.lens, uv, turn.zoom, rate)
        observed = self.lens.flat(straight, turn.zoom)
        points = SeenDirections.trusted(world, observed, self.focal_px)
        solved = solve_turn(points, [turn])
        if solved is None or solved.agreeing < max(FEWEST_RETURNED, RETURNED_SHARE * len(chosen)):
            return turn, *none
        chosen, uv, straight = chosen[solved.agrees], uv[solved.agrees], straight[solved.agrees]
        anchors, counts = np.unique(marks.anchor[chosen], return_counts=True)
        for anchor in anchors[np.argsort(-counts, kind="stable")][:MOST_CLOSURES]:
            of_anchor = marks.anchor[chosen] == anchor
            if of_anchor.sum() >= FEWEST_RETURNED:
                self._close(int(anchor), chosen[of_anchor], straight[of_anchor], solved.turn)
        return solved.turn, marks.ids[chosen], uv

    def _candidates(
        self, turn: Turn, rate: Array, usable: Mask | None
    ) -> tuple[NDArray[np.int64], Array, Array]:
        """Landmarks that should be in view: which, where (K, 2), and their warps (K, 2, 2)."""
        marks, points = self.landmarks, self.points
        older = np.flatnonzero(marks.anchor < len(self.turns) - 1)
        zooms = np.array([turn_then.zoom for turn_then in self.turns])[marks.anchor[older]]
        older = older[np.abs(np.log(zooms / turn.zoom)) < ALIKE_ZOOM]
        at = points.to_look(self._expected(older, marks.uv[older], turn, rate))
        inside = points.inside(at, BORDER_PX) & points.usable_at(usable, at)
        older, at = older[inside][:MOST_LOOKED_FOR], at[inside][:MOST_LOOKED_FOR]
        warps = np.empty((len(older), 2, 2))
        for axis in range(2):
            aside = marks.uv[older] + ASIDE_PX / points.scale * np.eye(2)[axis]
            beside = points.to_look(self._expected(older, aside, turn, rate))
            warps[:, :, axis] = (beside - at) / ASIDE_PX
        area = np.linalg.det(np.nan_to_num(warps))
        alike = (area > LEAST_AREA) & (area < MOST_AREA)
        return older[alike], at[alike], warps[alike]

    def _world(self, chosen: NDArray[np.int64], uv: Array) -> Array:
        """Directions (K, 3) in the world of pixels (K, 2) of the anchors of landmarks."""
        anchor = self.landmarks.anchor[chosen]
        directions = np.empty((len(chosen), 3))
        for number in np.unique(anchor):
            turn, of = self.turns[number], anchor == number
            directions[of] = self.lens.directions(uv[of], turn.zoom) @ turn.R
        return directions

    def _expected(self, chosen: NDArray[np.int64], uv: Array, turn: Turn, rate: Array) -> Array:
        """Where the camera shows places of landmarks' anchors, pixels of the film (K, 2).

        Args:
            chosen: (K,) rows of the landmarks.
            uv: (K, 2) pixels of their anchors.
            turn: of the camera, from the world.
            rate: (3,) how fast it turns, radians a frame.
        """
        there = self.lens.pixels(turn.rotated(self._world(chosen, uv)), turn.zoom)
        return self.shutter.sheared(self.lens, there, turn.zoom, rate)

    def _close(self, anchor: int, chosen: NDArray[np.int64], uv: Array, turn: Turn) -> None:
        """Tie the keyframe that is about to be added to an older one, where that holds.

        Args:
            anchor: number of the older one.
            chosen: (K,) rows of landmarks that were picked in it.
            uv: (K, 2) where they are seen now, pixels of the film, straightened.
            turn: of the camera now, from the world.
        """
        begin = self.turns[anchor]
        directions = self.lens.directions(self.landmarks.uv[chosen], begin.zoom)
        observed = self.lens.flat(uv, turn.zoom) / begin.zoom
        focal_px, start = self.focal_px * begin.zoom, begin.inverse().then(turn)
        points = SeenDirections.trusted(directions, observed, focal_px)
        solved = solve_turn(points, [start])
        if solved is None or solved.agreeing < FEWEST_RETURNED:
            return
        doubt = solved.covariance(SYSTEMATIC_PX / focal_px)
        self.tie(anchor, solved.turn, doubt, closes_loop=True)
