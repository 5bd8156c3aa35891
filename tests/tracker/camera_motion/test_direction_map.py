"""The map of a camera that turns: landmarks that return close its loops."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.camera_motion.direction_map import DirectionMap
from keypose.tracker.camera_motion.lens import Lens
from keypose.tracker.camera_motion.points import PointFollower
from keypose.tracker.camera_motion.shutter import Shutter
from keypose.tracker.camera_motion.turn import Turn
from keypose.tracker.geometry.rotations import Array
from tests.tracker.camera_cases import SMALL, off_deg, rendered, turned

LENS = Lens.of(SMALL)
STILL = np.zeros(3)
NOBODY = np.zeros(0, np.int64), np.zeros((0, 2))
SURE = np.eye(4) * 1e-8


@dataclass(frozen=True, eq=False)
class Film:
    """A map of a film that is looked at picture by picture."""

    map: DirectionMap
    points: PointFollower

    @classmethod
    def of(cls) -> Film:
        points = PointFollower(320, 180)
        return cls(DirectionMap(LENS, points, Shutter((320, 180))), points)

    def keyframe(self, turn: Turn, proved: bool = True) -> NDArray[np.int64]:
        """Look at what a camera shows that is turned so, make it a keyframe, keep its landmarks."""
        self.look(turn)
        picture = self.points.pick(None, *NOBODY)
        number = len(self.map.turns)
        self.map.add(10 * number, turn)
        self.map.keep(picture, number, STILL, np.full(len(picture.ids), proved))
        return picture.ids

    def look(self, turn: Turn, seed: int = 0) -> None:
        self.points.look(rendered(SMALL, turn.R, turn.zoom, seed))


AWAY = Turn(turned(25.0), 1.0)
"""So far that nothing of the first keyframe is in view."""


def left_and_back(now: Turn, seed: int = 0) -> Film:
    """The first keyframe, one far away, and then a look at where it began."""
    film = Film.of()
    film.keyframe(Turn.none())
    film.map.tie(0, AWAY, SURE)
    film.keyframe(AWAY)
    film.look(now, seed)
    return film


BACK = {
    "as it was": Turn.none(),
    "turned a little": Turn(turned(4.0, -2.0, 3.0), 1.0),
    "zoomed": Turn(turned(1.0), 1.2),
}


@pytest.mark.parametrize("name", BACK)
def test_landmarks_that_return_tell_the_turn_and_tie_it_to_their_keyframe(name: str) -> None:
    true = BACK[name]
    film = left_and_back(true)
    drifted = Turn(turned(0.3, -0.2) @ true.R, 1.01 * true.zoom)
    turn, ids, uv = film.map.close_loops(drifted, STILL, None)
    assert off_deg(turn.R[None], [true.R]).max() < 0.05
    assert turn.zoom == pytest.approx(true.zoom, rel=2e-3)
    assert len(ids) > 30
    rays = LENS.directions(uv, true.zoom) @ true.R
    marks = film.map.landmarks
    anchored = marks.uv[np.searchsorted(marks.ids, ids)]
    away = np.linalg.norm(rays - LENS.directions(anchored, 1.0), axis=1) * SMALL.fx
    assert np.median(away) < 0.3
    (closed,) = (edge for edge in film.map.edges if edge.closes_loop)
    assert (closed.source, closed.target) == (0, 2)
    assert off_deg(closed.turn.R[None], [true.R]).max() < 0.05


def untouched(film: Film, expected: Turn, usable: NDArray[np.bool_] | None = None) -> bool:
    """Whether no loop is closed, and the turn left as it was expected."""
    turn, ids, _ = film.map.close_loops(expected, STILL, usable)
    closed = any(edge.closes_loop for edge in film.map.edges)
    return turn is expected and not len(ids) and not closed


def test_where_nothing_of_old_is_in_view_no_loop_is_closed() -> None:
    elsewhere = Turn(turned(-45.0), 1.0)
    assert untouched(left_and_back(elsewhere), elsewhere)


def test_another_scene_is_not_taken_for_what_was_seen() -> None:
    assert untouched(left_and_back(Turn.none(), seed=5), Turn.none())


def test_where_something_hides_them_landmarks_are_not_looked_for() -> None:
    hidden = np.zeros((180, 320), bool)
    assert untouched(left_and_back(Turn.none()), Turn.none(), hidden)


def test_a_zoom_too_far_from_theirs_shows_landmarks_otherwise() -> None:
    true = Turn(np.eye(3), 1.45)
    assert untouched(left_and_back(true), true)


def test_the_latest_keyframe_is_no_loop_to_close() -> None:
    film = Film.of()
    film.keyframe(Turn.none())
    film.look(Turn.none())
    assert untouched(film, Turn.none())


def test_points_that_have_not_proved_themselves_are_no_landmarks() -> None:
    film = Film.of()
    film.keyframe(Turn.none(), proved=False)
    assert len(film.map.landmarks) == 0


def test_a_landmark_is_kept_once_at_its_first_keyframe() -> None:
    film = Film.of()
    ids = film.keyframe(Turn.none())
    picture = film.points.keyframe
    assert picture is not None
    film.map.add(10, Turn.none())
    film.map.keep(picture, 1, STILL, np.ones(len(ids), bool))
    np.testing.assert_array_equal(film.map.landmarks.ids, ids)
    assert (film.map.landmarks.anchor == 0).all()


def test_a_returned_loop_takes_out_the_drift_of_all_keyframes() -> None:
    film, drift = Film.of(), turned(0.05, 0.02)
    pans = [0.0, 12.0, 24.0, 12.0]
    estimate = Turn.none()
    film.keyframe(estimate)
    for before, after in pairwise(pans):
        step = Turn(drift @ turned(after - before), 1.0)
        film.map.tie(len(film.map.turns) - 1, step, SURE)
        estimate = estimate.then(step)
        film.look(Turn(turned(after), 1.0))
        picture = film.points.pick(None, *NOBODY)
        film.map.add(0, estimate)
        film.map.keep(picture, len(film.map.turns) - 1, STILL, np.ones(len(picture.ids), bool))
    film.map.tie(3, Turn(drift @ turned(-12.0), 1.0), SURE)
    film.look(Turn.none())
    estimate = estimate.then(Turn(drift @ turned(-12.0), 1.0))
    found, _, _ = film.map.close_loops(estimate, STILL, None)
    film.map.add(0, found)
    true = [turned(pan) for pan in [*pans, 0.0]]
    off: Array = off_deg(np.stack([turn.R for turn in film.map.optimised()]), true)
    assert off.max() < 0.08
    assert off_deg(estimate.R[None], [np.eye(3)]).max() > 0.19


def test_a_scene_that_nothing_ties_follows_and_decides_nothing() -> None:
    film = left_and_back(Turn.none())
    far = Turn(turned(77.0), 1.0)
    film.map.follow_untied(1, AWAY)
    film.map.tie(0, far, SURE)
    film.map.add(20, far)
    turns = film.map.optimised()
    for turn, true in zip(turns[1:], (AWAY, far), strict=True):
        assert off_deg(turn.R[None], [true.R]).max() < 1e-3
