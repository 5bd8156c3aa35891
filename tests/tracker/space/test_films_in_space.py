"""What another film shows of a motion holds it as well where it is solved for in space."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.geometry.rotations import Array, rotation_from_euler, transform
from keypose.tracker.operations.solve_space import films_in_space
from keypose.tracker.session.between_views import T_film_first
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.views import Clock
from keypose.tracker.solver.projection import image_points
from keypose.tracker.space.harm import Compared, InPicture, harms
from keypose.tracker.space.solve import FilmInSpace, heights_before, solve_space
from tests.app.film_beside_cases import with_film
from tests.rendering.scenes import Scene
from tests.tracker.session_cases import session
from tests.tracker.space.space_cases import farther, pinned_foot, problem, reach_far, standing

FRAMES = 61
SHOWN = reach_far(standing(FRAMES))
BOW = 0.08 * np.sin(np.pi * np.linspace(0, 1, FRAMES))
TRACKED = farther(SHOWN.truth, BOW)
"""The body drifts along the first film's view, and another film shows that it does."""
PINS = pinned_foot(SHOWN, 2, 58)
LEFT = Pin(part="left_foot", landmarks=("left_heel", "left_toe"), first_frame=2, last_frame=58)


def side(turned_deg: float = 70.0, away_m: float = 0.0) -> FilmInSpace:
    """A film of the side, its camera so far behind where one would stand."""
    middle = SHOWN.truth.ps_camera_root.mean(axis=0)
    R = rotation_from_euler(0.0, np.radians(turned_deg), 0.0)
    T = transform(R, middle - R @ middle + np.array([0.0, 0.0, away_m]))
    return FilmInSpace(
        SHOWN.camera, np.broadcast_to(T, (FRAMES, 4, 4)).copy(), np.ones(FRAMES, np.bool_)
    )


def moved_px(film: FilmInSpace, motion: Trajectory) -> float:
    """By how much joints are seen elsewhere by a film, mean over those of the whole body."""
    uv = [_seen(film, SHOWN, each) for each in (motion, TRACKED)]
    return float(np.linalg.norm(uv[0] - uv[1], axis=-1).mean())


def _seen(film: FilmInSpace, shown: Scene, motion: Trajectory) -> Array:
    return image_points(film.camera, motion.carried(film.Ts_film_first).joints(shown.skeleton))


def test_a_motion_that_another_film_shows_is_hardly_moved_in_it() -> None:
    film = side()
    alone, both = (
        solve_space(problem(SHOWN, TRACKED, pins=PINS, films=films)).motion
        for films in ((), (film,))
    )
    assert moved_px(film, alone) > 1.0
    assert moved_px(film, both) < 0.5 * moved_px(film, alone)


@pytest.mark.parametrize("why", ["not running", "behind it", "beside its picture"])
def test_a_film_that_does_not_show_the_body_says_nothing_of_it(why: str) -> None:
    film = {
        "not running": replace(side(), shows=np.zeros(FRAMES, np.bool_)),
        "behind it": side(away_m=-30.0),
        "beside its picture": replace(
            side(), camera=SHOWN.camera.model_copy(update={"cx": SHOWN.camera.cx + 5000.0})
        ),
    }[why]
    alone, both = (
        solve_space(problem(SHOWN, TRACKED, pins=PINS, films=films)).motion
        for films in ((), (film,))
    )
    np.testing.assert_allclose(both.ps_camera_root, alone.ps_camera_root, atol=1e-9)


def test_what_a_pin_moves_in_another_film_alone_is_harm_of_as_many_pixels() -> None:
    film, size = side(90.0), (SHOWN.skeleton, SHOWN.camera)
    solved = farther(SHOWN.truth, np.full(FRAMES, 0.15))
    seen = [each.carried(film.Ts_film_first) for each in (SHOWN.truth, solved)]
    heights = heights_before(*size, seen[0])
    beside = InPicture(*size, *seen, heights, film.shows)
    in_first = Compared(*size, SHOWN.truth, solved, np.full(FRAMES, 300.0))
    picture = {
        name: next(harm for harm in harms(each, [LEFT]) if harm.kind == "picture")
        for name, each in (("one", in_first), ("two", replace(in_first, films=(beside,))))
    }
    assert not picture["one"].is_much
    assert picture["two"].is_too_much
    depth = float(seen[0].ps_camera_root[:, 2].mean())
    assert picture["two"].amount == pytest.approx(0.15 * SHOWN.camera.fx / depth, rel=0.15)
    unseen = replace(beside, shows=np.zeros(FRAMES, np.bool_))
    unharmed = harms(replace(in_first, films=(unseen,)), [LEFT])
    assert [harm.share for harm in unharmed] == [harm.share for harm in harms(in_first, [LEFT])]


def test_a_film_is_compared_at_the_frames_at_which_it_ran() -> None:
    clock = Clock(begins=3.4, rate=1.0)
    two = with_film(session(), clock)
    (film,) = films_in_space(two, 1, 8)
    count = two.views[1].video.frame_count
    own = FilmClock(3.4).frames_at(np.arange(1, 9))
    np.testing.assert_array_equal(film.shows, (own >= 0) & (own <= count - 1))
    np.testing.assert_array_equal(film.Ts_film_first[3], T_film_first(two, two.views[1], 4))
    assert films_in_space(session(), 1, 8) == ()
