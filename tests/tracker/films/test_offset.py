"""Two films of one motion are laid side by side in time, and their cameras found, from it alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.films.cameras import find_camera, lengths_of
from keypose.tracker.films.offset import OffsetSearch, find_offsets
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.geometry.rotations import rotation_from_euler
from tests.rendering.motions import crossing, speech, stride, throw
from tests.tracker.films.film_cases import (
    BODY,
    TwoFilms,
    one_after_another,
    places_apart_m,
    sliced,
    turned_apart_deg,
    two_films,
)

LENGTHS_M = lengths_of(BODY)
CASES = [
    (throw, 60.0, FilmClock(3.4)),
    (throw, -45.0, FilmClock(-7.3, 0.5)),
    (throw, 90.0, FilmClock(12.0)),
    (throw, 60.0, FilmClock(5.6, 1.2)),
]


def found_in(films: TwoFilms, **more: object) -> tuple:
    search = OffsetSearch(films.first, films.film, 30.0, LENGTHS_M, **more)  # type: ignore[arg-type]
    return find_offsets(search, films.clock.rate)


@pytest.mark.parametrize(("motion", "turned_deg", "clock"), CASES)
def test_when_a_film_was_taken_and_where_its_camera_stands_are_found_from_the_body(
    motion: object, turned_deg: float, clock: FilmClock
) -> None:
    films = two_films(motion, turned_deg, clock)  # type: ignore[arg-type]
    best = found_in(films)[0]
    assert abs(best.clock.begins - clock.begins) < 0.5
    assert turned_apart_deg(best.camera.T_camera_first, films.T_film_first) < 6.0
    assert places_apart_m(best.camera.T_camera_first, films.T_film_first) < 0.9


@pytest.mark.parametrize("in_hand", [(False, True), (True, False), (True, True)])
def test_cameras_that_are_carried_along_known_paths_are_found_in_their_bases(
    in_hand: tuple[bool, bool],
) -> None:
    off = []
    for held in ((False, False), in_hand):
        films = two_films(throw, 60.0, FilmClock(3.4), in_hand=held)
        best = found_in(films)[0]
        assert abs(best.clock.begins - 3.4) < 0.5
        T = best.camera.T_camera_first
        off.append((turned_apart_deg(T, films.T_film_first), places_apart_m(T, films.T_film_first)))
    assert off[1][0] < off[0][0] + 3.0
    assert off[1][1] < off[0][1] + 0.3


def test_where_a_motion_repeats_itself_sound_says_which_time_it_was() -> None:
    films = two_films(stride, 60.0, FilmClock(3.4))
    silent = found_in(films)
    assert len(silent) > 1
    (only,) = found_in(films, heard=3.9)
    assert abs(only.clock.begins - 3.4) < 1.0
    elsewhere = found_in(films, heard=300.0)  # of another event: nothing moves as it says
    assert [each.clock for each in elsewhere] == [each.clock for each in silent]


def test_how_long_the_unit_of_a_camera_s_way_is_is_found_from_the_body() -> None:
    films = two_films(throw, 60.0, FilmClock(3.4), in_hand=(False, True))
    path = films.film.path
    assert path is not None
    Ts, unit_m = path.Ts_camera_world.copy(), 2.5
    unit_shift = Ts[:, :3, 3] / unit_m
    Ts[:, :3, 3] = 0.0
    turned = replace(films.film, path=CameraPath(Ts, path.zoom), unit_shift=unit_shift)
    best = found_in(replace(films, film=turned))[0]
    assert best.camera.metres == pytest.approx(unit_m, rel=0.25)
    assert turned_apart_deg(best.camera.T_camera_first, films.T_film_first) < 6.0


def test_who_takes_a_carried_camera_to_stand_still_is_wrong_of_it() -> None:
    films = two_films(throw, 60.0, FilmClock(3.4), in_hand=(False, True))
    as_still = replace(films, film=replace(films.film, path=None))
    known, unknown = (found_in(each) for each in (films, as_still))
    assert not unknown or unknown[0].cost > 1.5 * known[0].cost


def test_its_plus_minus_covers_how_far_it_is_off() -> None:
    off, sigmas = [], []
    for seed in range(6):
        films = two_films(throw, 60.0, FilmClock(3.4), seed=seed)
        best = found_in(films)[0]
        off.append(best.clock.begins - 3.4)
        sigmas.append(best.sigma)
    sizes = np.abs(off) / sigmas
    assert np.median(sizes) < 1.5
    assert sizes.max() < 3.5


@pytest.mark.parametrize("motion", [crossing, stride])
@pytest.mark.parametrize("turned_deg", [60.0, 90.0])
def test_where_the_motion_repeats_itself_every_likely_moment_is_kept(
    motion: object, turned_deg: float
) -> None:
    films = two_films(motion, turned_deg, FilmClock(4.0))  # type: ignore[arg-type]
    begins = [each.clock.begins for each in found_in(films)]
    assert any(abs(each - 4.0) < 1.0 for each in begins)
    assert len(begins) > 1


def test_films_of_two_motions_have_no_moment_in_common() -> None:
    thrown, crossed = two_films(throw, 60.0, FilmClock()), two_films(crossing, 60.0, FilmClock())
    assert found_in(replace(thrown, film=crossed.film)) == ()


def test_a_film_in_which_nobody_is_seen_tells_nothing() -> None:
    films = two_films(throw, 60.0, FilmClock())
    unseen = np.full_like(films.first.xy, np.nan)
    nobody = replace(films.first, xy=unseen, visibility=0 * films.first.visibility)
    assert found_in(replace(films, film=nobody)) == ()
    assert find_camera(films.first, nobody, LENGTHS_M) is None


def test_a_lens_that_is_a_guess_is_found_with_the_camera() -> None:
    films = two_films(throw, 70.0, FilmClock(), focal=0.85)
    search = OffsetSearch(films.first, films.film, 30.0, LENGTHS_M, (False, True))
    camera = search.camera_at(FilmClock())
    assert camera is not None
    assert abs(camera.focal - 0.85) < 0.06
    assert turned_apart_deg(camera.T_camera_first, films.T_film_first) < 6.0


@pytest.mark.parametrize("unit", [1.0, 1000.0])
def test_a_calibration_in_any_unit_is_where_one_begins_and_is_refined(unit: float) -> None:
    films = two_films(throw, 60.0, FilmClock(3.4))
    touched = films.T_film_first.copy()
    touched[:3, :3] = rotation_from_euler(0.03, 0.05, -0.04) @ touched[:3, :3]
    touched[:3, 3] *= unit
    best = found_in(films, start=touched)[0]
    assert abs(best.clock.begins - 3.4) < 0.5
    assert turned_apart_deg(best.camera.T_camera_first, films.T_film_first) < 3.0
    assert places_apart_m(best.camera.T_camera_first, films.T_film_first) < 0.5


def test_a_posed_keyframe_tells_where_the_camera_is_where_the_network_knows_no_depth() -> None:
    films = two_films(throw, 60.0, FilmClock())
    flat = replace(films.first, p_hips=np.full_like(films.first.p_hips, np.nan))
    film = films.film.at(FilmClock(), np.arange(len(flat)))
    camera = find_camera(flat, film, LENGTHS_M, keyed={40: films.joints[40]})
    assert camera is not None
    assert turned_apart_deg(camera.T_camera_first, films.T_film_first) < 6.0


LONG = one_after_another(throw, crossing, speech, stride)
"""19 s at 30 frames a second."""


@pytest.mark.parametrize("said", [1.0, 0.5])
@pytest.mark.parametrize("faster", [1.01, 0.985, 1.004, 0.99])
def test_a_clock_that_runs_otherwise_than_the_files_say_is_found(
    said: float, faster: float
) -> None:
    films = two_films(LONG, 60.0, FilmClock(5.3, said * faster))
    search = OffsetSearch(films.first, films.film, 30.0, LENGTHS_M)
    best = find_offsets(search, said)[0]
    moments = np.arange(len(LONG))
    off = np.abs(best.clock.frames_at(moments) - films.clock.frames_at(moments)) / said
    assert off.max() < 0.6
    assert best.clock.rate == pytest.approx(said * faster, rel=1e-3)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("motion", [throw, LONG], ids=["4 s", "19 s"])
def test_a_clock_that_runs_as_the_files_say_keeps_their_rate(motion: object, seed: int) -> None:
    films = two_films(motion, 60.0, FilmClock(5.3), seed=seed)  # type: ignore[arg-type]
    assert found_in(films)[0].clock.rate == 1.0


@pytest.mark.parametrize("motions", [(throw, stride), (speech, throw), (stride, speech)])
def test_a_film_of_another_motion_of_the_same_person_is_refused(motions: tuple) -> None:
    first, film = (two_films(motion, 60.0, FilmClock()) for motion in motions)
    assert found_in(replace(first, film=film.film)) == ()


def test_films_of_two_parts_of_a_motion_have_no_moment_in_common() -> None:
    joints = one_after_another(throw, crossing)
    whole = two_films(joints, 60.0, FilmClock())
    begins, ends = (sliced(film, rows) for film, rows in
                    ((whole.first, slice(0, 110)), (whole.film, slice(150, None))))  # fmt: skip
    assert found_in(replace(whole, first=begins, film=ends)) == ()


@pytest.mark.parametrize("is_first_long", [True, False])
def test_a_long_film_of_other_motions_is_refused_however_little_both_may_overlap(
    is_first_long: bool,
) -> None:
    short = two_films(throw, 60.0, FilmClock())
    long = two_films(one_after_another(speech, crossing, speech), 60.0, FilmClock())
    first, film = (long.first, short.film) if is_first_long else (short.first, long.film)
    assert found_in(replace(short, first=first, film=film)) == ()
